//! Frames of which not every cycle is simulated, on the golden traces.

use std::collections::BTreeMap;
use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::Trace;
use rayreel_machine::config::{NamedMachine, PRESETS, Pipeline};
use rayreel_machine::functional::{counted_counters, exact_counters};
use rayreel_machine::memory::ChannelCounters;
use rayreel_machine::stats::Stats;
use rayreel_machine::system::NoProbe;
use rayreel_replay::policy::{SamplePolicy, SampleState, Sampler, TileView};
use rayreel_replay::sequence::{FrameLoop, FrameResult, Simulator};
use rayreel_replay::{Detail, NamedPolicy, Options, PathSource, Result, Stop};

fn trace(name: &str) -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces").join(name);
    Trace::open(&path, Limits::default()).unwrap()
}

fn run(trace: &Trace, policy: &str, machine: &NamedMachine, detail: &str) -> FrameResult {
    let policy = NamedPolicy::load(policy, &[]).unwrap();
    let mut frames = FrameLoop::new(trace, &policy.policy, Options::default(), &Stop::never()).unwrap();
    let (tree, detail) = (trace.topology(), detail.parse::<Detail>().unwrap());
    frames.step(trace.meta().first_frame, Some(Simulator { machine, tree: &tree, detail }), &mut NoProbe).unwrap()
}

/// The sums over units of the counters that `marks` marks.
fn sums(stats: &Stats, marks: &Stats) -> BTreeMap<usize, u64> {
    let mut marked = BTreeMap::new();
    marks.clone().each_mut(|kind, mark| _ = marked.insert(kind, *mark > 0));
    let mut sums = BTreeMap::new();
    stats.clone().each_mut(|kind, counter| {
        if marked[&kind] {
            *sums.entry(kind).or_default() += *counter;
        }
    });
    sums
}

/// What is said to be counted without time is counted, and the rest is not.
fn check_counted(machine: &NamedMachine, full: &Stats, counts: &Stats) {
    let marks = counted_counters(&machine.config);
    let (mut counted, mut other) = (marks.clone(), marks);
    counted.each_mut(|_, mark| *mark = u64::from(*mark > 0));
    other.each_mut(|_, mark| *mark = u64::from(*mark == 0));
    // Energies are made of these, but which items share a batch, and when rows are closed, the pass does not know.
    other.cores.iter_mut().flat_map(|core| &mut core.srp.kernels).for_each(|kernel| kernel.ops = 0);
    for channel in &mut other.memory.channels {
        let ChannelCounters { activates, precharges, row_hits, row_closed, row_conflicts, .. } = channel;
        [activates, precharges, row_hits, row_closed, row_conflicts].into_iter().for_each(|mark| *mark = 0);
    }
    let name = &machine.name;
    let of_all = sums(full, &counted);
    // Of so few tiles the pass knows no more than this; of machines that gather rays, or trace them by threads, less.
    let keeps_time = !matches!(machine.config.ti.pipeline, Pipeline::Gathering | Pipeline::Software);
    let most = if keeps_time { 2.5 } else { 5.0 };
    for (kind, found) in sums(counts, &counted) {
        let (ratio, all) = (found as f64 / of_all[&kind] as f64, of_all[&kind]);
        let is_near = (1.0 / most..most).contains(&ratio);
        assert!(
            is_near || all < MANY,
            "{name}: kind {kind} of Stats::each_mut: {all} in a simulation, {found} counted"
        );
    }
    assert!(sums(counts, &other).values().all(|found| *found == 0), "{name}: {:?}", sums(counts, &other));
}

/// So many of something do not come about by chance of time alone.
const MANY: u64 = 1000;

#[test]
fn the_functional_pass_counts_what_every_machine_counts() {
    for file in ["v1_0_cornell.rtrace", "v1_0_teapot.rtrace"] {
        let trace = trace(file);
        for (name, _) in PRESETS {
            let machine = NamedMachine::load(name, &[]).unwrap();
            for policy in ["full", "paper-ss", "multirate", "quality"] {
                if policy != "full" && machine.config.srp.kernels.similarity.stages == 0 {
                    continue;
                }
                let [full, counts] = ["full", "counts"].map(|detail| run(&trace, policy, &machine, detail));
                let (full, counts) = (full.run.unwrap(), counts.run.unwrap());
                let exact = exact_counters(&machine.config);
                assert_eq!(
                    sums(&counts.stats, &exact),
                    sums(&full.stats, &exact),
                    "{file} under {policy} on {name}: kinds of counters by number, see Stats::each_mut"
                );
                assert_eq!((counts.stats.cycles, counts.paths), (0, full.paths));
                check_counted(&machine, &full.stats, &counts.stats);
                assert!(counts.energy.components.iter().all(|component| component.leakage_fj == 0));
            }
        }
    }
}

