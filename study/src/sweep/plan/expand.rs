//! From the plan as it is written to all of its points.

use std::collections::{BTreeMap, BTreeSet};

use toml::Spanned;

use crate::error::{Result, StudyError};
use crate::point::key::{Key, key, policy_json};
use crate::point::version::MODEL_VERSION;
use crate::sweep::plan::axes::{check_axes, check_machines, check_only};
use crate::sweep::plan::axis::Axis;
use crate::sweep::plan::blame::guilty;
use crate::sweep::plan::detail::details;
use crate::sweep::plan::file::{At, PlanFile};
use crate::sweep::plan::filter::{Filters, environment};
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::machines::{BLOCK, Machines, REMEMBERED, Variant, on_all_cores};
use crate::sweep::plan::scalar::Scalar;
use crate::sweep::plan::sources::{Sources, machines, policies, traces};
use crate::sweep::plan::{LAYOUT, Plan, PointRef, TraceRef, is_machine_override};

/// Most points of a plan; more is likelier a slip in a range than a wish.
const POINTS_MAX: usize = 1_000_000;

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
        if let Some(name) = file
            .name
            .as_ref()
            .filter(|name| name.get_ref().trim().is_empty() || name.get_ref().contains(char::is_control))
        {
            return Err(text.error(
                &name.span(),
                "a name has letters or digits, and fits a line; leave it out for that of the file",
            ));
        }
        let mut plan = Self {
            layout: LAYOUT,
            model: MODEL_VERSION,
            name: file.name.as_ref().map_or_else(|| sources.stem.to_owned(), |name| name.get_ref().clone()),
            traces: traces(&file, sources)?,
            machines: machines(&file, sources)?,
            policies: policies(&file, sources)?,
            details: details(&file, sources.detail, text)?,
            axes,
            set: file.set.iter().map(|text| text.get_ref().clone()).collect(),
            points: Vec::new(),
            idle: Vec::new(),
        };
        check_only(&plan, &file, text)?;
        check_machines(&plan, &file, text)?;
        (plan.points, plan.idle) = Expander { plan: &plan, file: &file, text }.points()?;
        Ok(plan)
    }
}

/// Points that are resolved first: what is wrong with all of them shows soon.
const FEW: usize = 16;

/// Machines and policies that are resolved, as keys have them.
struct Known<'a> {
    machines: Machines<'a>,
    jsons: BTreeMap<Variant, String>,
    policies: BTreeMap<Variant, String>,
}

/// Makes the points.
struct Expander<'a> {
    plan: &'a Plan,
    file: &'a PlanFile,
    text: Text<'a>,
}

