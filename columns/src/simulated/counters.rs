//! What units count, interval by interval.

use rayreel_machine::MachineConfig;
use rayreel_machine::counters::Counter;
use rayreel_machine::srp::KernelId;
use rayreel_machine::stats::{CoreStats, Stats};
use rayreel_machine::system::{Core, Probe};
use rayreel_machine::time::{TiCycle, When};

use super::table_probe::TableProbe;
use crate::schema::{Batch, table};
use crate::value::{Names, Words};

table! {
    /// Counters over time.
    pub struct CounterRows = "counters", "a counter of a unit over an interval in which it changed; counters that stand still have no row" {
        frame: Vec<u32>, "", "frame number";
        begin: Vec<u64>, "T&I cycles", "beginning of the interval, from that of the frame; what is counted at this cycle belongs to the interval before";
        end: Vec<u64>, "T&I cycles", "end of the interval: the first cycle at or after a whole number of intervals at which anything happened, or the end of the frame";
        core: Vec<i32>, "", "core; -1 for what cores share";
        unit: Words, "", "unit of the core";
        counter: Words, "", "group and name of the counter, as rayreel replay --json explains them";
        change: Vec<i64>, "", "by how much it changed, in its own unit; stages book an operation when its issue is certain, and an SRP items when they are done, so an interval can hold more busy cycles than it has, and take back cycles that an earlier one took for starved or idle: sums are those of the run";
    }
}

/// A counter in its place: unit, name, value.
struct Found {
    unit: String,
    name: String,
    value: u64,
}

/// All counters of a core, always in the same order on the same machine.
fn of_core(core: &CoreStats) -> Vec<Found> {
    let mut all = Vec::new();
    let mut add = |unit: String, group: &str, counters: Vec<Counter>| {
        let found = |counter: Counter| Found {
            unit: unit.clone(),
            name: format!("{group}{}", counter.name),
            value: counter.value,
        };
        all.extend(counters.into_iter().map(found));
    };
    add("dispatcher".into(), "", core.ti.dispatch.list());
    for (i, trv) in core.ti.trv.iter().enumerate() {
        let unit = format!("TRV {i}");
        trv.stages.iter().for_each(|(stage, activity)| add(unit.clone(), &format!("{stage}/"), activity.list()));
        add(unit.clone(), "", trv.events.list());
        add(unit.clone(), "buffer/", trv.buffer.list());
        add(unit, "l1/", trv.l1.list());
    }
    for (i, ist) in core.ti.ist.iter().enumerate() {
        let unit = format!("IST {i}");
        add(unit.clone(), "test/", ist.activity.list());
        add(unit.clone(), "", ist.events.list());
        add(unit.clone(), "buffer/", ist.buffer.list());
        add(unit, "l1/", ist.l1.list());
    }
    for (i, processor) in core.processors.iter().enumerate() {
        add(format!("processor {i}"), "", processor.counters.list());
        add(format!("processor {i}"), "code_l1/", processor.code_l1.list());
    }
    add("SRP".into(), "activity/", core.srp.activity.list());
    for kernel in KernelId::ALL {
        add("SRP".into(), &format!("kernel/{}/", kernel.name()), core.srp.kernels[kernel as usize].list());
    }
    add("SRP".into(), "interface/", core.srp.interface.list());
    add("SRP".into(), "dma/", core.srp.dma.list());
    add("SRP".into(), "raster/", core.srp.raster.list());
    add("SRP".into(), "local/", core.srp.local.list());
    add("SRP".into(), "l1/", core.srp_l1.list());
    all
}

/// Name of the one counter that cores share.
const DRAM: (&str, &str) = ("DRAM", "bytes");

/// Names of units and of counters of a machine.
pub fn names(config: &MachineConfig) -> [Names; 2] {
    let shaped = Stats::shaped(config);
    let (mut units, mut counters) = (vec![DRAM.0.to_owned()], vec![DRAM.1.to_owned()]);
    for Found { unit, name, .. } in shaped.cores.first().into_iter().flat_map(of_core) {
        for (names, name) in [(&mut units, unit), (&mut counters, name)] {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    [units, counters].map(Names::shared)
}

/// A probe that writes down how counters change from interval to interval.
#[derive(Clone, Debug)]
pub struct Intervals {
    cycles: u64,
    frame: u32,
    due: When,
    begin: TiCycle,
    /// By counter of a core: the codes of its unit and its name.
    codes: Vec<(u32, u32)>,
    names: [Names; 2],
    /// The values at the last look, core by core.
    before: Vec<Vec<u64>>,
    bytes_before: u64,
    rows: CounterRows,
}

impl Intervals {
    /// Looks every `cycles` cycles.
    pub fn new(config: &MachineConfig, cycles: u64) -> Self {
        let names = names(config);
        let code = |names: &Names, name: &str| {
            let place = names.iter().position(|other| other == name);
            place.expect("`names` took them all from the same counters of the same machine") as u32
        };
        let shaped = Stats::shaped(config);
        let found = shaped.cores.first().into_iter().flat_map(of_core);
        let codes = found.map(|found| (code(&names[0], &found.unit), code(&names[1], &found.name))).collect();
        let mut probe = Self {
            cycles,
            frame: 0,
            due: When::NEVER,
            begin: TiCycle(0),
            codes,
            names,
            before: Vec::new(),
            bytes_before: 0,
            rows: CounterRows::default(),
        };
        probe.take();
        probe
    }

    /// The rows since the last call.
    fn take(&mut self) -> CounterRows {
        let [unit, counter] = self.names.clone().map(|names| Words { codes: Vec::new(), names });
        std::mem::replace(&mut self.rows, CounterRows { unit, counter, ..CounterRows::default() })
    }

    fn add(&mut self, end: TiCycle, core: i32, (unit, counter): (u32, u32), (value, before): (u64, u64)) {
        // Counters stay far below 2^63.
        let change = value.cast_signed() - before.cast_signed();
        if change != 0 {
            self.rows.frame.push(self.frame);
            self.rows.begin.push(self.begin.0);
            self.rows.end.push(end.0);
            self.rows.core.push(core);
            self.rows.unit.codes.push(unit);
            self.rows.counter.codes.push(counter);
            self.rows.change.push(change);
        }
    }
}

impl TableProbe for Intervals {
    fn rows(&self) -> usize {
        self.rows.frame.len()
    }

    fn batch(&mut self) -> Batch {
        self.take().batch()
    }
}

impl Probe for Intervals {
    fn begin(&mut self, frame: u32) {
        self.frame = frame;
        self.begin = TiCycle(0);
        self.due = When::at(TiCycle(self.cycles));
        self.before.clear();
        self.bytes_before = 0;
    }

    fn due(&self) -> When {
        self.due
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64) {
        for (i, core) in cores.iter().enumerate() {
            let values: Vec<u64> = of_core(&core.report(now)).into_iter().map(|found| found.value).collect();
            if self.before.len() <= i {
                self.before.push(vec![0; values.len()]);
            }
            let before = std::mem::replace(&mut self.before[i], values.clone());
            for (counter, (value, before)) in values.into_iter().zip(before).enumerate() {
                self.add(now, i as i32, self.codes[counter], (value, before));
            }
        }
        self.add(now, -1, (0, 0), (bytes, self.bytes_before));
        self.bytes_before = bytes;
        self.begin = now;
        self.due = When::at(TiCycle((now.0 / self.cycles + 1) * self.cycles));
    }
}
