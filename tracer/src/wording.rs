//! Words for what verification finds: steps by the names of FORMAT.md, shadow states as `rayreel export` calls them.

use rayreel_formats::half::Half3;
use rayreel_formats::oct::Oct;
use rayreel_formats::tile::{ShadowState, step};

/// A step of a path; none behind its last one.
pub fn step_name(step: Option<&u8>) -> &'static str {
    match step {
        None => "its end",
        Some(&step::NONE) => "NONE",
        Some(&step::LEFT) => "LEFT",
        Some(&step::RIGHT) => "RIGHT",
        Some(&step::LEFT_FIRST) => "LEFT_FIRST",
        Some(&step::RIGHT_FIRST) => "RIGHT_FIRST",
        Some(&step::POP) => "POP",
        Some(&step::CULLED) => "CULLED",
        Some(&step::MISS) => "MISS",
        Some(&step::HIT) => "HIT",
        Some(&step::PASS) => "PASS",
        Some(_) => "no step",
    }
}

/// A shadow state.
pub fn shadow_name(state: ShadowState) -> &'static str {
    match state {
        ShadowState::NotCast => "not cast",
        ShadowState::Lit => "lit",
        ShadowState::Blocked => "blocked",
        ShadowState::Tinted => "tinted",
    }
}

/// A hit.
pub fn hit((triangle, t): (u32, f32)) -> String {
    format!("triangle {triangle} at t {t}")
}

/// The code of a normal.
pub fn normal(code: Oct) -> String {
    format!("({}, {})", code.u, code.v)
}

/// The weight of a child, if there is one.
pub fn weight(weight: Option<Half3>) -> String {
    let Some([x, y, z]) = weight.map(|weight| weight.to_vec3().to_array()) else { return "none".into() };
    format!("({x}, {y}, {z})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_has_a_name_of_its_own() {
        let mut names: Vec<&str> = (step::NONE..=step::PASS).map(|code| step_name(Some(&code))).collect();
        names.extend([step_name(None), step_name(Some(&200))]);
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 12);
    }

    #[test]
    fn what_is_found_is_said_in_words() {
        assert_eq!(hit((5, 3.25)), "triangle 5 at t 3.25");
        assert_eq!(normal(Oct { u: 3, v: 65_534 }), "(3, 65534)");
        assert_eq!(weight(None), "none");
        assert_eq!(weight(Some(Half3::from_vec3(rayreel_formats::math::vec3(0.5, 1.0, 0.25)))), "(0.5, 1, 0.25)");
    }
}
