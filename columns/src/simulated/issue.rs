//! What units ask memory for, in the order of issue.

use rayreel_machine::MachineConfig;
use rayreel_machine::memory::{Issued, Lookup, Request, Route};
use rayreel_machine::ports::{Asker, askers, place};
use rayreel_machine::work::layout::{Layout, Region};

use crate::rows::{Asked, Kind};
use crate::schema::table;
use crate::value::{Names, Words, WordsOf, word};

table! {
    /// What units look for, before any cache.
    pub struct LookupRows = "lookups", "a node or triangle that a unit of a T&I unit looks for in its L1 for a ray, in the order of issue; one that comes back after a miss or for its second box is not told again" {
        frame: Vec<u32>, "", "frame number";
        cycle: Vec<u64>, "T&I cycles", "when, from the beginning of the frame";
        core: Vec<u16>, "", "core";
        unit: Words, "", "traversal unit (TRV) or intersection unit (IST) of the core";
        tile: Vec<u32>, "", "tile that the ray is traced for; its sample may lie in the border of a neighbour";
        x: Vec<u32>, "samples", "sample of the ray: column of the frame's grid";
        y: Vec<u32>, "samples", "sample of the ray: row of the frame's grid";
        ray: Vec<u32>, "", "number of the ray in the work of the tile; under policy full its number in the tile, as index of table rays";
        kind: WordsOf<Kind>, "", "what the ray is";
        depth: Vec<u8>, "bounces", "bounces before the ray";
        what: WordsOf<Asked>, "", "what is looked for";
        number: Vec<u32>, "", "which node, or which triangle";
        address: Vec<u64>, "bytes", "where it begins in the address space of the machine";
        bytes: Vec<u32>, "bytes", "its size on the machine";
    }
}

word! {
    /// How a request travels.
    pub enum RouteWord {
        /// A read through the L2.
        Cached = "cached",
        /// A read of DRAM past the L2.
        Read = "read",
        /// A write to DRAM past the L2.
        Write = "write",
    }
}

impl From<Route> for RouteWord {
    fn from(route: Route) -> Self {
        match route {
            Route::Cached => Self::Cached,
            Route::Read => Self::Read,
            Route::Write => Self::Write,
        }
    }
}

table! {
    /// What goes to the memory behind the L1s.
    pub struct RequestRows = "requests", "a line that is asked of the memory behind the L1s, or written there, in the order of issue" {
        frame: Vec<u32>, "", "frame number";
        cycle: Vec<u64>, "T&I cycles", "when it was taken, from the beginning of the frame";
        core: Vec<u16>, "", "core";
        unit: Words, "", "unit of the core: TRV, IST, processor (its data or its code), SRP or DMA";
        region: Words, "", "what for";
        route: WordsOf<RouteWord>, "", "through the L2, or past it to DRAM";
        address: Vec<u64>, "bytes", "first byte of the line";
        bytes: Vec<u32>, "bytes", "size of a line";
    }
}

/// What rows of issue need to know of a machine.
#[derive(Debug)]
pub struct Issue {
    askers: Vec<Asker>,
    /// By port the code of the unit's name.
    units: Vec<u32>,
    unit_names: Names,
    region_names: Names,
    layout: Layout,
    line_bytes: u32,
}

impl Issue {
    /// On a machine.
    pub fn new(config: &MachineConfig) -> Self {
        let askers = askers(config);
        let mut names: Vec<String> = Vec::new();
        let mut code = |asker: &Asker| {
            let known = names.iter().position(|name| *name == asker.unit);
            known.unwrap_or_else(|| {
                names.push(asker.unit.clone());
                names.len() - 1
            }) as u32
        };
        let units = askers.iter().map(&mut code).collect();
        Self {
            units,
            unit_names: Names::shared(names),
            region_names: Names::shared(Region::ALL.iter().map(|region| region.name().to_owned())),
            layout: Layout::new(config),
            line_bytes: config.l2.line_bytes,
            askers,
        }
    }

    /// Rows of lookups, without any yet.
    pub fn lookups(&self) -> LookupRows {
        LookupRows { unit: Words { codes: Vec::new(), names: self.unit_names.clone() }, ..LookupRows::default() }
    }

    /// Adds a lookup.
    pub fn add_lookup(&self, rows: &mut LookupRows, frame: u32, Issued { at, what: lookup }: Issued<Lookup>) {
        let (port, index) = (place(lookup.port), lookup.index);
        let (what, span) = match lookup.region {
            Region::Node => (Asked::Node, self.layout.node_at(index)),
            _ => (Asked::Triangle, self.layout.triangle_at(index)),
        };
        rows.frame.push(frame);
        rows.cycle.push(at.0);
        rows.core.push(self.askers[port].core as u16);
        rows.unit.codes.push(self.units[port]);
        rows.tile.push(lookup.tile);
        rows.x.push(lookup.sample.0);
        rows.y.push(lookup.sample.1);
        rows.ray.push(lookup.ray);
        rows.kind.push(lookup.kind.into());
        rows.depth.push(lookup.depth);
        rows.what.push(what);
        rows.number.push(index);
        rows.address.push(span.address);
        rows.bytes.push(span.bytes as u32);
    }

    /// Rows of requests, without any yet.
    pub fn requests(&self) -> RequestRows {
        RequestRows {
            unit: Words { codes: Vec::new(), names: self.unit_names.clone() },
            region: Words { codes: Vec::new(), names: self.region_names.clone() },
            ..RequestRows::default()
        }
    }

    /// Adds a request.
    pub fn add_request(&self, rows: &mut RequestRows, frame: u32, Issued { at, what: request }: Issued<Request>) {
        let port = place(request.port);
        rows.frame.push(frame);
        rows.cycle.push(at.0);
        rows.core.push(self.askers[port].core as u16);
        rows.unit.codes.push(self.units[port]);
        rows.region.codes.push(request.region as u32);
        rows.route.push(request.route.into());
        rows.address.push(request.line * u64::from(self.line_bytes));
        rows.bytes.push(self.line_bytes);
    }
}
