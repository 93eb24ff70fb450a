//! How wide a traversal unit is, and what area its logic takes by it: its clock and its leakage follow that.

use super::ti::Pipeline;
use super::whole::MachineConfig;

/// Tests that a traversal unit does in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrvWidth {
    /// Of boxes.
    pub boxes: u32,
    /// Of triangles, where it intersects too.
    pub triangles: u32,
}

impl MachineConfig {
    /// Width of a traversal unit.
    pub fn trv_width(&self) -> TrvWidth {
        let ti = &self.ti;
        let boxes = if ti.pipeline == Pipeline::Gathering { 2 * ti.gather_boxes } else { ti.aabbs_per_cycle };
        let triangles = match ti.pipeline {
            Pipeline::Unified => 1,
            Pipeline::Gathering => ti.gather_triangles,
            Pipeline::Parallel | Pipeline::Single | Pipeline::Software => 0,
        };
        TrvWidth { boxes, triangles }
    }

    /// Width of the traversal unit that the energies of traversal units are of.
    pub fn trv_priced_width(&self) -> TrvWidth {
        TrvWidth { boxes: self.energy.trv_priced_boxes, triangles: self.energy.trv_priced_triangles }
    }

    /// Logic of a traversal unit of this width, square micrometres.
    pub fn trv_um2(&self, width: TrvWidth) -> u64 {
        let area = &self.area;
        area.trv_control_um2 + u64::from(width.boxes) * area.box_um2 + u64::from(width.triangles) * area.triangle_um2
    }
}
