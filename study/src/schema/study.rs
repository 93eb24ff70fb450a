//! The whole of a study.

use serde::{Deserialize, Serialize};

use crate::schema::ablations::Ablation;
use crate::schema::animation::{Map, Track};
use crate::schema::points::Point;
use crate::schema::references::References;
use crate::schema::setup::{ConfigValue, Policy, Scene};
use crate::schema::systems::SystemPoint;
use crate::schema::viewer::ViewerSet;

/// Version of the structs below; a reader refuses any other.
pub const SCHEMA: u32 = 4;

/// Name of the file in the study's folder.
pub const FILE: &str = "study.json";

/// All results of one experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The program that wrote it, with its version.
    pub tool: String,
    /// What it is called.
    pub title: String,
    /// The command line that repeats it.
    pub command: String,
    /// The machine; null without one.
    pub machine: Option<String>,
    /// How much was simulated cycle by cycle, as `--detail` takes it; null without a machine.
    pub detail: Option<String>,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Sentences that a reader needs: what was sub-sampled, what differs from the paper and why.
    pub notes: Vec<String>,
    /// The preset that the summary speaks of; null lets the report choose.
    pub headline_policy: Option<String>,
    /// The scenes, in the order in which they are shown.
    pub scenes: Vec<Scene>,
    /// The policies, in the order in which they are shown; `full` first.
    pub policies: Vec<Policy>,
    /// One scene under one policy each.
    pub points: Vec<Point>,
    /// What the paper states.
    pub references: References,
    /// Similarity and rate over the frames of a path.
    pub maps: Vec<Map>,
    /// Figures over the frames of a path.
    pub tracks: Vec<Track>,
    /// One choice changed at a time.
    pub ablations: Vec<Ablation>,
    /// Policies on machines.
    pub systems: Vec<SystemPoint>,
    /// Pictures to look at closely.
    pub viewer: Vec<ViewerSet>,
    /// Every value of the machine.
    pub config: Vec<ConfigValue>,
}

impl Study {
    /// The names of the pictures that it shows, relative to its folder; some may stand there twice.
    pub fn pictures(&self) -> impl Iterator<Item = &str> {
        let of_maps = self.maps.iter().flat_map(|map| [Some(&map.similarity), map.rate.as_ref(), map.picture.as_ref()]);
        let of_maps = of_maps.flatten().map(String::as_str);
        self.viewer.iter().flat_map(|set| set.images.names()).chain(of_maps)
    }

    /// The same without pictures: no viewer and no maps, so that it needs no other files.
    #[must_use]
    pub fn without_pictures(self) -> Self {
        Self { viewer: Vec::new(), maps: Vec::new(), ..self }
    }
}
