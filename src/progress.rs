//! Progress on standard error: a bar on a terminal, plain lines where it is piped, nothing when quiet.

use std::io::IsTerminal;
#[cfg(unix)]
use std::sync::Arc;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use rayreel_replay::Stop;

use crate::exit::Exit;

/// The one request to stop that signals make: a process has one handler.
static SIGNAL: OnceLock<Stop> = OnceLock::new();

/// Whether somebody looks at the request.
static HEARD: AtomicBool = AtomicBool::new(false);

/// Handles Ctrl-C, SIGTERM and SIGHUP from now on. Until [`stop_on_signal`] is called one of them ends the process at once, with the
/// code of an interruption. No file is half written then, because each gets its name once it is whole; but nothing is cleaned up, so
/// one that is being written just then stays behind as `.NAME.PID-NUMBER.partial`, as after a kill. Commands that write for long
/// therefore look at the request, and clean up as they end; those that do not (`render`, `report`, `sweep merge`) write little.
pub fn handle_signals() {
    SIGNAL.get_or_init(|| {
        // A limit on the size of files (`ulimit -f`) ends a process by a signal, without a word. Where that is handled, the file gets
        // an error as on a full disk, and who writes it says which file.
        #[cfg(unix)]
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
        let stop = Stop::default();
        let handle = stop.clone();
        // Without a handler a signal ends the process at once, too, with a code of the system.
        let _ = ctrlc::set_handler(move || {
            handle.request();
            if !HEARD.load(Ordering::SeqCst) {
                tell!("interrupted");
                std::process::exit(Exit::Interrupted as i32);
            }
        });
        stop
    });
}

/// What Ctrl-C, SIGTERM and SIGHUP request: from now on the caller looks at it, and ends in its own way.
pub fn stop_on_signal() -> Stop {
    handle_signals();
    HEARD.store(true, Ordering::SeqCst);
    SIGNAL.get().cloned().unwrap_or_default()
}

/// Plain lines come at most this often.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// How far something is.
pub enum Progress {
    /// A bar that redraws.
    Bar(ProgressBar),
    /// Lines.
    Lines {
        /// What is being done.
        what: String,
        /// Where it ends.
        total: u64,
        /// When it began.
        start: Instant,
        /// When the last line was printed.
        last: Instant,
    },
    /// Nothing.
    Quiet,
}

impl Progress {
    /// Starts on `total` steps of `what`.
    pub fn new(what: &str, total: u64, quiet: bool) -> Self {
        if quiet {
            return Self::Quiet;
        }
        if !std::io::stderr().is_terminal() {
            let now = Instant::now();
            return Self::Lines { what: what.to_string(), total, start: now, last: now };
        }
        let style = ProgressStyle::with_template("{prefix} {wide_bar} {percent:>3} %  {msg}  ETA {eta}");
        let bar = ProgressBar::new(total).with_prefix(what.to_string());
        Self::Bar(bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())))
    }

    /// Tells that `done` steps are done; `message` says what else is worth knowing.
    pub fn set(&mut self, done: u64, message: impl FnOnce() -> String) {
        match self {
            Self::Bar(bar) => {
                bar.set_message(message());
                bar.set_position(done);
            }
            Self::Lines { what, total, start, last } => {
                if last.elapsed() < LINE_EVERY || done == 0 {
                    return;
                }
                *last = Instant::now();
                let left = start.elapsed().mul_f64((*total - done.min(*total)) as f64 / done as f64);
                let percent = 100 * done / (*total).max(1);
                tell!("{what}: {percent} %, {}, {} s left", message(), left.as_secs());
            }
            Self::Quiet => {}
        }
    }

    /// Prints a line that stays.
    pub fn say(&self, line: &str) {
        match self {
            Self::Bar(bar) => bar.println(line),
            Self::Lines { .. } => tell!("{line}"),
            Self::Quiet => {}
        }
    }

    /// Takes the bar away.
    pub fn finish(self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