impl Expander<'_> {
    /// All points, and what there is to say of constraints that leave none out.
    fn points(&self) -> Result<(Vec<PointRef>, Vec<String>)> {
        let (mut points, idle) = self.chosen()?;
        if points.is_empty() {
            return Err(self.text.error(&(0..0), "the plan has no points: every one is excluded"));
        }
        let machines = Machines::new(self.plan);
        let mut known = Known { machines, jsons: BTreeMap::new(), policies: BTreeMap::new() };
        let few = points.len().min(FEW);
        let (few, others) = points.split_at_mut(few);
        for block in std::iter::once(few).chain(others.chunks_mut(BLOCK)) {
            self.find_keys(block, &mut known)?;
        }
        Ok((points, idle))
    }

    /// All points that no constraint leaves out, without their keys; and [`Filters::idle`].
    fn chosen(&self) -> Result<(Vec<PointRef>, Vec<String>)> {
        let (plan, environment) = (self.plan, environment());
        let filters = Filters::new(&environment, &self.file.exclude, self.text)?;
        let mut points = Vec::new();
        for (t, trace) in plan.traces.iter().enumerate() {
            for frames in self.frames(trace)? {
                for (m, p) in (0..plan.machines.len()).flat_map(|m| (0..plan.policies.len()).map(move |p| (m, p))) {
                    // Where nothing is simulated all details are one.
                    let details = if plan.machines[m].is_none() { 1 } else { plan.details.len() };
                    for detail in 0..details {
                        for values in self.combinations(m, p, points.len())? {
                            let key = String::new();
                            let point = PointRef { trace: t, machine: m, policy: p, frames, detail, values, key };
                            if !filters.excludes(&self.variables(trace, &point))? {
                                points.push(point);
                            }
                        }
                    }
                }
            }
        }
        Ok((points, filters.idle()))
    }

    /// Gives points their keys. Machines and policies are resolved once each, not once a point, as far as they are remembered.
    fn find_keys(&self, points: &mut [PointRef], known: &mut Known<'_>) -> Result<()> {
        let of = |point: &PointRef| -> (Variant, Variant) {
            let overrides = self.plan.overrides(&point.values);
            let (machine, policy) = overrides.into_iter().partition(|text| is_machine_override(text));
            ((point.machine, machine), (point.policy, policy))
        };
        let variants: Vec<(Variant, Variant)> = points.iter().map(of).collect();
        for known in [&mut known.jsons, &mut known.policies] {
            if known.len() > REMEMBERED {
                known.clear();
            }
        }
        let machines: BTreeSet<&Variant> = variants.iter().map(|(machine, _)| machine).collect();
        let new: Vec<Variant> = machines.into_iter().filter(|m| !known.jsons.contains_key(*m)).cloned().collect();
        let jsons = known.machines.checked(&new);
        known.jsons.extend(new.into_iter().zip(jsons).filter_map(|(variant, json)| Some((variant, json?))));
        // In the order of the points: the first that cannot be resolved is the one that is told.
        for (point, (machine, policy)) in points.iter().zip(&variants) {
            let refuse = |e: StudyError| self.refuse(point, &e);
            if !known.jsons.contains_key(machine) {
                known.jsons.insert(machine.clone(), known.machines.slow(machine).map_err(refuse)?);
            }
            if !known.policies.contains_key(policy) {
                let found = self.plan.policy(policy.0, &policy.1).map_err(refuse)?;
                known.policies.insert(policy.clone(), policy_json(&found));
            }
        }
        let items: Vec<(&PointRef, &(Variant, Variant))> = points.iter().zip(&variants).collect();
        let (jsons, policies) = (&known.jsons, &known.policies);
        let keys: Vec<Result<Key>> = on_all_cores(&items, |(point, (machine, policy))| {
            let fingerprint = &self.plan.traces[point.trace].fingerprint;
            Ok(key(fingerprint, point.frames, &jsons[machine], &policies[policy], self.plan.detail(point)?))
        });
        for (point, key) in points.iter_mut().zip(keys) {
            point.key = key?;
        }
        Ok(())
    }

    /// The error of a point that cannot be resolved, at the place in the plan that is to blame.
    fn refuse(&self, point: &PointRef, error: &StudyError) -> StudyError {
        let plan = self.plan;
        let span = guilty(plan, self.file, point, error).unwrap_or(0..0);
        let (machine, policy) = (&plan.machines[point.machine].name, &plan.policies[point.policy].name);
        let label =
            |(axis, value): (&Axis, &Option<usize>)| Some(format!("{}={}", axis.name, axis.values[(*value)?].label));
        let labels: String =
            plan.axes.iter().zip(&point.values).filter_map(label).map(|text| format!(" {text}")).collect();
        let varies = plan.machines.len() > 1 || plan.policies.len() > 1 || !labels.is_empty();
        let hint = if varies {
            "; exclude such points, or say with only which machines and policies an axis is for"
        } else {
            ""
        };
        self.text.error(&span, format!("{machine} under {policy}{labels}: {error}{hint}"))
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
        let found: Vec<(u32, u32)> = entries.get_ref().iter().map(one).collect::<Result<_>>()?;
        if let Some(again) = (1..found.len()).find(|at| found[..*at].contains(&found[*at])) {
            let entry = &entries.get_ref()[again];
            let detail = format!("frames {:?}: of {} these frames stand here twice", entry.get_ref(), trace.name);
            return Err(self.text.error(&entry.span(), detail));
        }
        Ok(found)
    }

    /// All combinations of axis values for a machine and a policy; `before` points were made already.
    fn combinations(&self, machine: usize, policy: usize, before: usize) -> Result<Vec<Vec<Option<usize>>>> {
        let (axes, bases) = (&self.plan.axes, [&self.plan.machines[machine].name, &self.plan.policies[policy].name]);
        let is_none = self.plan.machines[machine].is_none();
        let applies = |axis: &Axis| {
            let is_for = axis.only.is_empty() || axis.only.iter().any(|name| bases.contains(&name));
            is_for && !(is_none && axis.is_of_machines())
        };
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
        let total = lengths.iter().try_fold(1usize, |all, length| all.checked_mul(*length)).unwrap_or(usize::MAX);
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

    /// The names that constraints know, with their values at a point.
    fn variables(&self, trace: &TraceRef, point: &PointRef) -> Vec<(String, Option<Scalar>)> {
        let PointRef { machine, policy, frames, values, .. } = point;
        let word = |text: &str| Some(Scalar::Word(text.to_owned()));
        let number = |value: u32| Some(Scalar::Integer(value.into()));
        let mut all = vec![
            ("trace".to_owned(), word(&trace.name)),
            ("scene".to_owned(), word(&trace.scene)),
            ("machine".to_owned(), word(&self.plan.machines[*machine].name)),
            ("policy".to_owned(), word(&self.plan.policies[*policy].name)),
            ("width".to_owned(), number(trace.size.0)),
            ("height".to_owned(), number(trace.size.1)),
            ("samples".to_owned(), number(trace.samples)),
            ("first_frame".to_owned(), number(frames.0)),
            ("frames".to_owned(), number(frames.1)),
            ("detail".to_owned(), self.plan.detail_text(point).and_then(word)),
        ];
        for (axis, value) in self.plan.axes.iter().zip(values) {
            all.push((axis.name.clone(), value.map(|value| axis.values[value].value.clone())));
        }
        all
    }
}

/// `A` or `A..B` as first frame and number.
fn range(entry: &str) -> Option<(u32, u32)> {
    let Some((a, b)) = entry.split_once("..") else {
        return entry.trim().parse().ok().map(|a| (a, 1));
    };
    let (a, b): (u32, u32) = (a.trim().parse().ok()?, b.trim().parse().ok()?);
    (a < b).then(|| (a, b - a))
}
