//! What coherence over time brings: a table of the sweep over sixty frames of three flights.
//!
//! ```console
//! $ cargo run --release --example flight -- flight.sweep/results.csv
//! ```
//!
//! prints it as Markdown, of the scenes that are there. `examples/sweeps/flight.toml` says how to get the results. Performance per watt is over that of `full` with
//! the same caches.

use std::collections::BTreeMap;
use std::error::Error;

type Point = BTreeMap<String, String>;

/// Scenes in the order of the README, and policies with their blocks; no block where a policy has none of its own.
const SCENES: [&str; 3] = ["teapot", "lab", "provence"];
const RATES: [(&str, &str, &str); 6] = [
    ("paper-ss", "", "`paper-ss`"),
    ("multirate", "2", "one block of 2"),
    ("multirate", "4", "one block of 4"),
    ("multirate", "8", "one block of 8"),
    ("multirate", "feedback", "`multirate`"),
    ("temporal", "", "`temporal`"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give results.csv of the sweep")?;
    let read = || csv::Reader::from_path(&path)?.deserialize().collect::<Result<Vec<Point>, _>>();
    let points = read().map_err(|error| format!("{path}: {error}"))?;
    println!(
        "| scene | policy | rays, % | PSNR, dB | worst frame | flicker | FLIP | T&I perf/W, warm (cold) | whole GPU perf/W, warm (cold) |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let there = |scene: &&str| points.iter().any(|point| point.get("scene").is_some_and(|found| found == scene));
    for scene in SCENES.into_iter().filter(there) {
        for (i, (policy, rate, name)) in RATES.into_iter().enumerate() {
            let warm =
                find(&points, scene, policy, (rate, "warm")).ok_or_else(|| format!("no {scene} under {name}"))?;
            let rays = (number(warm, "rays_traced")? + number(warm, "rays_apron")?) / number(warm, "rays_full")?;
            let figure = |name: &str, places: usize| number(warm, name).map(|value| format!("{value:.places$}"));
            println!(
                "| {} | {name} | {:.1} | {} | {} | {} | {} | {} | {} |",
                if i == 0 { scene } else { "" },
                100.0 * rays,
                figure("psnr_db", 2)?,
                figure("worst_frame_psnr_db", 2)?,
                figure("flicker", 2)?,
                figure("flip", 4)?,
                gain(&points, scene, (policy, rate), "perf_per_watt")?,
                gain(&points, scene, (policy, rate), "gpu_perf_per_watt")?,
            );
        }
    }
    Ok(())
}

fn find<'a>(points: &'a [Point], scene: &str, policy: &str, (rate, caches): (&str, &str)) -> Option<&'a Point> {
    let is = |point: &Point, name: &str, value: &str| point.get(name).is_some_and(|found| found == value);
    let parts = [("scene", scene), ("policy", policy), ("rate", rate), ("caches", caches)];
    points.iter().find(|point| parts.into_iter().all(|(name, value)| is(point, name, value)))
}

fn number(point: &Point, name: &str) -> Result<f64, Box<dyn Error>> {
    Ok(point.get(name).ok_or_else(|| format!("no column {name}"))?.parse()?)
}

/// A figure over that of `full`, with warm caches and, where it was simulated, with cold ones.
fn gain(points: &[Point], scene: &str, (policy, rate): (&str, &str), name: &str) -> Result<String, Box<dyn Error>> {
    let over = |caches: &str| -> Result<Option<f64>, Box<dyn Error>> {
        let pair = (find(points, scene, policy, (rate, caches)), find(points, scene, "full", ("", caches)));
        let (Some(point), Some(full)) = pair else { return Ok(None) };
        Ok(Some(number(point, name)? / number(full, name)?))
    };
    let warm = over("warm")?.ok_or_else(|| format!("no {scene} under full"))?;
    Ok(over("cold")?.map_or(format!("{warm:.2}"), |cold| format!("{warm:.2} ({cold:.2})")))
}
