//! What stands beside a machine: a probe is told of each frame once, and a memory that wants lookups is refused where none are told.

use std::path::Path;

use rayreel_formats::{Limits, Trace};
use rayreel_machine::NamedMachine;
use rayreel_machine::memory::Recording;
use rayreel_machine::system::{Core, NoProbe, Probe};
use rayreel_machine::time::{TiCycle, When};
use rayreel_replay::sequence::Simulator;
use rayreel_replay::simulate::{simulate, simulate_all, simulate_in_front_of};
use rayreel_replay::{FrameLoop, NamedPolicy, Options, PathSource, ReplayError, Replayer, Stop};

/// Two frames.
fn trace() -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_teapot.rtrace");
    Trace::open(&path, Limits::default()).unwrap()
}

fn machine(name: &str) -> NamedMachine {
    NamedMachine::load(name, &[]).unwrap()
}

/// Writes down which frames begin, and in which it looks.
#[derive(Default)]
struct Begins {
    frames: Vec<u32>,
    looks: Vec<u32>,
}

impl Probe for Begins {
    fn begin(&mut self, frame: u32) {
        self.frames.push(frame);
    }

    fn due(&self) -> When {
        if self.looks.last() == self.frames.last() { When::NEVER } else { When::at(TiCycle(0)) }
    }

    fn look(&mut self, _: TiCycle, _: &[Core], _: u64) {
        self.looks.extend(self.frames.last());
    }
}

/// Simulates a frame under a probe.
type Step<'a> = Box<dyn FnMut(&mut Replayer<'_, Trace>, u32, &mut Begins) + 'a>;

#[test]
fn a_probe_is_told_of_each_frame_once() {
    let (trace, policy, ti2) = (trace(), NamedPolicy::load("adaptive", &[]).unwrap(), machine("sgrt-ti2"));
    let (tree, named) = (trace.topology(), (ti2.name.as_str(), &ti2.config));
    let begun = |mut frame: Step<'_>| {
        let mut replayer = Replayer::new(&trace, &policy, Options::default()).unwrap();
        let mut probe = Begins::default();
        trace.meta().frame_numbers().for_each(|number| frame(&mut replayer, number, &mut probe));
        // Every frame is looked at once more at its end.
        probe.looks.dedup();
        assert_eq!(probe.looks, probe.frames, "it is told before it looks");
        probe.frames
    };
    let one = begun(Box::new(|replayer, frame, probe| {
        simulate(replayer, frame, &tree, named, probe).unwrap();
    }));
    let several = begun(Box::new(|replayer, frame, probe| {
        simulate_all(replayer, frame, &tree, &[named, named], probe).unwrap();
    }));
    let in_front = begun(Box::new(|replayer, frame, probe| {
        let each = |_: &mut _, _: &mut _| Ok::<_, ReplayError>(());
        simulate_in_front_of(replayer, (frame, &tree), named, (|memory| memory, probe), each).unwrap();
    }));
    assert_eq!([one, several, in_front], [[30, 31]; 3].map(Vec::from));
    for detail in ["full", "all", "counts", "0.5", "precision 0.2"] {
        let mut probe = Begins::default();
        let simulator = Simulator { machine: &ti2, tree: &tree, detail: detail.parse().unwrap() };
        let mut frames = FrameLoop::new(&trace, &policy, Options::default(), &Stop::never()).unwrap();
        let sink = |_| Ok::<_, ReplayError>(());
        frames.run(trace.meta().frame_numbers(), Some(simulator), &mut probe, sink).unwrap();
        assert_eq!(probe.frames, [30, 31], "{detail}");
    }
}

#[test]
fn a_memory_that_wants_lookups_is_refused_where_none_are_told() {
    let (trace, policy) = (trace(), NamedPolicy::load("full", &[]).unwrap());
    let tree = trace.topology();
    let run = |name: &str, lookups: bool| {
        let machine = machine(name);
        let mut replayer = Replayer::new(&trace, &policy, Options::default()).unwrap();
        let record = |memory| if lookups { Recording::of_lookups(memory) } else { Recording::of_requests(memory) };
        let mut told = 0;
        let ran = simulate_in_front_of(
            &mut replayer,
            (30, &tree),
            (&machine.name, &machine.config),
            (record, &mut NoProbe),
            |memory, _| {
                told += memory.take_lookups().len() + memory.take_requests().len();
                Ok::<_, ReplayError>(())
            },
        );
        ran.map(|_| told)
    };
    assert!(run("sgrt-ti2", true).unwrap() > 0 && run("mimd-trax", false).unwrap() > 0);
    let refused = run("mimd-trax", true).unwrap_err().to_string();
    assert!(refused.starts_with("no unit of machine mimd-trax tells what it looks for ray by ray"), "{refused}");
}
