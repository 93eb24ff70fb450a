//! From the plan as it is written to all of its points.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;
use std::path::Path;

use rayreel_formats::trace::Trace;
use toml::Spanned;

use crate::error::{Result, StudyError};
use crate::point::key::{Key, key};
use crate::point::version::MODEL_VERSION;
use crate::sweep::plan::axis::{Axis, Scalar};
use crate::sweep::plan::file::{At, PlanFile};
use crate::sweep::plan::filter::{Filters, environment};
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::{Base, LAYOUT, Plan, PointRef, TraceRef};
use rayreel_machine::config::NamedMachine;
use rayreel_replay::policy::NamedPolicy;

/// Most points of a plan: a folder of a million rows is still a folder.
const POINTS_MAX: usize = 1_000_000;

/// What a plan is made from.
pub struct Sources<'a> {
    /// The file.
    pub text: Text<'a>,
    /// Its folder: relative paths begin there.
    pub folder: &'a Path,
    /// Where relative traces begin instead: a folder, or an address.
    pub traces: Option<&'a str>,
    /// Name of the plan if the file gives none.
    pub stem: &'a str,
    /// Opens a trace at a path or address.
    pub open: &'a dyn Fn(&str) -> Result<Trace, String>,
}

impl Plan {
    /// All points of a plan file.
    ///
    /// # Errors
    /// Whatever is wrong with the file, with line and column: unknown keys, empty axes, missing traces, machines or policies
    /// that do not exist, values that they do not take, too many points.
    pub fn new(sources: &Sources<'_>) -> Result<Self> {
        let text = sources.text;
        let file = PlanFile::parse(text)?;
        let axes: Vec<Axis> =
            file.axis.iter().map(|axis| Axis::new(axis.get_ref(), &axis.span(), text)).collect::<Result<_>>()?;
        check_axes(&file, &axes, text)?;
        let mut plan = Self {
            layout: LAYOUT,
            model: MODEL_VERSION,
            name: file.name.as_ref().map_or_else(|| sources.stem.to_owned(), |name| name.get_ref().clone()),
            traces: traces(&file, sources)?,
            machines: machines(&file, sources)?,
            policies: policies(&file, sources)?,
            axes,
            set: file.set.iter().map(|own| own.get_ref().clone()).collect(),
            points: Vec::new(),
        };
        for (axis, at) in plan.axes.iter().zip(&file.axis) {
            let known = |name: &String| plan.machines.iter().chain(&plan.policies).any(|base| base.name == *name);
            if let Some(name) = axis.only.iter().find(|name| !known(name)) {
                let detail =
                    format!("axis {:?} is only for {name:?}, which is no machine or policy of this plan", axis.name);
                return Err(text.error(&at.span(), detail));
            }
        }
        plan.points = Expander { plan: &plan, file: &file, text }.points()?;
        Ok(plan)
    }
}

/// Machine, policy and values of the axes.
type Variant = (usize, usize, Vec<Option<usize>>);

/// Every value of machine and policy.
type Configs = (String, String);

/// Makes the points.
struct Expander<'a> {
    plan: &'a Plan,
    file: &'a PlanFile,
    text: Text<'a>,
}

