//! What the keys of a report mean.

use serde_json::{Map, Value, json};

/// Key, unit and meaning of every figure, in the order of the report. Without a machine its figures are null.
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
    ("limit_factor", "1", "factor on the colour limit (target, foveated relaxation): a tile's, or their mean"),
    ("audited_pixels", "pixels", "pixels that the policy traced whole to see how far off interpolation was"),
    (
        "audited_psnr_db",
        "dB",
        "PSNR of these before: what the policy takes the picture's for; null if nothing differed, or without audits",
    ),
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
    (
        "flip",
        "1",
        "FLIP against full (Andersson et al. 2020), 8-bit sRGB at 67 pixels per degree: 0 no difference seen, 1 the largest; \
      mean over all pixels and frames",
    ),
    (
        "worst_tile_psnr_db",
        "dB",
        "psnr_db of the tile with the largest mean squared error, of all frames; null for identical pictures",
    ),
    ("worst_tile", "index", "number of that tile in its frame, from 0, row by row; null for identical pictures"),
    ("worst_tile_frame", "frame", "the frame of that tile; null for identical pictures"),
    (
        "flicker",
        "8-bit levels",
        "root mean square change of the error (result - full, 8-bit sRGB) from one frame to the next, over all pairs of \
      consecutive frames, of a frame since the one before; an error that stays in its place does not count; null without a pair",
    ),
    (
        "flicker_db",
        "dB",
        "the same as 20 log10(255 / flicker), larger is steadier; null without a pair or without flicker",
    ),
    ("identical", "bool", "the picture equals that of full in every 8-bit sRGB value"),
    ("cycles", "cycles", "length of the run on the machine, cycles of the T&I clock; sum over the frames"),
    ("time_ms", "ms", "simulated time: cycles over the T&I clock"),
    ("fps", "frames/s", "frames over time_ms"),
    (
        "rays_machine",
        "rays",
        "rays that the T&I units took: rays_traced and rays_apron, without primary rays that a rasteriser replaced",
    ),
    ("mrays_per_s", "Mrays/s", "rays_machine over time_ms"),
    ("power_w", "W", "mean power of the T&I units alone, the group ti of energy"),
    ("energy_mj", "mJ", "energy of the T&I units alone"),
    ("energy_per_ray_nj", "nJ", "energy_mj over rays_machine"),
    ("perf_per_watt", "frames/s/W", "fps over power_w"),
    (
        "ti_with_memory",
        "object",
        "power_w, energy_mj, energy_per_ray_nj and perf_per_watt of the T&I units with the dynamic energy of L2 and DRAM that \
      nodes and triangles cause",
    ),
    (
        "gpu",
        "object",
        "power_w, energy_mj, energy_per_ray_nj and perf_per_watt of the whole GPU: T&I units, SRPs, L2 and DRAM",
    ),
    (
        "counters",
        "object",
        "what the machine counted, group/name to value, unit and description; sums over frames, cores and units",
    ),
    (
        "units",
        "list",
        "each issue stage of each unit: the cycles it spent in each class (described in counters), which add up to cycles; \
      those of an SRP are SRP cycles",
    ),
    (
        "energy",
        "list",
        "components: dynamic_mj with the clock tree, leakage_mj (of the DRAM its background), power_w; the GPU is their sum",
    ),
    ("machine_config", "object", "every value of the machine with its class (paper, source, ...) and source"),
];

/// [`FIGURES`] as a JSON object.
pub fn descriptions() -> Value {
    let entry =
        |&(key, unit, text): &(&str, &str, &str)| (key.to_owned(), json!({ "unit": unit, "description": text }));
    Value::Object(FIGURES.iter().map(entry).collect::<Map<_, _>>())
}
