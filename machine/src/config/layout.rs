//! What lies in memory and how large it is, and the rasteriser.

use rayreel_settings::Rule::Integer;
use rayreel_settings::{Rule, settings, words};

/// Edge of a square of texels; a power of two.
const TEXELS: Rule = Integer(1, 256);

words! {
    /// Order of the pixels in memory.
    pub enum Framebuffer {
        /// Tile by tile, as tile-based GPUs write them: the pixels of a tile lie together.
        Tiled = "tiled",
        /// Row by row of the picture.
        Linear = "linear",
    }
}

settings! {
    /// Sizes of what lies in memory.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct LayoutSizes {
        node_bytes: u32 = Integer(8, 256), "a node of two children", "bytes";
        triangle_bytes: u32 = Integer(8, 256), "a triangle", "bytes";
        texture_block: u32 = TEXELS, "edge of the square of texels that lie together", "texels";
        texture_tile: u32 = TEXELS, "edge of the square whose blocks lie together", "texels";
        framebuffer: Framebuffer = Framebuffer::RULE, "order of the pixels of the framebuffer";
        pixel_bytes: u32 = Integer(1, 32), "a pixel of the framebuffer", "bytes";
        ring_lines: u32 = Integer(256, 65_536), "ring buffer in memory of a stream of messages", "lines";
    }

    /// The rasteriser of a hybrid GPU.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct Raster {
        samples_per_cycle: u32 = Integer(1, 64), "what the rasteriser of a core makes", "samples per T&I cycle";
        setup_cycles: u32 = Integer(1, 1000), "a triangle set up by the rasteriser of a core", "cycles";
        overdraw_percent: u32 = Integer(100, 10_000),
            "triangles and samples that are rasterised, of those that are seen: others lie behind them", "%";
        triangle_bytes: u32 = Integer(1, 1024), "a triangle in the list of its tile: written when it is binned, read by the rasteriser", "bytes";
        gbuffer_bytes: u32 = Integer(1, 256), "a G-buffer sample, written by the rasteriser and read by the SRP", "bytes";
    }
}
