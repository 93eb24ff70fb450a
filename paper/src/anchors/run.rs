//! The replays that anchors are measured on: each is done once, whoever asks for it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rayreel_formats::scene::Meta;
use rayreel_machine::NamedMachine;
use rayreel_replay::{NamedPolicy, PathSource};
use rayreel_scenes::Scene;
use rayreel_study::point::compute::compute_all;
use rayreel_study::point::figures::RowFigures;
use rayreel_study::point::key::Point;
use rayreel_study::point::task::Missing;
use rayreel_study::pool::{Event, Pool};
use rayreel_tracer::accel::{self, Built};
use rayreel_tracer::{SampleGrid, TraceSettings};
use serde_json::{Map, Value};

use super::anchor::{Of, On, Row};
use crate::error::{PaperError, Result};
use crate::live::LiveSource;
use crate::plan::TILE;

/// The figures of a replay, by the names of reports.
pub type Run<'a> = RowFigures<'a>;

/// Machines that share a pass over a frame: tracing is paid once for them, and they run one after the other.
const SHARED: usize = 3;

/// A replay: scene, samples per pixel and axis, policy.
type Pass = (&'static str, u32, &'static str);

/// A machine, and whether its T&I units are simulated alone.
type On2 = Option<(&'static str, bool)>;

/// The replays that rows need.
#[derive(Debug, Default)]
pub struct Runs {
    wanted: BTreeMap<Pass, BTreeSet<On2>>,
    done: BTreeMap<(Pass, On2), Map<String, Value>>,
}

impl Runs {
    /// Notes what a row needs.
    pub fn want(&mut self, row: &Row, of: &Of) {
        for scene in row.scenes() {
            self.wanted.entry((scene, of.samples, of.policy)).or_default().insert(on(row, of));
        }
    }

    /// The runs of a row, scene by scene; nothing if one is missing.
    pub fn of(&self, row: &Row, of: &Of) -> Option<Vec<Run<'_>>> {
        let run = |scene| self.done.get(&((scene, of.samples, of.policy), on(row, of))).map(RowFigures);
        row.scenes().into_iter().map(run).collect()
    }

    /// Does all that is wanted, at a picture size. `tell` is told how many passes are done, and how many there are.
    pub fn compute(&mut self, size: (u32, u32), pool: &Pool, tell: &mut dyn FnMut(u64, u64, &str)) -> Result<()> {
        let stages = self.stages()?;
        let mut jobs = Vec::new();
        for (pass, machines) in &self.wanted {
            let machines: Vec<On2> = machines.iter().copied().collect();
            jobs.extend(machines.chunks(SHARED).map(|part| (*pass, part.to_vec())));
        }
        let all = jobs.len() as u64;
        let mut done = 0;
        let work = |_: usize, (pass, machines): &(Pass, Vec<On2>)| {
            stages.get(pass.0).map_or(Err(NO_STAGE), |stage| replay(stage, size, *pass, machines, pool))
        };
        pool.run(&jobs, work, |event| {
            let Event::Done { index, result } = event else { return Ok(()) };
            let (pass, machines) = &jobs[index];
            for (machine, row) in machines.iter().zip(result?) {
                self.done.insert((*pass, *machine), row);
            }
            done += 1;
            tell(done, all, pass.0);
            Ok::<_, PaperError>(())
        })?;
        pool.stop.check().map_err(PaperError::from)
    }

    /// Scenes with their trees.
    fn stages(&self) -> Result<BTreeMap<&'static str, Stage>> {
        let names: BTreeSet<&str> = self.wanted.keys().map(|pass| pass.0).collect();
        names.into_iter().map(|name| Ok((name, Stage::new(name)?))).collect()
    }
}

/// A scene that is not there though it is wanted.
const NO_STAGE: PaperError = PaperError::Fault { detail: "a scene of an anchor was not loaded" };

fn on(row: &Row, of: &Of) -> On2 {
    match of.on {
        On::Row => row.machine.map(|machine| (machine, false)),
        On::Alone => row.machine.map(|machine| (machine, true)),
        On::Preset(name) => Some((name, false)),
        On::Nothing => None,
    }
}

/// A scene, ready to be traced.
struct Stage {
    scene: Scene,
    built: Built,
}

impl Stage {
    fn new(name: &str) -> Result<Self> {
        let failed = |detail: String| PaperError::Scene { scene: name.to_owned(), detail };
        let scene = rayreel_scenes::load(name).map_err(|e| failed(e.to_string()))?;
        let built = accel::build(&scene).map_err(|e| failed(e.to_string()))?;
        Ok(Self { scene, built })
    }

    fn meta(&self, (width, height): (u32, u32), samples: u32) -> Meta {
        let grid = SampleGrid { width, height, samples, tile: TILE, first_frame: 0, frames: 1 };
        grid.meta(&self.scene, TraceSettings::default(), rayreel_tracer::TOOL)
    }
}

/// The rows of a pass on some machines, in their order. Nothing is written: the first frame is traced as it is replayed.
fn replay(
    stage: &Stage,
    size: (u32, u32),
    (_, samples, policy): Pass,
    machines: &[On2],
    pool: &Pool,
) -> Result<Vec<Map<String, Value>>> {
    let meta = stage.meta(size, samples);
    let source = LiveSource::new(&stage.scene, &stage.built, &meta);
    let policy = Arc::new(NamedPolicy::load(policy, &[])?);
    let mut points = Vec::new();
    for machine in machines {
        let load = |(name, alone): (&str, bool)| {
            let ideal = if alone { vec!["srp.ideal=true".to_owned()] } else { Vec::new() };
            NamedMachine::load(name, &ideal).map(Arc::new)
        };
        let machine = machine.map(load).transpose()?;
        let plain = Point::plain(String::new(), (0, 1), None, NamedPolicy::clone(&policy));
        points.push(Point { machine, ..plain });
    }
    let missing = Missing { row: true, details: false };
    let tree = machines.iter().any(Option::is_some).then(|| source.topology());
    let wanted: Vec<_> = points.iter().map(|point| (point, missing)).collect();
    let computed = compute_all(&wanted, (&source, tree.as_ref()), &pool.stop, |_, _| {})?;
    Ok(computed.into_iter().map(|computed| computed.row.map(|(row, _)| row.figures).unwrap_or_default()).collect())
}
