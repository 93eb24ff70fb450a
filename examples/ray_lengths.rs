//! How far all rays of a trace go: `cargo run --release --example ray_lengths [TRACE]`.

use rayreel_formats::rays::RayEnd;
use rayreel_formats::{Limits, Result, Trace};

fn main() -> Result<()> {
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/v1_0_teapot.rtrace").to_owned();
    let trace = Trace::open(std::env::args().nth(1).unwrap_or(golden).as_ref(), Limits::default())?;
    let (mut rays, mut sky, mut length) = (0_u64, 0_u64, 0.0);
    for frame in trace.meta().frame_numbers() {
        for tile in 0..trace.meta().tile_count() {
            for recorded in trace.rays(frame, tile)? {
                rays += 1;
                match recorded.end {
                    RayEnd::Hit(hit) => length += f64::from(hit.t),
                    RayEnd::Sky => sky += 1,
                    RayEnd::Light { .. } => {}
                }
            }
        }
    }
    println!("{rays} rays, {sky} of them into the sky; those that hit a surface go {length:.1} units together");
    Ok(())
}
