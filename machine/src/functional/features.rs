//! What is characteristic of a tile: the sums that its time depends on.

use crate::work::cost;

/// How many there are.
pub const FEATURES: usize = 9;

/// What is characteristic of a tile, of several, or of parts of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Features(pub [f64; FEATURES]);

/// Places in [`Features`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Feature {
    /// The work of the T&I units: see [`cost`].
    Cost,
    TriangleTests,
    TrvMisses,
    IstMisses,
    /// Lines to and from DRAM.
    DramLines,
    /// SRP cycles of items, without prologues.
    SrpCycles,
    Rays,
    /// The work of the SRPs.
    SrpWork,
    /// T&I cycles of all cores, about: see [`Pace`](super::pace::Pace).
    Cycles,
}

impl Features {
    /// The work of the T&I units: node visits, one and a half for each triangle test, and four for each ray.
    pub fn cost(&self) -> f64 {
        self.0[Feature::Cost as usize]
    }

    /// The size: all work, that of the SRPs in cycles of their items. Where little is traced, T&I units are done long before the SRPs:
    /// by their work alone a machine would stand still for most of the time of such tiles.
    pub fn size(&self) -> f64 {
        self.cost() + self.0[Feature::SrpWork as usize]
    }

    pub(super) fn add_traversal(&mut self, visits: u64, tests: u64, rays: u64) {
        self.0[Feature::Cost as usize] += cost(visits, tests, rays);
        self.0[Feature::TriangleTests as usize] += tests as f64;
        self.0[Feature::Rays as usize] += rays as f64;
    }

    pub(super) fn add_misses(&mut self, trv: u64, ist: u64) {
        self.0[Feature::TrvMisses as usize] += trv as f64;
        self.0[Feature::IstMisses as usize] += ist as f64;
    }

    pub(super) fn add_lines(&mut self, lines: u64) {
        self.0[Feature::DramLines as usize] += lines as f64;
    }

    pub(super) fn add_srp_cycles(&mut self, cycles: u64) {
        self.0[Feature::SrpCycles as usize] += cycles as f64;
    }

    /// SRP cycles of items, without prologues.
    pub(super) fn srp_cycles(&self) -> f64 {
        self.0[Feature::SrpCycles as usize]
    }

    pub(super) fn add_cycles(&mut self, cycles: f64) {
        self.0[Feature::Cycles as usize] += cycles;
    }

    pub(super) fn add_srp_work(&mut self, cycles: u64) {
        self.0[Feature::SrpWork as usize] += cycles as f64;
    }

    /// Adds `part` of `other`.
    pub fn add_part(&mut self, other: &Self, part: f64) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum += part * more);
    }
}
