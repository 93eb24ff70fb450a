//! The whole GPU: what the cores share and how they are coupled.

use rayreel_settings::Rule::{Flag, Integer};
use rayreel_settings::{settings, words};

use super::rules::DEPTH;

words! {
    /// How rays and hits travel between SRP and T&I unit.
    pub enum Interface {
        /// A direct on-chip link (Shin 2013).
        Direct = "direct",
        /// Through system memory: written by one side, read by the other.
        Memory = "memory",
    }

    /// Where the attributes of a tile's samples are kept.
    pub enum GeometryBuffer {
        /// In the SRP's local memory (the tile buffer); what does not fit is spilled and charged.
        OnChip = "on_chip",
        /// In DRAM.
        External = "external",
    }

    /// How primary visibility is found.
    pub enum PrimaryVisibility {
        /// By primary rays.
        Traced = "traced",
        /// By a rasteriser that writes a G-buffer.
        Raster = "raster",
    }
}

words! {
    /// Which core takes the next tile.
    pub enum TileDispatch {
        /// The first core with a free slot: at the beginning of a frame all slots of a core are filled before the next one gets a tile.
        Fill = "fill",
        /// The core with the most free slots, the first of equals.
        Spread = "spread",
    }
}

impl TileDispatch {
    /// The core that takes the next tile, of cores with so many free slots each; none if none has any.
    #[inline]
    pub fn choose(self, mut free: impl Iterator<Item = usize>) -> Option<usize> {
        match self {
            Self::Fill => free.position(|slots| slots > 0),
            Self::Spread => {
                let (mut chosen, mut most) = (None, 0);
                for (core, slots) in free.enumerate() {
                    if slots > most {
                        (chosen, most) = (Some(core), slots);
                    }
                }
                chosen
            }
        }
    }
}

settings! {
    /// The whole GPU.
    #[serde(deny_unknown_fields)]
    pub struct Gpu {
        cores: u32 = Integer(1, 64), "cores: each an SRP and a T&I unit";
        tiles_in_flight: u32 = Integer(1, 16), "tiles that a core works on at a time";
        tile_dispatch: TileDispatch = TileDispatch::RULE, "which core takes the next tile: the first with a free slot, or that with the most free slots";
        interface: Interface = Interface::RULE, "way between SRP and T&I unit";
        interface_bytes_per_cycle: u32 = Integer(1, 1024),
            "width of the direct interface per direction", "bytes per T&I cycle";
        interface_latency_cycles: u32 = DEPTH, "from the end of a message on the direct interface to the other side", "cycles";
        ray_message_bytes: u32 = Integer(1, 256), "size of a ray on the interface", "bytes";
        hit_message_bytes: u32 = Integer(1, 256), "size of a hit on the interface", "bytes";
        stream_flush_cycles: u32 = Integer(1, 10_000), "messages through memory: time after which a partly filled line is written", "cycles";
        stream_reads: u32 = Integer(1, 256), "messages through memory: lines of a stream that can be waited for at a time";
        stream_unwritten_lines: u32 = Integer(1, 4096),
            "messages through memory: lines that wait to be written at which the SRP sends no more rays";
        geometry_buffer: GeometryBuffer = GeometryBuffer::RULE, "place of the geometry buffer";
        primary_visibility: PrimaryVisibility = PrimaryVisibility::RULE, "way to primary visibility";
        warm_caches: bool = Flag,
            "whether caches hold at the beginning of a frame what the frame before left, or nothing";
    }
}

#[cfg(test)]
mod tests {
    use super::TileDispatch;

    #[test]
    fn the_next_tile_fills_a_core_or_goes_where_most_is_free() {
        let chosen = |dispatch: TileDispatch, free: [usize; 4]| dispatch.choose(free.into_iter());
        for (free, fill, spread) in [
            ([2, 2, 2, 2], Some(0), Some(0)),
            ([1, 2, 2, 2], Some(0), Some(1)),
            ([0, 1, 1, 2], Some(1), Some(3)),
            ([0, 0, 1, 1], Some(2), Some(2)),
            ([0, 0, 0, 0], None, None),
        ] {
            assert_eq!(
                (chosen(TileDispatch::Fill, free), chosen(TileDispatch::Spread, free)),
                (fill, spread),
                "{free:?}"
            );
        }
    }
}
