//! Which line of a plan gives a value that a machine or policy does not take.
//!
//! No message is searched for names: the overrides of the point are applied again, one more each time, until the same error comes.
//! So it is found whatever kind of error it is, also where two values cannot stand together or two overrides set the same key.

use std::ops::Range;

use toml::Spanned;

use crate::error::StudyError;
use crate::sweep::plan::file::PlanFile;
use crate::sweep::plan::{Plan, PointRef};

/// Where the plan gives the override that a point fails with: the last one of the shortest run of overrides, from the first on,
/// that fails as all of them do. Nothing if the point fails without any.
pub fn guilty(plan: &Plan, file: &PlanFile, point: &PointRef, error: &StudyError) -> Option<Range<usize>> {
    let given = given(plan, file, point);
    let message = error.to_string();
    let fails = |count: &usize| {
        let overrides = given[..*count].iter().map(|(text, _)| text.clone()).collect();
        plan.resolve_with(point, overrides).is_err_and(|error| error.to_string() == message)
    };
    let count = (0..=given.len()).find(fails)?;
    given[..count].last().map(|(_, span)| span.clone())
}

/// The overrides of a point in the order in which they apply, each with its place: that of its text in `set`, or of its axis.
fn given(plan: &Plan, file: &PlanFile, point: &PointRef) -> Vec<(String, Range<usize>)> {
    let places = file.axis.iter().map(Spanned::span);
    let common = file.set.iter().map(|text| (text.get_ref().clone(), text.span()));
    let chosen = plan.axes.iter().zip(&point.values).zip(places).filter_map(|((axis, value), span)| {
        let set = &axis.values[(*value)?].set;
        Some(set.iter().map(move |text| (text.clone(), span.clone())))
    });
    common.chain(chosen.flatten()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point::version::MODEL_VERSION;
    use crate::sweep::plan::axis::Axis;
    use crate::sweep::plan::locate::Text;
    use crate::sweep::plan::{Base, LAYOUT, TraceRef};
    use rayreel_machine::config::NamedMachine;
    use rayreel_replay::policy::NamedPolicy;

    /// The line that is to blame for the first value of each axis on `sgrt-ti2` under `quality`; the plan begins at line 2.
    fn line(body: &str) -> Option<usize> {
        let text = format!("traces = []\n{body}");
        let source = Text { name: "p", text: &text };
        let file = PlanFile::parse(source).unwrap();
        let axis = |axis: &Spanned<_>| Axis::new(axis.get_ref(), &axis.span(), source).unwrap();
        let axes: Vec<Axis> = file.axis.iter().map(axis).collect();
        let machine = NamedMachine::load("sgrt-ti2", &[]).unwrap().to_toml();
        let policy = NamedPolicy::load("quality", &[]).unwrap().to_toml().unwrap();
        let point = PointRef {
            trace: 0,
            machine: 0,
            policy: 0,
            frames: (0, 1),
            detail: 0,
            values: vec![Some(0); axes.len()],
            key: String::new(),
        };
        let trace = TraceRef {
            name: "t".into(),
            location: "t".into(),
            signed: false,
            fingerprint: "f".into(),
            scene: "s".into(),
            size: (1, 1),
            samples: 1,
            frames: (0, 1),
        };
        let plan = Plan {
            layout: LAYOUT,
            model: MODEL_VERSION,
            name: String::new(),
            traces: vec![trace],
            machines: vec![Base { name: "sgrt-ti2".into(), toml: machine }],
            policies: vec![Base { name: "quality".into(), toml: policy }],
            details: super::super::detail::full(),
            axes,
            set: file.set.iter().map(|text| text.get_ref().clone()).collect(),
            points: Vec::new(),
            idle: Vec::new(),
        };
        let all = plan.overrides(&point.values);
        let error = plan.resolve_with(&point, all).unwrap_err();
        guilty(&plan, &file, &point, &error).map(|span| text[..span.start].lines().count())
    }

    fn axis(name: &str, key: &str, value: &str) -> String {
        format!("[[axis]]\nname = \"{name}\"\nkey = \"{key}\"\nvalues = [{value}]\n")
    }

    #[test]
    fn it_is_the_value_that_is_not_taken() {
        let policies = "policies = []\n";
        let good = axis("good", "l2.size", "\"256KiB\"");
        assert_eq!(line(&format!("{policies}{good}{}", axis("bad", "ti.trv", "\"many\""))), Some(6));
        assert_eq!(line(&format!("{policies}{good}{}", axis("bad", "ti.trvs", "1"))), Some(6));
        assert_eq!(line(&format!("{policies}{good}{}", axis("bad", "start", "3"))), Some(6));
        assert_eq!(
            line(&format!("{policies}{good}{}", axis("bad", "finest", "[]").replace("[[]]", "[\"x\"]"))),
            Some(6)
        );
    }

    #[test]
    fn of_two_overrides_of_one_key_it_is_the_bad_one() {
        assert_eq!(line("policies = []\nset = [\"ti.trv=2\",\n\"ti.trv=0\",\n\"ti.trv=4\"]\n"), Some(3));
        let both = "policies = []\nset = [\n\"ti.trv=2\"]\n".to_owned();
        assert_eq!(line(&(both + &axis("bad", "ti.trv", "0"))), Some(4));
    }

    #[test]
    fn of_values_that_cannot_stand_together_it_is_the_last() {
        let (ways, size) = (axis("ways", "l2.ways", "8"), axis("size", "l2.size", "\"96KiB\""));
        assert_eq!(line(&format!("policies = []\n{ways}{size}")), Some(6));
        // The size alone does it here, whatever the axis behind it sets.
        assert_eq!(line(&format!("policies = []\n{size}{}", axis("trv", "ti.trv", "2"))), Some(2));
        // A fault of the policy is not blamed for one of the machine, which is looked at first.
        assert_eq!(line(&format!("policies = []\n{}{size}", axis("start", "start", "3"))), Some(6));
    }
}
