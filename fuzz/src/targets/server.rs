//! What a server answers.

use std::cell::RefCell;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;

use rayreel_formats::trace::Codec;
use rayreel_store::{Options, open};

use crate::seeds;
use crate::target::{Target, told};

pub fn target() -> Target {
    Target { name: "server", seeds: answers, read: read_answer, change: None, mend: None }
}

/// Answers of a server: head and body.
fn answers() -> Vec<Vec<u8>> {
    let body = seeds::trace(Codec::Context);
    let (last, size) = (body.len() - 1, body.len());
    let answer = |head: String, body: &[u8]| [head.as_bytes(), b"\r\n\r\n", body].concat();
    vec![
        answer(
            format!(
                "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes 0-{last}/{size}\r\nETag: \"a\"\r\nLast-Modified: Wed, 21 Oct \
                 2015 07:28:00 GMT\r\nContent-Length: {size}"
            ),
            &body,
        ),
        answer("HTTP/1.1 404 Not Found\r\nContent-Length: 0".into(), &[]),
        answer(
            format!(
                "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes 0-{last}/{size}\r\nTransfer-Encoding: chunked"
            ),
            b"2\r\nab\r\n0\r\n\r\n",
        ),
        answer("HTTP/1.1 302 Found\r\nLocation: /elsewhere\r\nContent-Length: 0".into(), &[]),
    ]
}

/// A server that gives one answer to whatever it is asked.
struct Server {
    port: u16,
    answer: Arc<Mutex<Vec<u8>>>,
}

thread_local! {
    static SERVER: RefCell<Option<Server>> = const { RefCell::new(None) };
}

impl Server {
    fn start() -> std::io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let port = listener.local_addr()?.port();
        let answer: Arc<Mutex<Vec<u8>>> = Arc::default();
        let given = Arc::clone(&answer);
        thread::spawn(move || listener.incoming().flatten().for_each(|stream| give(&stream, &given)));
        Ok(Self { port, answer })
    }
}

fn give(mut stream: &TcpStream, answer: &Mutex<Vec<u8>>) {
    let lines = BufReader::new(stream).lines();
    lines.map_while(Result::ok).take_while(|line| !line.is_empty()).for_each(drop);
    let bytes = answer.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
    stream.write_all(&bytes).ok();
}

/// Opens a trace on a server that answers so. Each connection is closed after its answer, so no answer is waited for.
fn read_answer(bytes: &[u8]) -> String {
    SERVER.with_borrow_mut(|server| {
        let server = server.get_or_insert_with(|| Server::start().expect("a port of this machine"));
        *server.answer.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = bytes.to_vec();
        let options = Options { retries: 0, ..Options::default() };
        let opened = open(format!("http://127.0.0.1:{}/a.rtrace", server.port).as_str(), &options);
        let said = told(&opened.as_ref().map(|trace| trace.tile(0, 0, &rayreel_formats::tile::Column::ALL).is_ok()));
        let cause = opened.as_ref().err().and_then(std::error::Error::source);
        cause.map_or(said.clone(), |cause| format!("{said}: {cause}"))
    })
}
