//! A policy of another crate: it replays like a built-in one, and sees as little.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::half::Half3;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Hit, Tile};
use rayreel_formats::trace::Trace;
use rayreel_machine::work::TileWork;
use rayreel_replay::policy::tree::Forest;
use rayreel_replay::policy::{Adaptive, Policy, SamplePolicy, SampleState, Sampler, TileView, between};
use rayreel_replay::{
    FrameReplay, NamedPolicy, Options, PathSource, ReplayError, Replayer, Result, TileSource, replay,
};
use rayreel_testkit::synthetic::{Look, Synthetic};

const FRAME: u32 = 6;

/// Even columns of the frame are traced, odd ones are half way between their neighbours; the last one may repeat the left.
struct Columns;

impl SamplePolicy for Columns {
    fn name(&self) -> String {
        "columns".into()
    }

    fn text(&self) -> String {
        "columns 1".into()
    }

    fn sampler(&self, _: &Meta) -> Result<Box<dyn Sampler>> {
        Ok(Box::new(Self))
    }
}

impl Sampler for Columns {
    fn begin_tile(&self, view: &mut TileView) {
        let even = view.samples().filter(|(x, _)| x % 2 == 0);
        even.for_each(|(x, y)| view.trace(x, y, SampleState::Reference, 0));
    }

    fn shared_rows(&self, view: &TileView) -> Vec<u32> {
        (view.rect().y..view.rect().y + view.rect().height).collect()
    }

    fn step_x(&self, view: &mut TileView, right: Option<&Forest>) {
        let rect = view.rect();
        for (x, y) in view.samples().filter(|(x, _)| x % 2 == 1) {
            let left = view.tree(x - 1, y);
            let far = if x + 1 < rect.x + rect.width {
                view.tree(x + 1, y)
            } else {
                right.map_or(left, |column| column.tree((y - rect.y) as usize))
            };
            let tree = between(left, far, 0.5);
            view.interpolate(x, y, &tree, 1);
        }
    }
}

fn run<S: TileSource, P: SamplePolicy>(source: &S, policy: &P) -> FrameReplay {
    replay(source, policy, [FRAME], Options::default()).unwrap().frames.remove(0)
}

fn golden() -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_cornell.rtrace");
    Trace::open(&path, Limits::default()).unwrap()
}

#[test]
fn it_decides_the_picture_and_what_is_counted() {
    // Tiles begin at even columns, whatever their size: each reads its neighbour, so they do not show.
    let source = |tile| Synthetic::new(Look::Discs, (42, 22), 1, tile, 3);
    let whole = run(&source(64), &Columns);
    let counts = &whole.stats.counts;
    assert_eq!((counts.samples_traced, counts.samples_interpolated), (21 * 22, 21 * 22));
    assert!(counts.rays_traced.total() > 0 && counts.rays_saved() > 0);
    for (x, y) in (0..22).flat_map(|y| (0..42).map(move |x| (x, y))) {
        let expected = if x % 2 == 0 { (SampleState::Reference, 0) } else { (SampleState::Interpolated, 1) };
        assert_eq!((whole.states.state(x, y), whole.states.round(x, y)), expected);
    }
    let pixel = |frame: &FrameReplay, x: usize| frame.image.pixels[5 * 42 + x];
    let full = run(&source(64), &Policy::Full);
    assert_eq!(pixel(&whole, 8), pixel(&full, 8), "traced samples are the recorded ones");
    for c in 0..3 {
        let (a, b) = (pixel(&full, 8)[c], pixel(&full, 10)[c]);
        assert_eq!(pixel(&whole, 9)[c], a + (b - a) * 0.5);
    }
    for tile in [8, 14, 24] {
        let frame = run(&source(tile), &Columns);
        assert_eq!((&frame.image, &frame.states, &frame.stats.counts), (&whole.image, &whole.states, counts), "{tile}");
    }
}

#[test]
fn machines_take_its_work() {
    let trace = golden();
    let (frame, columns) = (trace.meta().first_frame, trace.meta().tile_grid().0);
    let mut replayer = Replayer::new(&trace, &Columns, Options::default()).unwrap();
    let mut works: Vec<TileWork> = Vec::new();
    let keep = |work| {
        works.push(work);
        Ok(())
    };
    let (replayed, _) = replayer.frame_with(frame, &trace.topology(), keep).unwrap();
    assert!(works.iter().map(|work| work.tile).eq(0..trace.meta().tile_count()));
    let rays: usize = works.iter().map(|work| work.rays.len()).sum();
    assert_eq!(rays as u64, replayed.stats.counts.rays_traced.total());
    for work in &works {
        // The tile to the left shares a column.
        let border = if work.tile % columns > 0 { work.rect.height } else { 0 };
        assert_eq!((work.border_samples, work.apron_samples), (border, 0), "tile {}", work.tile);
    }
}