impl Expander<'_> {
    fn points(&self) -> Result<Vec<PointRef>> {
        let (plan, environment) = (self.plan, environment());
        let filters = Filters::new(&environment, &self.file.exclude, self.text)?;
        let mut keys = BTreeMap::new();
        let mut points = Vec::new();
        for (t, trace) in plan.traces.iter().enumerate() {
            for frames in self.frames(trace)? {
                for (m, p) in (0..plan.machines.len()).flat_map(|m| (0..plan.policies.len()).map(move |p| (m, p))) {
                    for values in self.combinations(m, p, points.len())? {
                        if filters.excludes(&self.variables(trace, frames, (m, p), &values))? {
                            continue;
                        }
                        let own = PointRef { trace: t, machine: m, policy: p, frames, values, key: String::new() };
                        points.push(PointRef { key: self.key(&own, &mut keys)?, ..own });
                    }
                }
            }
        }
        if points.is_empty() {
            return Err(self.text.error(&(0..0), "the plan has no points: every one is excluded"));
        }
        Ok(points)
    }

    /// The key of a point. Machines and policies are resolved once each, not once a point.
    fn key(&self, point: &PointRef, known: &mut BTreeMap<Variant, Configs>) -> Result<Key> {
        let name = (point.machine, point.policy, point.values.clone());
        let configs = match known.entry(name) {
            Entry::Occupied(own) => own.into_mut(),
            Entry::Vacant(slot) => {
                let own = self.plan.resolve(point).map_err(|e| self.blame(point, &e))?;
                slot.insert((own.machine_config(), own.policy_config()))
            }
        };
        Ok(key(&self.plan.traces[point.trace].fingerprint, point.frames, &configs.0, &configs.1))
    }

    /// A value that machine or policy does not take: the place in the plan that gives it.
    fn blame(&self, point: &PointRef, error: &StudyError) -> StudyError {
        let message = error.to_string();
        let names = |own: &str| message.contains(own.split('=').next().unwrap_or(own));
        let common = self.file.set.iter().find(|own| message.contains(&format!("{:?}", own.get_ref())));
        let span = common.map(Spanned::span).or_else(|| {
            let set = |(axis, value): &(&Axis, &Option<usize>)| {
                value
                    .is_some_and(|value| axis.values[value].set.iter().any(|own| message.contains(&format!("{own:?}"))))
            };
            let mut all = self.plan.axes.iter().zip(&point.values);
            let at = all.position(|pair| set(&pair)).or_else(|| {
                // Values that cannot stand together are named by their keys alone.
                self.plan.axes.iter().position(|axis| axis.values.iter().any(|v| v.set.iter().any(|own| names(own))))
            })?;
            Some(self.file.axis[at].span())
        });
        let place =
            format!("{} under {}", self.plan.machines[point.machine].name, self.plan.policies[point.policy].name);
        let labels: Vec<String> = self
            .plan
            .axes
            .iter()
            .zip(&point.values)
            .filter_map(|(axis, value)| Some(format!("{}={}", axis.name, axis.values[(*value)?].label)))
            .collect();
        let hint = "exclude such points, or say with only which machines and policies an axis is for";
        self.text.error(&span.unwrap_or(0..0), format!("{place} {}: {message}; {hint}", labels.join(" ")))
    }

    /// First frame and number of frames of each entry, for one trace.
    fn frames(&self, trace: &TraceRef) -> Result<Vec<(u32, u32)>> {
        let Some(entries) = &self.file.frames else { return Ok(vec![trace.frames]) };
        if entries.get_ref().is_empty() {
            return Err(self.text.error(&entries.span(), "frames is empty; leave it out for all of them"));
        }
        let (first, count) = trace.frames;
        let one = |entry: &At<String>| {
            if entry.get_ref() == "all" {
                return Ok(trace.frames);
            }
            let wrong = |detail: String| self.text.error(&entry.span(), detail);
            let form = || wrong(format!("frames {:?}: write \"all\", \"3\" or \"0..10\"", entry.get_ref()));
            let (a, n) = range(entry.get_ref()).ok_or_else(form)?;
            if a < first || u64::from(a) + u64::from(n) > u64::from(first) + u64::from(count) {
                let held = format!("{first}..{}", u64::from(first) + u64::from(count));
                return Err(wrong(format!("frames {:?}: {} holds frames {held}", entry.get_ref(), trace.name)));
            }
            Ok((a, n))
        };
        entries.get_ref().iter().map(one).collect()
    }

    /// All combinations of axis values for a machine and a policy; `before` points were made already.
    fn combinations(&self, machine: usize, policy: usize, before: usize) -> Result<Vec<Vec<Option<usize>>>> {
        let (axes, bases) = (&self.plan.axes, [&self.plan.machines[machine].name, &self.plan.policies[policy].name]);
        let applies = |axis: &Axis| axis.only.is_empty() || axis.only.iter().any(|name| bases.contains(&name));
        // Axes that go forward together are one digit.
        let mut digits: Vec<Vec<usize>> = Vec::new();
        for (i, axis) in axes.iter().enumerate().filter(|(_, axis)| applies(axis)) {
            let same = |digit: &&mut Vec<usize>| axis.zip.is_some() && axes[digit[0]].zip == axis.zip;
            match digits.iter_mut().find(same) {
                Some(digit) => digit.push(i),
                None => digits.push(vec![i]),
            }
        }
        let lengths: Vec<usize> = digits.iter().map(|digit| axes[digit[0]].values.len()).collect();
        let total = lengths.iter().try_fold(1usize, |all, own| all.checked_mul(*own)).unwrap_or(usize::MAX);
        if total.saturating_add(before) > POINTS_MAX {
            let sizes = digits.iter().zip(&lengths).map(|(digit, n)| format!("{} {n}", axes[digit[0]].name));
            let sizes = sizes.collect::<Vec<_>>().join(" x ");
            let detail =
                format!("more than {POINTS_MAX} points: {sizes} for each trace, machine, policy and run of frames");
            let span = self.file.axis.first().map_or(0..0, Spanned::span);
            return Err(self.text.error(&span, detail));
        }
        let combination = |mut number: usize| {
            let mut values = vec![None; axes.len()];
            for (digit, length) in digits.iter().zip(&lengths).rev() {
                digit.iter().for_each(|axis| values[*axis] = Some(number % length));
                number /= length;
            }
            values
        };
        Ok((0..total).map(combination).collect())
    }

    /// What constraints can name.
    fn variables(
        &self,
        trace: &TraceRef,
        frames: (u32, u32),
        (machine, policy): (usize, usize),
        values: &[Option<usize>],
    ) -> Vec<(String, Option<Scalar>)> {
        let word = |text: &str| Some(Scalar::Word(text.to_owned()));
        let number = |value: u32| Some(Scalar::Integer(value.into()));
        let mut all = vec![
            ("trace".to_owned(), word(&trace.name)),
            ("scene".to_owned(), word(&trace.scene)),
            ("machine".to_owned(), word(&self.plan.machines[machine].name)),
            ("policy".to_owned(), word(&self.plan.policies[policy].name)),
            ("width".to_owned(), number(trace.size.0)),
            ("height".to_owned(), number(trace.size.1)),
            ("samples".to_owned(), number(trace.samples)),
            ("first_frame".to_owned(), number(frames.0)),
            ("frames".to_owned(), number(frames.1)),
        ];
        for (axis, value) in self.plan.axes.iter().zip(values) {
            all.push((axis.name.clone(), value.map(|value| axis.values[value].value.clone())));
        }
        all
    }
}

