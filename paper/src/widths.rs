//! How wide the columns of names are in what is printed.

use rayreel_study::schema::Study;

/// As wide as names of built-in scenes and presets need, or as the longest name.
#[derive(Clone, Copy)]
pub struct Widths {
    /// Of the scene.
    pub scene: usize,
    /// Of the policy.
    pub policy: usize,
}

impl Widths {
    /// Of all tables of a study.
    pub fn of(study: &Study) -> Self {
        let length = |name: &str| name.chars().count();
        let scenes = study.points.iter().map(|p| &p.scene).chain(study.ablations.iter().map(|a| &a.scene));
        let policies = study.points.iter().map(|p| &p.policy);
        Self {
            scene: scenes.map(|name| length(name)).fold(10, usize::max),
            policy: policies.map(|name| length(name)).fold(12, usize::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Widths;
    use rayreel_study::schema::{Point, Study};

    #[test]
    fn the_longest_name_sets_the_width_of_its_column() {
        let of = |scene: &str, policy: &str| {
            let point = Point { scene: scene.into(), policy: policy.into(), ..Point::default() };
            let Widths { scene, policy } = Widths::of(&Study { points: vec![point], ..Study::default() });
            (scene, policy)
        };
        assert_eq!(of("teapot", "paper-ss"), (10, 12));
        assert_eq!(of("a_dragon_in_a_sphère", "multirate-of-mine"), (20, 17));
    }
}