#[test]
fn the_functional_pass_finds_about_the_misses_of_a_simulation() {
    let (trace, machine) = (trace("v1_0_teapot.rtrace"), NamedMachine::load("sgrt-ti2", &[]).unwrap());
    let [full, counts] = ["full", "counts"].map(|detail| run(&trace, "full", &machine, detail).run.unwrap().stats);
    let misses = |stats: &Stats| stats.trv().map(|unit| unit.l1.misses).sum::<u64>() as f64;
    let lines = |stats: &Stats| stats.memory.dram().read_lines as f64;
    for of in [misses, lines] {
        let ratio = of(&counts) / of(&full);
        assert!((0.7..1.4).contains(&ratio), "{ratio}");
    }
}

/// A batch of a slow SRP takes longer than any other silence, and ends.
#[test]
fn slow_parts_are_no_deadlock() {
    let set = ["srp.clock_mhz=100", "srp.inspector_cycles=1000", "ti.clock_mhz=5000"].map(String::from);
    let machine = NamedMachine::load("raycore", &set).unwrap();
    let stats = run(&trace("v1_0_cornell.rtrace"), "full", &machine, "full").run.unwrap().stats;
    assert!(stats.cycles > 10_000_000, "{}", stats.cycles);
    // Refreshes as near to one another as may be, where activates are far apart: each row is read before it is closed.
    let machine = |trefi: u32| {
        let set = ["dram.trrd=900".into(), "dram.tfaw=900".into(), format!("dram.trefi={trefi}")];
        NamedMachine::load("sgrt-ti2", &set)
    };
    let nearest = (900..2000).find_map(|trefi| machine(trefi).ok()).unwrap();
    let stats = run(&trace("v1_0_cornell.rtrace"), "full", &nearest, "full").run.unwrap().stats;
    assert!(stats.memory.dram().refreshes > 100, "{}", stats.memory.dram().refreshes);
}

/// Traces everything, and cannot begin a frame again.
struct TracesAll;

impl SamplePolicy for TracesAll {
    fn name(&self) -> String {
        "everything".into()
    }

    fn text(&self) -> String {
        "everything 1".into()
    }

    fn sampler(&self, _: &Meta) -> Result<Box<dyn Sampler>> {
        Ok(Box::new(Self))
    }
}

impl Sampler for TracesAll {
    fn begin_tile(&self, view: &mut TileView) {
        view.samples().for_each(|(x, y)| view.trace(x, y, SampleState::Reference, 0));
    }
}

#[test]
fn a_policy_that_cannot_begin_again_is_counted_like_one_that_can() {
    let (trace, machine) = (trace("v1_0_cornell.rtrace"), NamedMachine::load("sgrt-ti2", &[]).unwrap());
    let mut frames = FrameLoop::new(&trace, &TracesAll, Options::default(), &Stop::never()).unwrap();
    let (tree, detail) = (trace.topology(), Detail::Counts);
    let simulator = Simulator { machine: &machine, tree: &tree, detail };
    let counted = frames.step(trace.meta().first_frame, Some(simulator), &mut NoProbe).unwrap().run.unwrap();
    let known = run(&trace, "full", &machine, "counts").run.unwrap();
    assert_eq!((&counted.stats, &counted.energy), (&known.stats, &known.energy));
    assert_eq!((counted.stats.cycles, counted.estimate.unwrap().whole_frames.total()), (0, 0));
}

#[test]
fn a_frame_of_few_tiles_is_simulated_whole_and_says_so() {
    let (trace, machine) = (trace("v1_0_teapot.rtrace"), NamedMachine::load("sgrt-ti2", &[]).unwrap());
    let full = run(&trace, "multirate", &machine, "full");
    for detail in ["0.1", "all", "precision 0.01"] {
        let whole = run(&trace, "multirate", &machine, detail);
        assert_eq!(whole.replay, full.replay);
        let (whole, full) = (whole.run.unwrap(), full.run.as_ref().unwrap());
        assert_eq!((&whole.stats, &whole.energy, whole.paths), (&full.stats, &full.energy, full.paths));
        let estimate = whole.estimate.unwrap();
        assert_eq!((estimate.whole_frames.total(), estimate.windows, estimate.fraction()), (1, 0, 1.0));
        assert!(full.estimate.is_none());
    }
}
