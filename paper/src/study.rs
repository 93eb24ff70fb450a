//! The whole experiment as a study.

use std::sync::Arc;

use rayreel_machine::config::schema::KEYS;
use rayreel_machine::config::{NamedMachine, Sourced};
use rayreel_replay::NamedPolicy;
use rayreel_study::html::has_counterpart;
use rayreel_study::policy_text;
use rayreel_study::schema::{ConfigValue, ModeRays, Policy, SCHEMA, Scene, Study};

use crate::error::Result;
use crate::policies::{Contender, MODES};
use crate::results::Results;
use crate::setup::{SIZE_FULL, Setup};
use crate::{ablations, animation, estimates, points, reference, systems};

/// What is planned.
pub(crate) struct Experiment {
    pub points: Vec<points::Planned>,
    pub animation: Option<animation::Planned>,
    pub ablations: Vec<ablations::Planned>,
    pub systems: Vec<systems::Planned>,
}

/// Makes the study.
///
/// # Errors
/// Never for policies that were loaded.
pub fn study(setup: &Setup, experiment: &Experiment, results: &Results) -> Result<Study> {
    let animation = experiment.animation.as_ref();
    let points = points::points(setup, &experiment.points, results);
    let scenes: Vec<Scene> = (0..setup.stages.len()).map(|scene| scene_of(setup, experiment, results, scene)).collect();
    let references = reference::references(&scenes);
    let mut notes = notes(setup, experiment, &scenes);
    notes.extend(estimates::note(setup, &points));
    Ok(Study {
        schema: SCHEMA,
        tool: setup.tool.clone(),
        title: "Adaptive multi-rate ray sampling, after Lee et al. 2016".into(),
        command: setup.command.clone(),
        machine: setup.machines.as_ref().map(|m| m.whole.name.clone()),
        detail: setup.machines.as_ref().map(|_| setup.detail.to_string()),
        width: setup.size.0,
        height: setup.size.1,
        notes,
        // Named beforehand: the best of several after the fact would flatter.
        headline_policy: Some("multirate".into()),
        scenes,
        policies: policies(setup)?,
        points,
        references,
        maps: animation.map(|animation| animation.maps(setup, results)).unwrap_or_default(),
        tracks: animation.map(|animation| animation.tracks(setup, results)).unwrap_or_default(),
        ablations: ablations::ablations(setup, &experiment.ablations, results),
        systems: systems::systems(setup, &experiment.systems, results),
        viewer: points::viewer(setup, &experiment.points, results),
        config: setup.machines.as_ref().map(|m| config(&m.whole)).unwrap_or_default(),
    })
}

fn scene_of(setup: &Setup, experiment: &Experiment, results: &Results, scene: usize) -> Scene {
    let stage = &setup.stages[scene];
    let rays = points::rays_full(&experiment.points, results, scene);
    Scene {
        name: stage.name.clone(),
        triangles: stage.scene.mesh.triangles.len() as u64,
        paper_triangles: reference::triangles(&stage.name),
        lights: stage.scene.lights.len() as u32,
        frame: 1,
        rays_full: rays.iter().map(|(mode, rays)| ModeRays { mode: MODES[*mode].name.into(), rays: *rays }).collect(),
    }
}

fn policies(setup: &Setup) -> Result<Vec<Policy>> {
    let policy = |(entry, named): &(&Contender, Arc<NamedPolicy>)| {
        Ok(Policy {
            name: named.name.clone(),
            summary: summary(entry),
            config_toml: policy_text::values(&named.policy),
        })
    };
    let used = |used: &&(&Contender, Arc<NamedPolicy>)| {
        let entry = used.0;
        entry.modes.iter().chain([&entry.animated]).any(|when| when.now(setup.full))
    };
    setup.policies.iter().filter(used).map(policy).collect()
}

/// What a policy does, and what is changed in the preset.
fn summary(entry: &Contender) -> String {
    let (preset, rules) = entry.preset;
    if rules.is_empty() { policy_text::summary(preset) } else { format!("{preset} with {}.", rules.join(", ")) }
}

fn config(machine: &NamedMachine) -> Vec<ConfigValue> {
    let value = |v: &Sourced| ConfigValue {
        key: v.key.into(),
        value: KEYS.iter().find(|k| k.name == v.key).map_or_else(|| v.value.to_string(), |k| k.rule.show(&v.value)),
        unit: String::new(),
        class: v.class.name().into(),
        source: v.source.clone(),
    };
    machine.values.iter().map(value).collect()
}

