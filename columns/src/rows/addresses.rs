//! One row a read of a node or triangle, ray by ray: what each ray asks of memory, whoever traces it and whenever.

use std::sync::Arc;

use rayreel_formats::trace::Trace;
use rayreel_machine::MachineConfig;
use rayreel_machine::work::layout::{Layout, Span};
use rayreel_machine::work::ops::OpKind;
use rayreel_machine::work::topology::Topology;

use super::kinds::Asked;
use super::paths::each_path;
use super::{TileRows, place, repeat};
use crate::error::Result;
use crate::schema::{Batch, Table, table};
use crate::value::WordsOf;

table! {
    /// The address streams of a trace.
    pub struct AddressRows = "addresses", "a node or triangle that a ray reads, ray by ray in the order of table rays, each ray's in the order in which it needs them" {
        frame: Vec<u32>, "", "frame number";
        tile: Vec<u32>, "", "tile in the frame";
        x: Vec<u32>, "samples", "sample: column of the frame's grid";
        y: Vec<u32>, "samples", "sample: row of the frame's grid";
        index: Vec<u32>, "", "number of the ray in its tile, as in table rays";
        ray: Vec<u32>, "", "number of the ray in its sample, as in table rays";
        order: Vec<u32>, "", "number of the read in its ray";
        what: WordsOf<Asked>, "", "what is read";
        number: Vec<u32>, "", "which node, or which triangle";
        address: Vec<u64>, "bytes", "where it begins in the address space of the machine";
        bytes: Vec<u32>, "bytes", "its size on the machine";
    }
}

/// What addresses follow from beside the trace.
#[derive(Clone, Debug)]
pub struct Addresses {
    tree: Topology,
    layout: Layout,
}

impl Addresses {
    /// The addresses of a trace's nodes and triangles on a machine.
    pub fn new(trace: &Trace, config: &MachineConfig) -> Self {
        Self { tree: Topology::new(trace.bvh()), layout: Layout::new(config) }
    }
}

impl AddressRows {
    #[inline]
    fn one(&mut self, what: Asked, number: u32, Span { address, bytes }: Span) {
        self.what.push(what);
        self.number.push(number);
        self.address.push(address);
        self.bytes.push(bytes as u32);
    }
}

impl TileRows for AddressRows {
    const TABLE: &'static Table = &Self::TABLE;
    const ROWS_A_SAMPLE: u32 = 256;
    type With = Arc<Addresses>;

    fn add(&mut self, trace: &Trace, with: &Arc<Addresses>, tile: (u32, u32)) -> Result<()> {
        each_path(trace, &with.tree, &[], tile, |tile, at, ops, _| {
            let before = self.number.len();
            for op in ops {
                match op.kind() {
                    OpKind::Visit { node, .. } => self.one(Asked::Node, node, with.layout.node_at(node)),
                    OpKind::Leaf { triangle, tests } => (triangle..triangle + u32::from(tests))
                        .for_each(|triangle| self.one(Asked::Triangle, triangle, with.layout.triangle_at(triangle))),
                    OpKind::Pop { .. } | OpKind::Cull { .. } | OpKind::End => {}
                }
            }
            let ((x, y), count) = (place(tile, at.sample), self.number.len() - before);
            repeat(&mut self.frame, tile.frame, count);
            repeat(&mut self.tile, tile.index, count);
            repeat(&mut self.x, x, count);
            repeat(&mut self.y, y, count);
            repeat(&mut self.index, at.index, count);
            repeat(&mut self.ray, at.ray, count);
            self.order.extend(0..count as u32);
        })?;
        Ok(())
    }

    fn into_batch(self) -> Batch {
        self.batch()
    }
}
