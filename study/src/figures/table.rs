//! The table of figures. To add a figure, add its line here and its value where the struct is made (`report::sampling`,
//! `report::run`).

use std::sync::LazyLock;

use serde::Serialize;

use crate::figures::kinds::{Better, Form, OverFrames};
use rayreel_replay::counts::RayCounts;

/// What a figure is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Its key in a report.
    pub name: &'static str,
    /// Its unit: `rays`, `dB`, `1` for a ratio, ...
    pub unit: &'static str,
    /// What it means, of the T&I units alone where it is a cost.
    pub description: &'static str,
    /// For a cost, what it means where the part of the machine is said before it.
    pub of_part: Option<&'static str>,
    /// Which way it is better.
    pub better: Better,
    /// How several frames add up.
    pub frames: OverFrames,
    /// What stands under its key.
    pub form: Form,
}

/// Declares figures, each as `name: type => unit, better, over frames, meaning`; a cost also has `of a part` with its meaning there,
/// and what is no single value has a `form`.
///
/// The first rule makes a struct, which serializes under the names of its figures, and the list of what they are; `..name: Type`
/// takes in the figures of another struct. The second rule makes the list alone, for values that are kept elsewhere.
macro_rules! figures {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $($field:ident: $type:ty => $unit:literal, $better:ident, $frames:ident, $text:literal
                $(, of a part $of_part:literal)? $(, form $form:expr)?;)*
            $(..$inner:ident: $inner_type:ident => $inner_text:literal;
                $($next:ident: $next_type:ty => $next_unit:literal, $next_better:ident, $next_frames:ident, $next_text:literal
                    $(, form $next_form:expr)?;)*)?
        }
    ) => {
        $(#[$meta])*
        $vis struct $name {
            $(#[doc = concat!($text, " (", $unit, ").")] pub $field: $type,)*
            $(
                #[doc = $inner_text]
                #[serde(flatten)]
                pub $inner: $inner_type,
                $(#[doc = concat!($next_text, " (", $next_unit, ").")] pub $next: $next_type,)*
            )?
        }

        impl $name {
            /// What its figures are, in their order.
            pub fn figures() -> Vec<Figure> {
                let all = vec![
                    $(figures!(@one $field, $unit, $better, $frames, $text $(, of $of_part)? $(, form $form)?)),*
                ];
                $(
                    let next = vec![
                        $(figures!(@one $next, $next_unit, $next_better, $next_frames, $next_text $(, form $next_form)?)),*
                    ];
                    let all = [all, $inner_type::figures(), next].concat();
                )?
                all
            }
        }
    };
    (
        $(#[$meta:meta])*
        fn $name:ident {
            $($field:ident => $unit:literal, $better:ident, $frames:ident, $text:literal, form $form:expr;)*
        }
    ) => {
        $(#[$meta])*
        fn $name() -> Vec<Figure> {
            vec![$(figures!(@one $field, $unit, $better, $frames, $text, form $form)),*]
        }
    };
    (@one $field:ident, $unit:literal, $better:ident, $frames:ident, $text:literal
        $(, of $of_part:literal)? $(, form $form:expr)?) => {
        Figure {
            name: stringify!($field),
            unit: $unit,
            description: $text,
            of_part: figures!(@some $($of_part)?),
            better: Better::$better,
            frames: OverFrames::$frames,
            form: figures!(@form $($form)?),
        }
    };
    (@some) => { None };
    (@some $of_part:literal) => { Some($of_part) };
    (@form) => { Form::Value };
    (@form $form:expr) => { $form };
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ByKind {
    /// Of all samples.
    pub full: RayCounts,
    /// Of the traced samples.
    pub traced: RayCounts,
    /// Of the apron samples.
    pub apron: RayCounts,
}

figures! {
    /// Rays, samples and quality of one frame, or of all. What is compared with `full` is null without a comparison.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub struct SamplingFigures {
        rays_full: u64 => "rays", Neither, Sum, "rays of all samples of the grid: what tracing everything costs";
        rays_traced: u64 => "rays", Less, Sum, "rays of the traced samples, apron rays not included";
        rays_apron: u64 => "rays", Less, Sum,
            "rays of samples of neighbouring tiles that were traced again (apron = \"retrace\")";
        rays_saved: i64 => "rays", More, Sum, "rays_full - rays_traced - rays_apron";
        rays_by_kind: ByKind => "rays", Neither, Sum, "rays_full, rays_traced and rays_apron by kind", form Form::ByKind;
        samples_full: u64 => "samples", Neither, Sum, "samples of the grid";
        samples_reference: u64 => "samples", Neither, Sum, "R-samples: always traced";
        samples_traced: u64 => "samples", Less, Sum,
            "samples traced: R-samples and dissimilar I-samples, apron samples not included";
        samples_interpolated: u64 => "samples", More, Sum, "I-samples interpolated";
        samples_apron: u64 => "samples", Less, Sum, "samples of neighbouring tiles that were traced again";
        similarity_ratio: Option<f64> => "1", More, Whole,
            "samples_interpolated per I-sample; null where there are no I-samples";
        limit_factor: Option<f64> => "1", Neither, Mean,
            "factor on the colour limit (target, foveated relaxation): a tile's, or their mean";
        audited_pixels: u64 => "pixels", Neither, Sum,
            "pixels that the policy traced whole to see how far off interpolation was";
        audited_psnr_db: Option<f64> => "dB", More, Whole,
            "PSNR of these before: what the policy takes the picture's for; null if nothing differed, or without audits";
        psnr_db: Option<f64> => "dB", More, Whole,
            "peak signal-to-noise ratio against full, on 8-bit sRGB; of the mean squared error over all frames; \
             null for identical pictures";
        ssim: Option<f64> => "1", More, Mean,
            "structural similarity against full (Wang et al. 2004), on BT.601 luma of 8-bit sRGB; mean over all frames; \
             null for pictures below 11 pixels";
        flip: Option<f64> => "1", Less, Mean,
            "FLIP against full (Andersson et al. 2020), 8-bit sRGB at 67 pixels per degree: 0 no difference seen, 1 the \
             largest; mean over all pixels and frames";
        worst_frame_psnr_db: Option<f64> => "dB", More, Whole,
            "psnr_db of the frame with the largest mean squared error; null for identical pictures";
        worst_tile_psnr_db: Option<f64> => "dB", More, Whole,
            "psnr_db of the tile with the largest mean squared error, of all frames; null for identical pictures";
        worst_tile: Option<u32> => "index", Neither, Whole,
            "number of that tile in its frame, from 0, row by row; null for identical pictures";
        worst_tile_frame: Option<u32> => "frame", Neither, Whole,
            "the frame of that tile; null for identical pictures";
        flicker: Option<f64> => "8-bit levels", Less, Whole,
            "root mean square change of the error (result - full, 8-bit sRGB) from one frame to the next, over all pairs of \
             consecutive frames, of a frame since the one before; an error that stays in its place does not count; null \
             without a pair";
        flicker_db: Option<f64> => "dB", More, Whole,
            "the same as 20 log10(255 / flicker), larger is steadier; null without a pair or without flicker";
        identical: Option<bool> => "bool", More, Whole, "the picture equals that of full in every 8-bit sRGB value";
    }
}

figures! {
    /// What a part of the machine costs; null where nothing was done in no time.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
    pub struct RunCost {
        power_w: Option<f64> => "W", Less, Whole, "mean power of the T&I units alone, the group ti of energy",
            of a part "mean power";
        energy_mj: Option<f64> => "mJ", Less, Sum, "energy of the T&I units alone", of a part "energy";
        energy_per_ray_nj: Option<f64> => "nJ", Less, Whole, "energy_mj over rays_machine",
            of a part "energy_mj over rays_machine";
        perf_per_watt: Option<f64> => "frames/s/W", More, Whole, "fps over power_w", of a part "fps over power_w";
    }
}

figures! {
    /// Time, speed and power of one frame or of all; everything is null without a machine.
    #[derive(Clone, Debug, Default, PartialEq, Serialize)]
    pub struct RunFigures {
        cycles: Option<u64> => "cycles", Less, Sum,
            "length of the run on the machine, cycles of the T&I clock; sum over the frames";
        time_ms: Option<f64> => "ms", Less, Sum, "simulated time: cycles over the T&I clock";
        fps: Option<f64> => "frames/s", More, Whole, "frames over time_ms";
        rays_machine: Option<u64> => "rays", Less, Sum,
            "rays that the T&I units took: rays_traced and rays_apron, without primary rays that a rasteriser replaced";
        mrays_per_s: Option<f64> => "Mrays/s", More, Whole, "rays_machine over time_ms";
        ..ti: RunCost => "Cost of the T&I units alone.";
        ti_with_memory: Option<RunCost> => "object", Neither, Whole,
            "power_w, energy_mj, energy_per_ray_nj and perf_per_watt of the T&I units with the dynamic energy of L2 and DRAM \
             that nodes and triangles cause",
            form Form::Costs("T&I units with their L2 and DRAM energy");
        gpu: Option<RunCost> => "object", Neither, Whole,
            "power_w, energy_mj, energy_per_ray_nj and perf_per_watt of the whole GPU: T&I units, SRPs, L2 and DRAM",
            form Form::Costs("whole GPU");
        ti_area_mm2: Option<f64> => "mm2", Less, Whole, "area of the T&I units: a pure function of the machine";
        gpu_area_mm2: Option<f64> => "mm2", Less, Whole, "area of the whole GPU without DRAM, its controller and its PHY";
        mrays_per_mm2: Option<f64> => "Mrays/s/mm2", More, Whole, "mrays_per_s over ti_area_mm2";
        gpu_mrays_per_mm2: Option<f64> => "Mrays/s/mm2", More, Whole, "mrays_per_s over gpu_area_mm2";
    }
}

figures! {
    /// What a report says of the machine beside figures; all of it is null without one.
    fn machine_details {
        detail => "object", Neither, Whole,
            "how much was simulated cycle by cycle (mode full: all of it), and where that is not all, half the width of the 95 % \
             interval of each estimated figure, in percent of it, by column; what is not listed is exact",
            form Form::Listing;
        counters => "object", Neither, Sum,
            "what the machine counted, group/name to value, unit and description; sums over frames, cores and units",
            form Form::Counters;
        units => "list", Neither, Sum,
            "each issue stage of each unit: the cycles it spent in each class (described in counters), which add up to \
             cycles; those of an SRP are SRP cycles",
            form Form::Listing;
        energy => "list", Neither, Sum,
            "components: dynamic_mj with the clock tree, leakage_mj (of the DRAM its background), power_w; the GPU is their \
             sum",
            form Form::Components;
        area_mm2 => "mm2", Less, Whole,
            "area by component, names as those of energy; ti and gpu are the sums of their components",
            form Form::Listing;
        machine_config => "object", Neither, Whole,
            "every value of the machine with its class (paper, source, ...) and source",
            form Form::Listing;
    }
}

/// All figures, in the order of a report.
pub fn figures() -> &'static [Figure] {
    static ALL: LazyLock<Vec<Figure>> =
        LazyLock::new(|| [SamplingFigures::figures(), RunFigures::figures(), machine_details()].concat());
    &ALL
}

/// Whether a report has a figure of this name.
pub fn is_key(name: &str) -> bool {
    figures().iter().any(|figure| figure.name == name)
}
