//! Components that only some machines have: processors, and a rasteriser.

use super::{Component, Group, RASTERISER, Sums, l1_bytes};
use crate::config::Picojoules;
use crate::memory::CacheCounters;
use crate::srp::RasterCounters;
use crate::traversal::ProcessorCounters;

impl Sums<'_> {
    /// Processors do the work of T&I units and of SRPs: there is no T&I unit to measure.
    pub(super) fn processors(&self) -> [Component; 5] {
        let (energy, config) = (&self.config.energy, self.config);
        let (mut all, mut code) = (ProcessorCounters::default(), CacheCounters::default());
        for processor in self.stats.processors() {
            all += processor.counters;
            code += processor.code_l1;
        }
        let clock = self.stats.trv().map(|unit| unit.stages.first().map_or(0, |(_, a)| a.total() - a.idle)).sum();
        let count = self.cores * u64::from(config.ti.trv);
        let rays: u64 = self.stats.cores.iter().map(|core| core.ti.dispatch.rays).sum();
        let of = |name, events: &[(u64, Picojoules)], bytes| self.component(name, Group::Srp, events, 0, bytes);
        let none = Picojoules::default();
        let records = [(rays, energy.ray_buffer_write_pj), (rays, energy.ray_buffer_read_pj)];
        [
            self.clocked(
                "processors",
                Group::Srp,
                &[
                    (all.instructions, energy.instruction_pj),
                    (all.lane_instructions, energy.lane_pj),
                    (all.add, energy.add_pj),
                    (all.multiply, energy.multiply_pj),
                    (all.compare, energy.compare_pj),
                    (all.integer, energy.integer_pj),
                    (all.special, energy.special_pj),
                    (clock, energy.processor_clock_pj),
                ],
                count * energy.processor_leakage_uw,
            ),
            of(
                "data_l1",
                &[&[(all.words, energy.word_pj)][..], &self.l1(&config.ti.trv_l1, none, &self.trv_l1, 0)].concat(),
                count * l1_bytes(&config.ti.trv_l1),
            ),
            of(
                "code_l1",
                &self.l1(&config.processor.code_l1, none, &code, 0),
                count * l1_bytes(&config.processor.code_l1),
            ),
            of("stacks", &[], count * config.stack_bytes()),
            of("ray_buffers", &records, config.ray_buffer_bytes()),
        ]
    }

    pub(super) fn raster(&self) -> Component {
        let (energy, mut work) = (&self.config.energy, RasterCounters::default());
        self.stats.cores.iter().for_each(|core| work += core.srp.raster);
        let events = [(work.triangles, energy.raster_triangle_pj), (work.samples, energy.raster_sample_pj)];
        self.component(RASTERISER, Group::Srp, &events, self.cores * energy.raster_leakage_uw, 0)
    }
}
