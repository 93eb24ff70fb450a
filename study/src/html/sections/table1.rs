//! The paper's Table 1: PSNR, with the other quality figures beside it.

use crate::html::modes::{by_mode, mode_name, mode_reference};
use crate::html::parts::{Head, Section, details, how_to_read, table};
use crate::html::text::{decibels, escape, fixed, or_dash, psnr};
use crate::html::view::StudyView;
use crate::schema::{PaperPsnr, Point};

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let compared = |p: &&Point| p.quality.is_some() && p.kind != "full";
    if !view.points.iter().any(compared) {
        return None;
    }
    let mut html = by_mode(view, |mode| psnr_table(view, mode));
    let last = if view.modes().into_iter().any(|mode| !stated(view, mode).is_empty()) {
        " The last rows are the paper's, measured on its own models."
    } else {
        ""
    };
    html += &how_to_read(&format!(
        "PSNR on 8-bit sRGB against the picture with every sample traced, same mode; higher is closer. Above about 40 dB the \
         difference is hard to see.{last}"
    ));
    html += &details("SSIM, FLIP and the worst tile", &by_mode(view, |mode| others(view, mode)));
    Section::new("table1", "Table 1: image quality", html)
}

/// The paper's PSNR by scene, for the scenes of the study that it has.
fn stated<'a>(view: &StudyView<'a>, mode: &str) -> Vec<&'a PaperPsnr> {
    let scenes = view.scenes(mode);
    view.study.references.psnr.iter().filter(|p| p.mode == mode && scenes.contains(&p.scene.as_str())).collect()
}

fn psnr_table(view: &StudyView<'_>, mode: &str) -> String {
    let scenes = view.scenes(mode);
    let mut columns = vec![Head::words("Policy")];
    columns.extend(scenes.iter().map(|scene| Head::number(scene)));
    columns.push(Head::number("Least"));
    let mut rows = Vec::new();
    for policy in view.policies(Some(mode)) {
        let qualities: Vec<_> =
            scenes.iter().map(|scene| view.point(scene, mode, policy).and_then(|p| p.quality)).collect();
        if qualities.iter().all(Option::is_none) {
            continue;
        }
        let mut cells = vec![escape(policy)];
        cells.extend(qualities.iter().map(|q| or_dash(*q, |q| psnr(q.psnr_db))));
        let least =
            qualities.iter().flatten().map(|q| q.psnr_db.unwrap_or(f64::INFINITY)).fold(f64::INFINITY, f64::min);
        cells.push(psnr(least.is_finite().then_some(least)));
        let class = if view.headline == Some(policy) { "strong" } else { "" };
        rows.push((class.into(), cells));
    }
    let stated = stated(view, mode);
    if !stated.is_empty() {
        let mut cells = vec!["the paper".to_owned()];
        let values: Vec<Option<f64>> =
            scenes.iter().map(|scene| stated.iter().find(|p| p.scene == *scene).map(|p| p.psnr_db)).collect();
        cells.extend(values.iter().map(|v| or_dash(*v, decibels)));
        let least = values.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        cells.push(or_dash(least.is_finite().then_some(least), decibels));
        rows.push(("paper-row".into(), cells));
    }
    table(&format!("PSNR, {}", mode_name(mode).to_lowercase()), &columns, &rows)
}

fn others(view: &StudyView<'_>, mode: &str) -> String {
    let columns = [
        Head::words("Scene"),
        Head::words("Policy"),
        Head::number("PSNR"),
        Head::number("Worst tile"),
        Head::number("SSIM"),
        Head::number("FLIP"),
    ];
    let mut rows = Vec::new();
    for scene in view.scenes(mode) {
        for point in view.of(scene, mode).into_iter().filter(|p| p.kind != "full") {
            let Some(quality) = point.quality else { continue };
            let cells = vec![
                escape(scene),
                escape(&point.policy),
                psnr(quality.psnr_db),
                psnr(quality.worst_tile_psnr_db),
                or_dash(quality.ssim, |v| fixed(v, 4)),
                or_dash(quality.flip, |v| fixed(v, 4)),
            ];
            rows.push((String::new(), cells));
        }
    }
    table(&format!("Quality against {}", mode_reference(mode)), &columns, &rows)
}
