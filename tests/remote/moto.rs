//! An S3 endpoint on this machine: the server of the Python package moto.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Ran, command};

/// A running endpoint. It ends when this is dropped.
pub struct Moto {
    child: Child,
    port: u16,
}

impl Drop for Moto {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

impl Moto {
    /// Starts one; none, saying so, where moto is not installed.
    pub fn start() -> Option<Self> {
        // Through Python, so that what is killed is the server and not a script that started it.
        let serve = "from moto.server import main; main()";
        let probe = Command::new("python3").args(["-c", "import moto.server"]).stderr(Stdio::null()).status();
        if !probe.is_ok_and(|status| status.success()) {
            eprintln!("skipped: no moto here; pip install 'moto[s3]' flask flask-cors");
            return None;
        }
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let mut python = Command::new("python3");
        python.args(["-c", serve, "-H", "127.0.0.1", "-p", &port.to_string()]);
        let child = python.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let moto = Self { child, port };
        let start = Instant::now();
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(start.elapsed() < Duration::from_secs(120), "moto does not start");
            std::thread::sleep(Duration::from_millis(50));
        }
        Some(moto)
    }

    /// `http://host:port`.
    pub fn endpoint(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    /// Makes a bucket (`/bucket`) or an object (`/bucket/name`).
    pub fn put(&self, path: &str, body: &[u8]) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let head = format!(
            "PUT {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nx-amz-acl: public-read\r\nContent-Length: {}\r\n\
             Connection: close\r\n\r\n",
            self.port,
            body.len()
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.lines().next().unwrap().contains("200"), "PUT {path}: {answer}");
    }

    /// Runs the binary with this endpoint and some credentials; `line` is split at blanks.
    pub fn run(&self, line: &str) -> Ran {
        run(line, &self.endpoint(), "none")
    }
}

/// Runs the binary with an endpoint and a cache folder; `line` is split at blanks.
pub fn run(line: &str, endpoint: &str, cache: &str) -> Ran {
    let args: Vec<_> = line.split_whitespace().map(Into::into).collect();
    let mut command = command(&args);
    command.envs([("AWS_ACCESS_KEY_ID", "test"), ("AWS_SECRET_ACCESS_KEY", "test"), ("AWS_ALLOW_HTTP", "true")]);
    command.envs([("AWS_ENDPOINT_URL", endpoint), ("AWS_REGION", "us-east-1"), ("RAYREEL_TRACE_CACHE", cache)]);
    let output = command.output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let code = output.status.code().unwrap_or(-1);
    Ran { what: line.to_string(), code, out: text(&output.stdout), err: text(&output.stderr) }
}
