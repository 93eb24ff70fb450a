//! The sections of the page, one file each. A section without data is left out.

mod ablations;
mod animation;
mod config;
mod energy;
mod figure7;
mod maps;
mod policies;
mod setup;
mod srp;
mod summary;
mod systems;
mod table1;
mod units;
pub mod viewer;

use crate::html::parts::Section;
use crate::html::view::StudyView;
use viewer::Pictures;

/// All sections that have data, in order.
pub fn all(view: &StudyView<'_>, pictures: &Pictures) -> Vec<Section> {
    let sections = [
        summary::section(view),
        viewer::section(view, pictures),
        figure7::section(view),
        table1::section(view),
        policies::section(view),
        systems::section(view),
        maps::section(view, pictures),
        animation::section(view),
        energy::section(view),
        units::section(view),
        srp::section(view),
        ablations::section(view),
        setup::section(view),
        config::section(view),
    ];
    sections.into_iter().flatten().collect()
}