/// Names that points have beside their axes.
const RESERVED: &[&str] = &[
    "point",
    "key",
    "status",
    "error",
    "trace",
    "scene",
    "machine",
    "policy",
    "width",
    "height",
    "samples",
    "first_frame",
    "frames",
    "machine_config",
    "policy_config",
    "trace_fingerprint",
    "model_version",
];

fn check_axes(file: &PlanFile, axes: &[Axis], text: Text<'_>) -> Result<()> {
    for (i, (axis, at)) in axes.iter().zip(&file.axis).enumerate() {
        let name_at = at.get_ref().name.span();
        if axes[..i].iter().any(|other| other.name == axis.name) {
            return Err(text.error(&name_at, format!("a second axis {:?}; give it another name", axis.name)));
        }
        if RESERVED.contains(&axis.name.as_str()) || crate::point::row::is_figure(&axis.name) {
            return Err(
                text.error(&name_at, format!("axis {:?}: results have a column of that name; take another", axis.name))
            );
        }
        let first = axes[..i].iter().find(|other| axis.zip.is_some() && other.zip == axis.zip);
        if let Some(first) = first.filter(|first| first.values.len() != axis.values.len()) {
            let (a, b) = (first.values.len(), axis.values.len());
            let detail =
                format!("axes {:?} and {:?} go forward together but have {a} and {b} values", first.name, axis.name);
            return Err(text.error(&at.span(), detail));
        }
        if let Some(first) = first.filter(|first| first.only != axis.only) {
            let detail = format!("axes {:?} and {:?} go forward together but differ in only", first.name, axis.name);
            return Err(text.error(&at.span(), detail));
        }
    }
    Ok(())
}

/// `A` or `A..B` as first frame and number.
fn range(entry: &str) -> Option<(u32, u32)> {
    let Some((a, b)) = entry.split_once("..") else {
        return entry.trim().parse().ok().map(|a| (a, 1));
    };
    let (a, b): (u32, u32) = (a.trim().parse().ok()?, b.trim().parse().ok()?);
    (a < b).then(|| (a, b - a))
}

/// A list that must not be empty.
fn filled<'a>(list: &'a At<Vec<At<String>>>, what: &str, text: Text<'_>) -> Result<&'a [At<String>]> {
    if list.get_ref().is_empty() {
        return Err(text.error(&list.span(), format!("{what} is empty; name at least one")));
    }
    Ok(list.get_ref())
}

fn is_address(location: &str) -> bool {
    location.contains("://")
}

fn traces(file: &PlanFile, sources: &Sources<'_>) -> Result<Vec<TraceRef>> {
    let text = sources.text;
    let mut all: Vec<TraceRef> = Vec::new();
    // Whoever has to fetch traces wants to know all that are missing, and not one a try.
    let mut missing: Vec<(Range<usize>, String, String)> = Vec::new();
    for entry in filled(&file.traces, "traces", text)? {
        for location in locations(entry, sources)? {
            let wrong = |detail: String| text.error(&entry.span(), detail);
            let trace = match (sources.open)(&location) {
                Ok(trace) => trace,
                Err(why) => {
                    missing.push((entry.span(), location, why));
                    continue;
                }
            };
            if let Some((frame, tile)) = trace.missing_tiles().first() {
                let detail = format!(
                    "trace {location} is incomplete: tile {tile} of frame {frame} is missing; capture it again"
                );
                return Err(wrong(detail));
            }
            let own = reference(&trace, &location).map_err(|e| wrong(format!("trace {location}: {e}")))?;
            if let Some(other) = all.iter().find(|known| known.name == own.name && known.location != own.location) {
                let detail =
                    format!("two traces are called {}: {} and {location}; rename one", own.name, other.location);
                return Err(wrong(detail));
            }
            if !all.iter().any(|known| known.location == own.location) {
                all.push(own);
            }
        }
    }
    let Some((span, location, why)) = missing.first() else { return Ok(all) };
    let others: Vec<&str> = missing[1..].iter().map(|(_, location, _)| location.as_str()).collect();
    let others =
        if others.is_empty() { String::new() } else { format!("; nor can these be opened: {}", others.join(", ")) };
    Err(text.error(span, format!("trace {location}: {why}{others}")))
}