/// What a reader has to know, above all what was left out.
fn notes(setup: &Setup, experiment: &Experiment, scenes: &[Scene]) -> Vec<String> {
    let (w, h) = setup.size;
    let has_units = setup.machines.as_ref().is_some_and(|machines| machines.alone.is_some());
    let mut notes = Vec::new();
    if setup.size != SIZE_FULL {
        let (width, height) = SIZE_FULL;
        // Of finer pictures it would be the other way round.
        let why = if w <= width && h <= height {
            ", where neighbouring samples lie closer together, which as a rule makes gains larger"
        } else {
            ""
        };
        notes.push(format!(
            "Pictures have {w}x{h} pixels; the paper's have {width}x{height}{why}: rayreel paper --full."
        ));
    }
    notes.push(models(scenes));
    if setup.machines.is_none() {
        notes.push("No machine: rays and pictures only.".into());
    }
    if let Some(animation) = &experiment.animation {
        let (counted, all) = animation.extent(setup);
        let mut note = format!("The animation of {} counts {counted} of {all} frames", animation.scene(setup));
        if let Some(part) = animation.part(setup) {
            note += &format!(", {part}");
        }
        if setup.machines.is_some() {
            let simulated = animation.simulated(setup);
            let part = if has_units { " (T&I units alone)" } else { "" };
            let are = if simulated == 1 { "is" } else { "are" };
            note += &format!("; {simulated} of them {are} simulated on the machine{part}, under some of the policies");
            if animation.estimates(setup) {
                note += ", and the others estimated from these, by their rays";
            }
        }
        note += ". In it multi-rate policies have the frames before to go by, but in its first frame; all other results are of one frame \
                 without history.";
        notes.push(note);
    }
    let sizes = [("The ablations are", Some(ablations::size(setup)))]
        .into_iter()
        .chain([("The animation is", experiment.animation.as_ref().map(|_| animation::size(setup)))]);
    for (what, (width, height)) in sizes.filter_map(|(what, size)| Some((what, size.filter(|s| *s != setup.size)?))) {
        notes.push(format!("{what} of {width}x{height} pixels."));
    }
    let without = |entry: &&Contender| !entry.whole && entry.modes.iter().any(|when| when.now(setup.full));
    let names: Vec<&str> = setup.policies.iter().map(|(entry, _)| *entry).filter(without).map(|e| e.name).collect();
    // Where processors do the work of the T&I units, there is only the whole.
    if !names.is_empty() && has_units {
        notes.push(format!("Under {} the T&I units alone are simulated, not the whole GPU.", names.join(", ")));
    }
    notes
}

/// How far the scenes are from the paper's.
fn models(scenes: &[Scene]) -> String {
    let (like, unlike): (Vec<&Scene>, Vec<&Scene>) = scenes.iter().partition(|scene| has_counterpart(scene));
    let named = |scenes: &[&Scene]| scenes.iter().map(|scene| scene.name.as_str()).collect::<Vec<_>>().join(", ");
    let is = |scenes: &[&Scene]| if scenes.len() == 1 { "is" } else { "are" };
    let alike = match (like.is_empty(), unlike.is_empty()) {
        (_, true) => ": these scenes are of the same kind and triangle count, no more".to_owned(),
        (true, _) => format!(", and {} {} like none of them", named(&unlike), is(&unlike)),
        _ => format!(
            ": {} {} of the same kind and triangle count, no more, and {} {} like none of them",
            named(&like),
            is(&like),
            named(&unlike),
            is(&unlike)
        ),
    };
    format!(
        "The paper's models are not public{alike}. It does not state its angle between normals; ours is 10 degrees."
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;
    use crate::setup::Machines;

    fn scene(name: &str, triangles: u64) -> Scene {
        Scene { name: name.into(), triangles, paper_triangles: reference::triangles(name), ..Scene::default() }
    }

    #[test]
    fn only_scenes_that_are_like_the_papers_are_called_so() {
        let [teapot, cornell, other] = [scene("teapot", 15_168), scene("cornell", 36), scene("noise", 400)];
        let note = models(std::slice::from_ref(&teapot));
        assert!(note.contains("public: these scenes are of the same kind and triangle count, no more. It"), "{note}");
        let note = models(&[teapot, cornell.clone(), other]);
        assert!(note.contains("teapot is of the same kind") && note.contains("cornell, noise are like none"), "{note}");
        let note = models(&[cornell]);
        assert!(note.contains("cornell is like none") && !note.contains("same kind"), "{note}");
        // The name alone makes no teapot.
        assert!(models(&[scene("teapot", 12)]).contains("teapot is like none"));
    }

    fn notes_of(size: (u32, u32), machine: Option<&str>) -> String {
        let machines = machine.map(|name| Machines::load(name, false).unwrap());
        let setup = Setup { size, ..Setup::new([rayreel_scenes::load("cornell").unwrap()], machines).unwrap() };
        let none = Experiment { points: Vec::new(), animation: None, ablations: Vec::new(), systems: Vec::new() };
        notes(&setup, &none, &[scene("cornell", 36)]).join("\n")
    }

    /// Of two frames it was said that they are the last ones of runs, and that both have frames before them.
    #[test]
    fn what_is_said_of_an_animation_is_so() {
        let said = |frames: usize| {
            let mut model = rayreel_scenes::load("cornell").unwrap();
            model.cameras = vec![model.cameras[0]; frames];
            let setup = Setup { size: (16, 8), ..Setup::new([model], None).unwrap() };
            let animation = animation::plan(&setup, &mut Plan::new(&setup, "cache".into()));
            let planned = Experiment { points: Vec::new(), animation, ablations: Vec::new(), systems: Vec::new() };
            notes(&setup, &planned, &[scene("cornell", 36)]).join("\n")
        };
        let (two, some) = (said(2), said(160));
        assert!(two.contains("counts 2 of 2 frames. In it") && two.contains("but in its first frame"), "{two}");
        let part = "counts 4 of 160 frames, the first 2, and the last 2 of a run of 4 consecutive frames. In it";
        assert!(some.contains(part), "{some}");
    }

    #[test]
    fn notes_hold_for_this_run() {
        assert!(notes_of((512, 256), None).contains("closer together"));
        assert!(!notes_of((4096, 2048), None).contains("closer together"));
        assert!(!notes_of(SIZE_FULL, None).contains("Pictures have"));
        assert!(notes_of(SIZE_FULL, Some("sgrt-ti2")).contains("the T&I units alone are simulated"));
        assert!(!notes_of(SIZE_FULL, Some("mimd-trax")).contains("T&I units"), "it has none");
    }
}
