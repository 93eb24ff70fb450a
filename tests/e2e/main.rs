//! End-to-end tests: the binary as a user runs it, on real scenes and real files.
//!
//! One test program for all of them, so that it is linked once. Each file holds one idea; `../common` what they share.

#[path = "../common/mod.rs"]
mod common;
/// A made-up study and its pictures.
#[path = "../../study/tests/common/study.rs"]
mod made_up;

mod anchors;
mod aov;
mod browser;
mod charts;
#[cfg(unix)]
mod cluster;
mod columns;
mod compare;
mod damage;
mod detail;
mod determinism;
mod edit;
mod energy;
mod every_scene;
mod exit_codes;
mod export;
mod fence;
mod goldens;
#[cfg(unix)]
mod guards;
mod help;
mod history;
mod hostile;
mod inputs;
#[cfg(unix)]
mod kill;
mod models;
mod outputs;
mod page;
mod page_shapes;
mod paper;
mod policies;
mod presets;
mod readers;
mod repair;
mod replay_json;
mod replay_page;
mod report;
mod stand_in;
mod sweep;
mod sweep_page;
mod tamper;
#[cfg(unix)]
mod timeline;
mod walk;