/// What a plan says of an open trace.
fn reference(trace: &Trace, location: &str) -> rayreel_formats::Result<TraceRef> {
    let meta = trace.meta();
    let name = location.rsplit(['/', '\\']).next().unwrap_or(location);
    Ok(TraceRef {
        name: name.to_owned(),
        location: location.to_owned(),
        fingerprint: trace.fingerprint()?.to_string(),
        scene: meta.scene.clone(),
        size: (meta.width, meta.height),
        samples: meta.samples,
        frames: (meta.first_frame, meta.frames),
    })
}

/// The traces that an entry names, sorted.
fn locations(entry: &At<String>, sources: &Sources<'_>) -> Result<Vec<String>> {
    let (name, wrong) = (entry.get_ref(), |detail: String| sources.text.error(&entry.span(), detail));
    if is_address(name) {
        return Ok(vec![name.clone()]);
    }
    if let Some(base) = sources.traces.filter(|base| is_address(base)) {
        return Ok(vec![format!("{}/{name}", base.trim_end_matches('/'))]);
    }
    let absolute = std::path::absolute(sources.traces.map_or(sources.folder, Path::new).join(name));
    let path = absolute.map_err(|e| wrong(format!("trace {name:?}: {e}")))?;
    let path = path.to_str().ok_or_else(|| wrong(format!("trace {name:?} is no text")))?;
    if !name.contains(['*', '?', '[']) {
        return Ok(vec![path.to_owned()]);
    }
    let found = glob::glob(path).map_err(|e| wrong(format!("traces {name:?}: {e}")))?;
    let mut all = Vec::new();
    for path in found {
        let path = path.map_err(|e| wrong(format!("traces {name:?}: {e}")))?;
        all.push(path.to_str().ok_or_else(|| wrong(format!("{} is no text", path.display())))?.to_owned());
    }
    if all.is_empty() {
        return Err(wrong(format!("no file matches {path}; capture traces first, or correct the pattern")));
    }
    Ok(all)
}

/// The name of a preset, or the path of a file relative to the plan.
fn spec(entry: &str, folder: &Path) -> String {
    if entry.ends_with(".toml") || entry.contains(['/', '\\']) {
        return folder.join(entry).display().to_string();
    }
    entry.to_owned()
}

fn machines(file: &PlanFile, sources: &Sources<'_>) -> Result<Vec<Base>> {
    let load = |entry: &str, at: &Range<usize>| {
        if entry == "none" {
            return Ok(Base { name: "none".into(), toml: String::new() });
        }
        let machine = NamedMachine::load(&spec(entry, sources.folder), &[]);
        let machine = machine.map_err(|e| sources.text.error(at, e.to_string()))?;
        Ok(Base { toml: machine.to_toml(), name: machine.name })
    };
    let Some(list) = &file.machines else { return Ok(vec![load("sgrt-ti2", &(0..0))?]) };
    let all = filled(list, "machines", sources.text)?;
    distinct(all.iter().map(|entry| load(entry.get_ref(), &entry.span())).collect::<Result<_>>()?, all, sources.text)
}

fn policies(file: &PlanFile, sources: &Sources<'_>) -> Result<Vec<Base>> {
    let load = |entry: &At<String>| {
        let policy = NamedPolicy::load(&spec(entry.get_ref(), sources.folder), &[]);
        let policy = policy.map_err(|e| sources.text.error(&entry.span(), e.to_string()))?;
        Ok(Base { toml: policy.to_toml()?, name: policy.name })
    };
    let all = filled(&file.policies, "policies", sources.text)?;
    distinct(all.iter().map(load).collect::<Result<_>>()?, all, sources.text)
}

/// Refuses two of one name: their rows could not be told apart.
fn distinct(all: Vec<Base>, entries: &[At<String>], text: Text<'_>) -> Result<Vec<Base>> {
    for (i, base) in all.iter().enumerate() {
        if all[..i].iter().any(|other| other.name == base.name) {
            return Err(text.error(&entries[i].span(), format!("{:?} stands here twice; rename one", base.name)));
        }
    }
    Ok(all)
}
