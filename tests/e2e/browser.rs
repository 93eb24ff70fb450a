//! A browser without a window, driven over the WebDriver protocol: just enough of it for the report's test.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tempfile::TempDir;

/// Origin browsers that can be driven are called.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// No window, no network, and nothing left over from another run.
const FLAGS: [&str; 9] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
];

/// A browser with one page. It ends when this is dropped.
pub struct Browser {
    driver: Child,
    port: u16,
    session: String,
    // The browser writes here until it has ended.
    _profile: TempDir,
}

fn installed(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.is_file())
}

impl Browser {
    /// Starts a browser; nothing where none is installed.
    pub fn start() -> Option<Self> {
        let binary = BROWSERS.iter().find_map(|name| installed(name))?;
        let mut driver = Command::new(installed("chromedriver")?)
            .arg("--port=0")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(driver.stdout.take().unwrap()).lines();
        let port = lines
            .find_map(|line| line.unwrap().split("successfully on port ").nth(1)?.trim_end_matches('.').parse().ok());
        // Whatever else it prints must be read, or it would block.
        std::thread::spawn(move || lines.for_each(drop));
        let profile = tempfile::tempdir().unwrap();
        let mut browser = Self { driver, port: port.unwrap(), session: String::new(), _profile: profile };
        let mut args: Vec<String> = FLAGS.map(String::from).into();
        args.push(format!("--user-data-dir={}", browser._profile.path().display()));
        let wanted = json!({ "goog:chromeOptions": { "binary": binary, "args": args }, "goog:loggingPrefs": { "browser": "ALL" } });
        let session = browser.call("POST", "/session", json!({ "capabilities": { "alwaysMatch": wanted } }));
        browser.session = format!("/session/{}", session["sessionId"].as_str().unwrap());
        Some(browser)
    }

    /// One request to the driver; its answer. Panics with the driver's message if it refuses.
    #[track_caller]
    fn call(&self, method: &str, path: &str, body: Value) -> Value {
        let (body, mut stream) = (body.to_string(), TcpStream::connect(("127.0.0.1", self.port)).unwrap());
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let length = body.len();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n"
        );
        stream.write_all((head + &body).as_bytes()).unwrap();
        let (mut reader, mut line, mut length) = (BufReader::new(stream), String::new(), 0);
        while reader.read_line(&mut line).unwrap() > 2 {
            if let Some(value) = line.to_ascii_lowercase().strip_prefix("content-length:") {
                length = value.trim().parse().unwrap();
            }
            line.clear();
        }
        let mut answer = vec![0; length];
        reader.read_exact(&mut answer).unwrap();
        let mut answer: Value = serde_json::from_slice(&answer).unwrap();
        let value = answer["value"].take();
        assert!(value["error"].is_null(), "{method} {path}: {value}");
        value
    }

    #[track_caller]
    fn post(&self, path: &str, body: Value) -> Value {
        self.call("POST", &format!("{}{path}", self.session), body)
    }

    /// Opens a file.
    #[track_caller]
    pub fn open(&self, file: &Path) {
        self.open_url(&format!("file://{}", file.display()));
    }

    /// Opens an address.
    #[track_caller]
    pub fn open_url(&self, url: &str) {
        self.post("/url", json!({ "url": url }));
    }

    /// Runs a script; what it returns.
    #[track_caller]
    pub fn run(&self, script: &str) -> Value {
        self.post("/execute/sync", json!({ "script": script, "args": [] }))
    }

    /// Gives the page so many pixels; `phone` makes it a touch screen.
    #[track_caller]
    pub fn resize(&self, width: u32, height: u32, phone: bool) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": phone });
        self.command("Emulation.setDeviceMetricsOverride", &size);
        self.command("Emulation.setTouchEmulationEnabled", &json!({ "enabled": phone }));
    }

    /// Shows the page as on this medium; an empty name is the screen.
    #[track_caller]
    pub fn media(&self, name: &str) {
        self.command("Emulation.setEmulatedMedia", &json!({ "media": name }));
    }

    #[track_caller]
    fn command(&self, name: &str, params: &Value) {
        self.post("/goog/cdp/execute", json!({ "cmd": name, "params": params }));
    }

    /// Moves the pointer to places of the window; pressed from the first to the last if `press`.
    #[track_caller]
    pub fn point(&self, places: &[[f64; 2]], press: bool) {
        let step = |[x, y]: [f64; 2]| json!({ "type": "pointerMove", "duration": 30, "x": x as i64, "y": y as i64 });
        let mut steps: Vec<Value> = places.iter().copied().map(step).collect();
        if press {
            steps.insert(1, json!({ "type": "pointerDown", "button": 0 }));
            steps.push(json!({ "type": "pointerUp", "button": 0 }));
        }
        self.post("/actions", json!({ "actions": [{ "type": "pointer", "id": "mouse", "actions": steps }] }));
    }

    /// Presses a key where the focus is.
    #[track_caller]
    pub fn key(&self, key: &str) {
        let steps = json!([{ "type": "keyDown", "value": key }, { "type": "keyUp", "value": key }]);
        self.post("/actions", json!({ "actions": [{ "type": "key", "id": "keyboard", "actions": steps }] }));
    }

    /// What the page has said on the console since the last call, uncaught exceptions included.
    #[track_caller]
    pub fn console(&self) -> Vec<String> {
        let entries = self.post("/se/log", json!({ "type": "browser" }));
        entries.as_array().unwrap().iter().map(|entry| format!("{}: {}", entry["level"], entry["message"])).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // A test that fails drops this while it unwinds: another panic would hide the first.
        if !std::thread::panicking() && !self.session.is_empty() {
            self.call("DELETE", &self.session, json!({}));
        }
        // The driver ends its browser when it is told to stop, not when it is killed.
        if let Ok(mut stream) = TcpStream::connect(("127.0.0.1", self.port)) {
            let _ = stream.write_all(b"GET /shutdown HTTP/1.1\r\nHost: localhost\r\n\r\n");
            let _ = stream.set_read_timeout(Some(Duration::from_secs(5)));
            let _ = stream.read(&mut [0; 64]);
        }
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
