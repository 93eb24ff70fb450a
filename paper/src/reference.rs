//! What the paper states: Lee et al. 2016, Table 1, Figure 7 and the text around them.

use rayreel_study::html::has_counterpart;
use rayreel_study::schema::{GainBand, ModePolicy, PaperKernel, PaperPsnr, References, Scene};

use crate::policies::{MODES, PAPER};

/// Name here, triangles, PSNR of Table 1 in dB (supersampling, undersampling), least and most performance per watt over full in
/// Figure 7 (T&I units alone).
type Stated = (&'static str, u64, [f64; 2], f64, Option<f64>);

/// The paper's scenes. For those that are not smooth it states a least gain only.
const SCENES: [Stated; 5] = [
    ("teapot", 15_000, [48.99, 42.13], 2.43, Some(2.98)),
    ("chess", 42_000, [28.53, 34.73], 1.53, None),
    ("car", 55_000, [34.11, 41.68], 2.43, Some(2.98)),
    ("lab", 98_000, [36.28, 42.60], 1.53, None),
    ("provence", 600_000, [30.50, 37.71], 1.53, None),
];

/// Power over full, T&I units alone: "slightly more powers (9%)". Of which scenes, and whether it is a mean, the paper does not say.
const POWER: f64 = 1.09;

/// SRP cycles by kernel, of scenes and modes that the paper does not name.
const SRP: [(&str, f64); 2] = [("similarity", 0.05), ("interpolate", 0.06)];

/// The names of the paper's scenes.
pub fn scenes() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|(name, ..)| *name)
}

/// Triangles of the paper's scene of this kind.
pub fn triangles(scene: &str) -> Option<u64> {
    SCENES.iter().find(|(name, ..)| *name == scene).map(|(_, triangles, ..)| *triangles)
}

/// All that is stated, but for what is of other scenes than those of a study that have their names: a user's models may have any.
pub fn references(scenes: &[Scene]) -> References {
    let is_other = |name: &str| scenes.iter().any(|scene| scene.name == name && !has_counterpart(scene));
    let stated: Vec<Stated> = SCENES.into_iter().filter(|(name, ..)| !is_other(name)).collect();
    let mut all = References { power: Some(POWER), ..References::default() };
    for (i, mode) in MODES.iter().enumerate() {
        all.policies.push(ModePolicy { mode: mode.name.into(), policy: PAPER[i].into() });
        for &(scene, _, psnr, ..) in &stated {
            all.psnr.push(PaperPsnr { scene: scene.into(), mode: mode.name.into(), psnr_db: psnr[i] });
        }
    }
    all.gains =
        stated.iter().map(|&(scene, _, _, least, most)| GainBand { scene: scene.into(), least, most }).collect();
    all.srp = SRP.iter().map(|&(kernel, share)| PaperKernel { kernel: kernel.into(), share }).collect();
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model of a user is not held against what the paper says of a scene of that name.
    #[test]
    fn a_name_alone_is_no_counterpart() {
        let scene = |triangles| Scene {
            name: "provence".into(),
            triangles,
            paper_triangles: self::triangles("provence"),
            lights: 1,
            frame: 1,
            rays_full: Vec::new(),
        };
        let of = |triangles| references(&[scene(triangles)]);
        let names = |all: &References| all.gains.iter().any(|gain| gain.scene == "provence");
        assert!(names(&of(604_367)) && !names(&of(12)));
        assert!(of(12).psnr.iter().all(|stated| stated.scene != "provence") && of(12).gains.len() == 4);
    }
}
