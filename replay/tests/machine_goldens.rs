//! Golden replays: what four machines counted on the golden traces, bit for bit.
//!
//! `traces/machine.txt` holds a block a trace, policy and machine: each counter that is not zero, summed over units of a kind,
//! the energy of each component, and a digest of everything unit by unit. `RAYREEL_BLESS=1` writes it anew.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::counters::{Activity, Counter};
use rayreel_machine::srp::KernelId;
use rayreel_machine::stats::Stats;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::layout::Region;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::simulate::{MachineFrame, simulate};
use rayreel_replay::{NamedPolicy, Options, Replayer, TileSource};

const TRACES: [&str; 2] = ["v1_0_cornell.rtrace", "v1_0_teapot.rtrace"];
const POLICIES: [&str; 2] = ["full", "adaptive"];
const MACHINES: [&str; 4] = ["sgrt-ti2", "sgrt-ti1", "sgrt-ti2-rob", "external-buffers"];

fn traces() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces")
}

/// Counters of one name are added; the order is that of first appearance.
#[derive(Default)]
struct Page {
    lines: Vec<(String, u128)>,
}

impl Page {
    fn add(&mut self, name: String, value: u128) {
        match self.lines.iter_mut().find(|line| line.0 == name) {
            Some(line) => line.1 += value,
            None => self.lines.push((name, value)),
        }
    }

    fn group(&mut self, group: &str, counters: Vec<Counter>) {
        counters.into_iter().for_each(|c| self.add(format!("{group}.{}", c.name), c.value.into()));
    }

    fn activity(&mut self, group: &str, activity: &Activity) {
        self.group(group, activity.list());
    }

    fn stats(&mut self, stats: &Stats) {
        self.add("cycles".into(), stats.cycles.into());
        for core in &stats.cores {
            self.group("dispatch", core.ti.dispatch.list());
            for unit in &core.ti.trv {
                unit.stages.iter().for_each(|(name, activity)| self.activity(&format!("trv.{name}"), activity));
                self.group("trv", unit.events.list());
                self.group("trv.front", unit.buffer.list());
                self.group("trv.l1", unit.l1.list());
            }
            for unit in &core.ti.ist {
                self.activity("ist", &unit.activity);
                self.group("ist", unit.events.list());
                self.group("ist.front", unit.buffer.list());
                self.group("ist.l1", unit.l1.list());
            }
            let srp = &core.srp;
            self.group("srp", srp.activity.list());
            for (kernel, counters) in KernelId::ALL.iter().zip(&srp.kernels) {
                self.group(&format!("srp.{}", kernel.name()), counters.list());
            }
            self.group("srp.interface", srp.interface.list());
            self.group("srp.dma", srp.dma.list());
            self.group("srp.local", srp.local.list());
            self.group("srp.l1", core.srp_l1.list());
        }
        self.group("l2", stats.memory.l2.list());
        self.group("dram", stats.memory.dram().list());
        for region in Region::ALL.into_iter().filter(|region| *region != Region::Code) {
            self.add(format!("read.{}", region.name()), stats.memory.traffic.read[region as usize].into());
            self.add(format!("written.{}", region.name()), stats.memory.traffic.written[region as usize].into());
        }
    }

    fn frame(frame: &MachineFrame) -> String {
        let mut page = Self::default();
        page.stats(&frame.stats);
        for component in &frame.energy.components {
            page.add(format!("fj.{}.dynamic", component.name), component.dynamic_fj);
            page.add(format!("fj.{}.leakage", component.name), component.leakage_fj);
        }
        page.add("digest".into(), digest(&old_names(&format!("{:?} {:?}", frame.stats, frame.energy))).into());
        let mut text = String::new();
        for (name, value) in page.lines.iter().filter(|line| line.1 > 0) {
            writeln!(text, "{name} {value}").unwrap();
        }
        text
    }
}

/// The digests were taken of statistics that call some things differently, and lack two kernels, a rasteriser, processors, and traffic of
/// instructions and of histories, which are nothing here. Values, order and all other names are digested as they are.
fn old_names(statistics: &str) -> String {
    let names = [
        ("InputBufferCounters", "FrontCounters"),
        ("buffer: ", "front: "),
        ("shadow_result: ", "update: "),
        ("reshade: 0, look_back: 0, ", ""),
        ("history_written: 0, history_read: 0, ", ""),
        ("raster: RasterCounters { triangles: 0, samples: 0 }, ", ""),
        ("processors: [], ", ""),
        (", 0, 0], written: [", "], written: ["),
        (", 0, 0] } }", "] } }"),
    ];
    let text = names.iter().fold(statistics.to_owned(), |text, (new, old)| text.replace(new, old));
    const KERNELS: &str = "kernels: [";
    let mut lists = text.split(KERNELS);
    let first = lists.next().unwrap_or_default().to_owned();
    lists.fold(first, |text, list| {
        let mut kernels: Vec<&str> = list.split("KernelCounters").collect();
        // The first is what stands before the first kernel.
        for kernel in [KernelId::LookBack, KernelId::Reshade] {
            let removed = kernels.remove(1 + kernel as usize);
            assert!(removed.starts_with(" { batches: 0, items: 0, cycles: 0, ops: 0 }"), "{removed}");
        }
        text + KERNELS + &kernels.join("KernelCounters")
    })
}

/// FNV-1a.
fn digest(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn found() -> String {
    let mut text = String::new();
    for name in TRACES {
        let trace = Trace::open(&traces().join(name), Limits::default()).unwrap();
        let (tree, frame) = (Topology::new(trace.bvh()), TileSource::meta(&trace).first_frame);
        for policy in POLICIES.map(|policy| NamedPolicy::load(policy, &[]).unwrap()) {
            for machine in MACHINES.map(|machine| NamedMachine::load(machine, &[]).unwrap()) {
                let mut replayer = Replayer::new(&trace, &policy.policy, Options::default()).unwrap();
                let run =
                    simulate(&mut replayer, frame, &tree, (&machine.name, &machine.config), &mut NoProbe).unwrap();
                writeln!(text, "[{name} {} {}]\n{}", policy.name, machine.name, Page::frame(&run)).unwrap();
            }
        }
    }
    text
}

/// The first lines that differ, each with the block that it stands in.
fn differences(found: &str, expected: &str) -> String {
    let (mut block, mut text, mut left) = ("", String::new(), 12);
    for (new, old) in found.lines().zip(expected.lines()) {
        if new.starts_with('[') {
            block = new;
        }
        if new != old && left > 0 {
            left -= 1;
            writeln!(text, "{block} {new}, was {old}").unwrap();
        }
    }
    let lines = (found.lines().count(), expected.lines().count());
    format!("{text}{} lines, were {}", lines.0, lines.1)
}

#[test]
fn golden_replays_count_what_they_counted() {
    let (path, found) = (traces().join("machine.txt"), found());
    if std::env::var_os("RAYREEL_BLESS").is_some_and(|value| value == "1") {
        fs::write(&path, &found).unwrap();
    }
    let expected = fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    let hint = "RAYREEL_BLESS=1 cargo test -p rayreel-replay --test machine_goldens writes it anew";
    assert!(found == expected, "{} changed; {hint}\n{}", path.display(), differences(&found, &expected));
}
