//! A web server for one file, on this machine: ranges, versions, and a record of what it was asked for.

use std::io::{BufRead, BufReader, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::thread;

/// What the server gives, and what it was asked for.
#[derive(Default)]
pub struct State {
    /// The file.
    pub bytes: Vec<u8>,
    /// Its version; none is sent if empty.
    pub tag: String,
    /// Whether parts are served; otherwise every answer is the whole file.
    pub whole_only: bool,
    /// What was sent, in order.
    pub sent: Vec<Range<usize>>,
    /// Answers that are errors before the next real one.
    pub failures: u32,
    /// Answers that end in the middle, with the connection, before the next whole one.
    pub cuts: u32,
}

/// A running server. Its thread ends with the test program.
#[derive(Clone)]
pub struct Server {
    port: u16,
    pub state: Arc<Mutex<State>>,
}

impl Server {
    /// Serves these bytes.
    pub fn start(bytes: Vec<u8>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let state = Arc::new(Mutex::new(State { bytes, tag: "\"one\"".into(), ..State::default() }));
        let server = Self { port, state: Arc::clone(&state) };
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let state = Arc::clone(&state);
                thread::spawn(move || while answer(&stream, &state).is_some() {});
            }
        });
        server
    }

    /// Where the file is.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/folder/orbit.rtrace?key=secret", self.port)
    }

    /// What was sent since this was last asked.
    pub fn sent(&self) -> Vec<Range<usize>> {
        std::mem::take(&mut self.state.lock().unwrap().sent)
    }
}

/// Answers one request of a connection; none if it was closed.
fn answer(mut stream: &TcpStream, state: &Mutex<State>) -> Option<()> {
    let mut lines = BufReader::new(stream).lines();
    let request = lines.next()?.ok()?;
    let mut range = None;
    for line in lines.map_while(Result::ok).take_while(|line| !line.is_empty()) {
        if let Some(("range", value)) = line.to_ascii_lowercase().split_once(": ") {
            range = Some(value.trim().strip_prefix("bytes=").unwrap().to_string());
        }
    }
    let mut state = state.lock().unwrap();
    let size = state.bytes.len();
    let range = match range.as_deref().and_then(|range| range.split_once('-')) {
        Some(("", len)) => size.saturating_sub(len.parse().unwrap())..size,
        Some((start, end)) => start.parse().unwrap()..end.parse::<usize>().unwrap() + 1,
        None => 0..size,
    };
    let tag = if state.tag.is_empty() { String::new() } else { format!("ETag: {}\r\n", state.tag) };
    let (head, body) = if state.failures > 0 {
        state.failures -= 1;
        ("HTTP/1.1 503 Service Unavailable\r\n".to_string(), Vec::new())
    } else if !request.starts_with("GET /folder/orbit.rtrace?key=secret ") {
        ("HTTP/1.1 404 Not Found\r\n".to_string(), Vec::new())
    } else if state.whole_only {
        (format!("HTTP/1.1 200 OK\r\n{tag}"), state.bytes.clone())
    } else {
        state.sent.push(range.clone());
        let (first, last) = (range.start, range.end - 1);
        let head = format!("HTTP/1.1 206 Partial Content\r\nContent-Range: bytes {first}-{last}/{size}\r\n{tag}");
        (head, state.bytes[range].to_vec())
    };
    let is_cut = state.cuts > 0 && head.starts_with("HTTP/1.1 206");
    state.cuts -= u32::from(is_cut);
    drop(state);
    stream.write_all(format!("{head}Content-Length: {}\r\n\r\n", body.len()).as_bytes()).ok()?;
    stream.write_all(&body[..if is_cut { body.len() / 2 } else { body.len() }]).ok()?;
    if is_cut { stream.shutdown(Shutdown::Both).ok().and(None) } else { Some(()) }
}
