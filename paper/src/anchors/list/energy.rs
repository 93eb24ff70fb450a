//! Joules a ray.

use super::replays::{FULL, SGRT};
use crate::anchors::anchor::{Anchor, Rows, Value, Why};
use crate::anchors::of::{chip_nj, figure, on_chip_nj};

pub const ANCHORS: &[Anchor] = &[
    Anchor {
        name: "on-chip energy a ray",
        source: "our estimate: 25 tests of two boxes x (30 + 5.7 + 7 pJ), 5 triangles x (42 + 5 pJ), 3 lines of the L2 x 14 pJ and \
                 15 operations of the stack x 0.4 pJ = 1.35 nJ; bounds with the box pair at 16 and 60 pJ and the triangle at 25 \
                 and 90",
        unit: "nJ/ray",
        low: Some(0.92),
        high: Some(2.34),
        rows: Rows::Machines(SGRT),
        value: Value::Runs(&[FULL], |of| Some(on_chip_nj(&of[0])? / figure(&of[0], "rays_machine")?)),
        why: &[Why {
            of: &[],
            below: "",
            above: "The estimate has 25 node visits, 5 triangles and 3 lines of the L2 a ray; these scenes have 21 to 53, 7 to \
                    16 and 3 to 15. It has 7 pJ of ray buffer a visit and no clocks; here each operation is written and read \
                    for 14.5 pJ, again after each bypass where misses retry, and units pay for their clocks. Teapot, nearest \
                    in its lines, takes 2.4 nJ at 128x64 pixels on sgrt-ti2.",
        }],
    },
    Anchor {
        name: "energy a ray of RayCore",
        source: "RayCore (embedded.com report): 1 W at 239 Mrays/s = 4.2 nJ at 28 nm x 0.45 to 14 nm = 1.9 nJ, everything but \
                 DRAM; a factor of two either way",
        unit: "nJ/ray",
        low: Some(0.95),
        high: Some(3.8),
        rows: Rows::One(Some("raycore")),
        value: Value::Runs(&[FULL], |of| Some(chip_nj(&of[0])? / figure(&of[0], "rays_machine")?)),
        why: &[Why {
            of: &[],
            below: "",
            above: "The bounds follow from a peak rate that leaves 12.6 operations a ray, if a unit has one pipeline; here a \
                    ray takes 30 to 63 node visits and triangle tests. At 128x64 pixels units, L2 and wires alone take 3.2 nJ \
                    in teapot, which lies inside with 3.7 in all, and 10.6 in provence, with the energies of SGRT and not of \
                    RayCore.",
        }],
    },
];