/// A source whose odd columns hold garbage.
struct Spoilt(Synthetic);

impl TileSource for Spoilt {
    fn meta(&self) -> &Meta {
        self.0.meta()
    }
    fn object_of(&self, triangle: u32) -> u32 {
        self.0.object_of(triangle)
    }
    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        self.0.camera(frame)
    }
    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        let mut tile = self.0.tile(frame, index)?;
        for sample in (0..tile.rect.len()).filter(|i| (tile.rect.x + *i as u32 % tile.rect.width) % 2 == 1) {
            for node in tile.tree.sample(sample) {
                tile.radiance[node].local = Half3([0x7e00; 3]);
                tile.hits[node] = Hit { t: f32::NAN, ..tile.hits[node] };
            }
        }
        Ok(tile)
    }
}

#[test]
fn what_it_does_not_trace_cannot_reach_its_picture() {
    let clean = Synthetic::new(Look::Discs, (42, 22), 1, 8, 3);
    let (a, b) = (run(&clean, &Columns), run(&Spoilt(clean.clone()), &Columns));
    assert_eq!((a.image, a.stats.counts), (b.image, b.stats.counts));
    assert_ne!(a.reference, b.reference, "the garbage is real");
}

/// A policy that breaks a rule of the interface in its own way.
struct Wrong(fn(&mut TileView));

impl SamplePolicy for Wrong {
    fn name(&self) -> String {
        "wrong".into()
    }
    fn text(&self) -> String {
        "wrong".into()
    }
    fn sampler(&self, _: &Meta) -> Result<Box<dyn Sampler>> {
        Ok(Box::new(Self(self.0)))
    }
}

impl Sampler for Wrong {
    fn begin_tile(&self, view: &mut TileView) {
        (self.0)(view);
    }
}

#[test]
fn rules_of_the_interface_are_kept() {
    let source = Synthetic::new(Look::Flat, (8, 4), 1, 8, 1);
    let wrong = |breaks: fn(&mut TileView)| replay(&source, &Wrong(breaks), [FRAME], Options::default());
    let undecided = wrong(|view| view.trace(0, 0, SampleState::Reference, 0)).unwrap_err();
    assert!(matches!(&undecided, ReplayError::Usage { .. }));
    assert!(undecided.to_string().contains("left sample (1, 0) of tile 0 of frame 6 undecided"), "{undecided}");
    let panics = |breaks: fn(&mut TileView)| catch_unwind(AssertUnwindSafe(|| wrong(breaks))).is_err();
    assert!(panics(|view| _ = view.tree(0, 0)), "reading what was not traced");
    assert!(panics(|view| view.trace(0, 0, SampleState::Interpolated, 0)), "tracing for nothing");
    assert!(panics(|view| (0..2).for_each(|_| view.trace(0, 0, SampleState::Reference, 0))), "tracing twice");
    assert!(panics(|view| view.trace(8, 0, SampleState::Reference, 0)), "another tile");
    let empty = |give: fn(&mut TileView)| {
        let panicked = catch_unwind(AssertUnwindSafe(|| wrong(give))).unwrap_err();
        assert!(panicked.downcast_ref::<String>().unwrap().contains("gave sample (0, 0) an empty tree"));
    };
    empty(|view| view.interpolate(0, 0, &[], 1));
    empty(|view| view.rebuild(0, 0, 1, |_, _, _| 0));
}

#[test]
fn names_may_change_but_not_texts() {
    let named = NamedPolicy::load("adaptive", &[]).unwrap();
    let other = NamedPolicy { name: "mine".into(), ..named.clone() };
    assert_eq!((named.text(), other.name()), (other.text(), "mine".into()));
    assert_eq!(named.text(), named.to_toml().unwrap());
    let Policy::Adaptive(adaptive) = named.policy.clone() else { panic!("adaptive is {:?}", named.policy) };
    let changed = Policy::Adaptive(Adaptive { block: 8, ..adaptive });
    assert_ne!(changed.text(), named.text());
    assert_ne!(Columns.text(), named.text());
}
