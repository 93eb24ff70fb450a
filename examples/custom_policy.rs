//! A policy of your own in a small plan, beside a built-in one: `cargo run --release --example custom_policy`.
use rayreel_formats::{Limits, Meta, Trace};
use rayreel_replay::policy::{SamplePolicy, SampleState, Sampler, TileView};
use rayreel_replay::{NamedPolicy, Options, Result, replay};
struct Pairs; // traces every other sample of a row; the one behind it gets the same colour
impl Sampler for Pairs {
    fn begin_tile(&self, view: &mut TileView) {
        for (x, y) in view.samples().filter(|(x, _)| x % 2 == 0) {
            view.trace(x, y, SampleState::Reference, 0);
            let left = view.tree(x, y).to_vec();
            view.interpolate(x + 1, y, &left, 1);
        }
    }
}
#[rustfmt::skip]
impl SamplePolicy for Pairs {
    fn name(&self) -> String { "pairs".into() }
    fn text(&self) -> String { "pairs, version 1".into() } // results are kept under it
    fn sampler(&self, _: &Meta) -> Result<Box<dyn Sampler>> { Ok(Box::new(Pairs)) }
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let trace = Trace::open("traces/v1_0_teapot.rtrace".as_ref(), Limits::default())?;
    for policy in [&NamedPolicy::load("paper-ss", &[])? as &dyn SamplePolicy, &Pairs] {
        let stats = replay(&trace, policy, trace.meta().frame_numbers(), Options::default())?.stats();
        let rays: u64 = stats.iter().map(|frame| frame.counts.rays_traced.total()).sum();
        let values: Vec<_> = stats.iter().filter_map(|frame| Some(frame.quality?.ssim)).collect();
        println!("{}: {rays} rays, SSIM of the frames {values:?}", policy.name());
    }
    Ok(())
}
