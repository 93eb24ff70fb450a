//! `rayreel anchors`: figures that publications put between bounds, measured.

use anyhow::{Result, bail};
use rayreel_paper::anchors::{self, Measured};
use rayreel_settings::near;
use rayreel_study::pool::Pool;
use serde_json::json;

use crate::common::{print, print_json};
use crate::exit::Exit;
use crate::progress::{self, Progress};

/// Measure every figure that a publication or an estimate bounds, and say why one lies outside.
///
/// Simulates the first frames of the paper's five scenes, 2x2 samples a pixel, on the machines that anchors are stated for. Prints of
/// each anchor its bounds, the measured value and whether it lies inside; then why those outside do, and the sources. Nothing is
/// written. The exit code is 1 if an anchor lies outside and nothing explains it.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only the anchors of this preset. Can be repeated.
    #[arg(long = "machine", value_name = "NAME")]
    machines: Vec<String>,
    /// Image size in pixels. Small pictures mostly measure cold caches.
    #[arg(long, default_value = "128x64", value_name = "WxH", value_parser = crate::common::size)]
    size: (u32, u32),
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    args.machines.iter().try_for_each(|name| check(name))?;
    let pool = Pool { threads: rayon::current_num_threads(), stop: progress::stop_on_signal() };
    let mut bar: Option<Progress> = None;
    let measured = anchors::measure(args.size, &args.machines, &pool, &mut |done, all, scene| {
        bar.get_or_insert_with(|| Progress::new("anchors", all, quiet)).set(done, || scene.to_owned());
    });
    if let Some(bar) = bar {
        bar.finish();
    }
    let rows = match measured {
        Err(error) if error.is_interruption() => {
            tell!("interrupted");
            return Ok(Exit::Interrupted);
        }
        rows => rows?,
    };
    if args.json {
        print_json(&json!(rows))?
    } else {
        print(&anchors::text(&rows, args.size))?
    }
    Ok(if rows.iter().any(Measured::fails) { Exit::No } else { Exit::Done })
}

/// Anchors are stated for presets alone: no file will do.
fn check(name: &str) -> Result<()> {
    let known = anchors::machines();
    if !known.contains(&name) {
        bail!("no anchor is stated for the machine {name}; {}", near(name, &known));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_without_anchors_is_refused_with_those_that_were_meant() {
        let said = |name: &str| check(name).unwrap_err().to_string();
        assert!(said("sgrt-ti3").ends_with("; did you mean sgrt-ti2 or sgrt-ti1?"), "{}", said("sgrt-ti3"));
        assert!(said("nosuch").contains("; there are sgrt-ti2, ") && !said("nosuch").contains(".toml"));
        assert!(check("raycore").is_ok() && check("raycore.toml").is_err());
    }
}
