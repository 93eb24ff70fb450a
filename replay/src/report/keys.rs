//! What the keys of a report mean.

use serde_json::{Map, Value, json};

/// Key, unit and meaning of every figure.
pub const FIGURES: &[(&str, &str, &str)] = &[
    ("rays_full", "rays", "rays of all samples of the grid: what tracing everything costs"),
    ("rays_traced", "rays", "rays of the traced samples, apron rays not included"),
    ("rays_apron", "rays", "rays of samples of neighbouring tiles that were traced again (apron = \"retrace\")"),
    ("rays_saved", "rays", "rays_full - rays_traced - rays_apron"),
    ("rays_by_kind", "rays", "rays_full, rays_traced and rays_apron by kind"),
    ("samples_full", "samples", "samples of the grid"),
    ("samples_reference", "samples", "R-samples: always traced"),
    ("samples_traced", "samples", "samples traced: R-samples and dissimilar I-samples, apron samples not included"),
    ("samples_interpolated", "samples", "I-samples interpolated"),
    ("samples_apron", "samples", "samples of neighbouring tiles that were traced again"),
    ("similarity_ratio", "1", "samples_interpolated per I-sample; null where there are no I-samples"),
    (
        "psnr_db",
        "dB",
        "peak signal-to-noise ratio against full, on 8-bit sRGB; of the mean squared error over all frames; \
      null for identical pictures",
    ),
    (
        "ssim",
        "1",
        "structural similarity against full (Wang et al. 2004), on BT.601 luma of 8-bit sRGB; mean over all frames; \
      null for pictures below 11 pixels",
    ),
    ("identical", "bool", "the picture equals that of full in every 8-bit sRGB value"),
];

/// [`FIGURES`] as a JSON object.
pub fn descriptions() -> Value {
    let entry =
        |&(key, unit, text): &(&str, &str, &str)| (key.to_owned(), json!({ "unit": unit, "description": text }));
    Value::Object(FIGURES.iter().map(entry).collect::<Map<_, _>>())
}
