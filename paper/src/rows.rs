//! The points for programs, beside the paper's values: paper.json.

use rayreel_study::schema::{Cost, Point, Study};
use serde_json::{Value, json};

/// One row a point, without those of `full`, with which the others are compared.
pub fn rows(study: &Study) -> Value {
    Value::Array(study.points.iter().filter(|p| p.kind != "full").map(|p| row(study, p)).collect())
}

fn row(study: &Study, point: &Point) -> Value {
    let references = &study.references;
    let full = study.points.iter().find(|p| p.kind == "full" && p.scene == point.scene && p.mode == point.mode);
    let quality = point.quality.unwrap_or_default();
    let evaluated = references.policies.iter().any(|p| p.mode == point.mode && p.policy == point.policy);
    let psnr = references.psnr.iter().find(|p| p.scene == point.scene && p.mode == point.mode);
    let band = references.gains.iter().find(|band| band.scene == point.scene);
    let mut value = json!({
        "scene": point.scene,
        "mode": point.mode,
        "policy": point.policy,
        "machine": point.machine,
        "rays_full": point.rays_full,
        "rays_traced": point.rays_traced,
        "ray_ratio": point.rays_full as f64 / point.rays_traced.max(1) as f64,
        "mean_rate": point.mean_rate,
        "psnr_db": quality.psnr_db,
        "ssim": quality.ssim,
        "flip": quality.flip,
        "worst_tile_psnr_db": quality.worst_tile_psnr_db,
        "as_in_the_paper": evaluated,
        "paper_psnr_db": psnr.map(|p| p.psnr_db),
        "ti_alone": null,
        "gpu": null,
        "srp": null,
    });
    let pair = |cost: Option<Cost>, full: Option<Cost>| Some((cost?, full?));
    let full_ti = full.and_then(|p| p.ti);
    if let Some((cost, full)) = pair(point.ti, full_ti) {
        value["ti_alone"] = json!({
            "full": full,
            "own": cost,
            "gain": point.ti_gain,
            "gain_over_fsaa": point.fsaa_gain,
            "paper_perf_per_watt": band.map(|b| json!({ "least": b.least, "most": b.most })),
            "paper_power": references.power,
        });
    }
    if let Some((cost, full)) = pair(point.gpu, full.and_then(|p| p.gpu)) {
        value["gpu"] = json!({ "full": full, "own": cost, "gain": point.gpu_gain });
        let [tests, interpolation] = point.sampling_shares();
        let paper = |name: &str| references.srp.iter().find(|k| k.kernel == name).map(|k| k.share);
        value["srp"] = json!({
            "similarity_share": tests,
            "interpolation_share": interpolation,
            "paper_similarity_share": paper("similarity"),
            "paper_interpolation_share": paper("interpolate"),
        });
    }
    value
}
