//! How fast data get out of a trace: rows by table and kind of file.
//!
//! ```text
//! cargo bench -p rayreel --bench export                            chess at 512x256, 2x2 samples, depth 4
//! cargo bench -p rayreel --bench export -- --size 256x128 lab
//! cargo bench -p rayreel --bench export -- FILE.rtrace
//! ```
//!
//! Speeds are by the clock, all threads, the best of several rounds that take turns; files lie in a temporary folder and are forced
//! to its disk. "rows" makes the batches and drops them: what a file takes longer is its encoding and its disk. The last columns are
//! ratios to that, which hold on a noisy machine too, and bytes a row.

mod common;

use std::time::Instant;

use common::{size, trace};
use rayreel_columns::{Data, Encoder, Format, Result, Sink, Use, What};
use rayreel_formats::trace::Trace;
use rayreel_machine::NamedMachine;

const ROUNDS: usize = 3;

/// The tables that grow with the number of rays.
const TABLES: [What; 6] = [What::Rays, What::Hits, What::Steps, What::Addresses, What::Samples, What::Lookups];

/// Rows are made, and dropped.
fn made(data: &Data<'_>) -> Result<u64> {
    let mut rows = 0;
    let mut take = |count: usize, _| {
        rows += count as u64;
        Ok(())
    };
    data.run(Use { make: &|batch| Ok(batch.rows()), take: &mut take })?;
    Ok(rows)
}

/// Rows are made, and written.
fn written(data: &Data<'_>, format: Format, file: &std::path::Path) -> Result<u64> {
    let encoder = Encoder::new(format, data.head()?)?;
    let mut sink = Sink::file(&encoder, file)?;
    let mut take = |encoded, _| sink.append(encoded);
    data.run(Use { make: &|batch| encoder.encode(batch), take: &mut take })?;
    sink.finish()
}

fn bench(trace: &Trace) {
    let folder = tempfile::tempdir().expect("a folder");
    let machine = NamedMachine::load("sgrt-ti2", &[]).expect("a preset");
    println!(
        "  {:<10} {:>12} {:>10} {:>10} {:>10}   {:>16} {:>16}",
        "table", "rows", "Mrows/s", "parquet", "npy", "parquet: of rows", "npy: of rows"
    );
    for what in TABLES {
        let machine = what.takes_machine().then_some(&machine);
        let data = Data { machine, ..Data::new(trace, what) };
        let (mut rows, mut best) = (0, [f64::MAX; 3]);
        let files = [Format::Parquet, Format::Npy].map(|format| (format, folder.path().join(format.name())));
        for _ in 0..ROUNDS {
            let mut round = |i: usize, run: &dyn Fn() -> Result<u64>| {
                let start = Instant::now();
                rows = run().expect("a whole trace");
                best[i] = best[i].min(start.elapsed().as_secs_f64());
            };
            round(0, &|| made(&data));
            for (i, (format, file)) in files.iter().enumerate() {
                round(i + 1, &|| written(&data, *format, file));
            }
        }
        let speeds = best.map(|seconds| rows as f64 / seconds / 1e6);
        let [parquet, npy] = [0, 1].map(|i| {
            let bytes = std::fs::metadata(&files[i].1).expect("a file").len();
            format!("{:.2}, {:.1} B/row", best[i + 1] / best[0], bytes as f64 / rows as f64)
        });
        println!(
            "  {:<10} {rows:>12} {:>10.2} {:>10.2} {:>10.2}   {parquet:>16} {npy:>16}",
            what.name(),
            speeds[0],
            speeds[1],
            speeds[2]
        );
    }
}

fn main() {
    let (mut extent, mut names) = ((512, 256), Vec::new());
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        match argument.as_str() {
            "--bench" => {}
            "--size" => extent = size(&given.next().unwrap_or_default()),
            name => names.push(name.to_string()),
        }
    }
    if names.is_empty() {
        names.push("chess".into());
    }
    for name in &names {
        println!("{name}, {} threads", rayon::current_num_threads());
        let (trace, _folder) = trace(name, extent);
        bench(&trace);
    }
}
