//! Every value of the tables, found a second way: from the trace by the functions of its own crate, and from what other tables say.

mod common;

use std::collections::BTreeMap;

use common::{Rows, trace, traces};
use rayreel_columns::order::ROWS;
use rayreel_columns::{Batch, Column as Values, Data, Selection, Use, What};
use rayreel_formats::Trace;
use rayreel_formats::intersect::intersect;
use rayreel_formats::rays::RayEnd;
use rayreel_formats::tile::{Column, RayKind, ShadowState, composite, step};
use rayreel_machine::NamedMachine;
use rayreel_replay::counts::RayCounts;
use rayreel_replay::{NamedPolicy, Options, replay};

/// Frame, tile, sample, in the order of the tables.
fn tiles(trace: &Trace) -> Vec<(u32, u32)> {
    let tiles = trace.meta().tile_count();
    trace.meta().frame_numbers().flat_map(|frame| (0..tiles).map(move |tile| (frame, tile))).collect()
}

#[test]
fn rays_are_those_of_the_trace() {
    for trace in traces() {
        let rows = Rows::of(&Data::new(&trace, What::Rays));
        let [frame, tile, x, y, index, ray, parent, class, depth, light, triangle] =
            ["frame", "tile", "x", "y", "index", "ray", "parent", "class", "depth", "light", "triangle"]
                .map(|name| rows.integers(name));
        let (kind, outcome, t, t_max) =
            (rows.words("kind"), rows.words("outcome"), rows.floats("t"), rows.floats("t_max"));
        let [ox, oy, oz, dx, dy, dz] =
            ["origin_x", "origin_y", "origin_z", "direction_x", "direction_y", "direction_z"]
                .map(|name| rows.floats(name));
        let mut row = 0;
        for (of_frame, of_tile) in tiles(&trace) {
            let rect = trace.meta().tile_rect(of_tile);
            // Per sample the number of each class's ray: a ray's parent is that of half its class.
            let (mut numbers, mut sample, mut number) = (BTreeMap::new(), u32::MAX, 0);
            for recorded in trace.rays(of_frame, of_tile).unwrap() {
                if recorded.sample != sample {
                    (sample, number) = (recorded.sample, 0);
                    numbers.clear();
                }
                let shadow = matches!(recorded.end, RayEnd::Light { .. });
                let from = match (shadow, recorded.class.parent()) {
                    (true, _) => numbers[&recorded.class],
                    (false, Some(parent)) => numbers[&parent],
                    (false, None) => -1,
                };
                if !shadow {
                    numbers.insert(recorded.class, number);
                }
                let place = (rect.x + sample % rect.width, rect.y + sample / rect.width);
                assert_eq!((frame[row], tile[row]), (of_frame.into(), of_tile.into()));
                assert_eq!((x[row], y[row]), (place.0.into(), place.1.into()));
                assert_eq!((index[row], ray[row], parent[row]), (recorded.index.into(), number, from));
                assert_eq!((class[row], depth[row]), (recorded.class.0.into(), recorded.class.depth().into()));
                assert_eq!(kind[row], recorded.kind().name());
                let is = recorded.ray;
                assert_eq!([ox[row], oy[row], oz[row]], is.origin.to_array());
                assert_eq!([dx[row], dy[row], dz[row]], is.direction.to_array());
                assert_eq!(t_max[row], if is.t_max < f32::MAX { is.t_max } else { f32::INFINITY });
                let (word, lit, met) = match recorded.end {
                    RayEnd::Sky => ("miss", -1, -1),
                    RayEnd::Hit(hit) => ("hit", -1, i64::from(hit.triangle)),
                    RayEnd::Light { light, state: ShadowState::Lit } => ("lit", light as i64, -1),
                    RayEnd::Light { light, state: ShadowState::Blocked } => ("blocked", light as i64, -1),
                    RayEnd::Light { light, .. } => ("tinted", light as i64, -1),
                };
                assert_eq!((outcome[row], light[row], triangle[row]), (word, lit, met));
                match recorded.end {
                    RayEnd::Sky => assert_eq!(t[row], f32::INFINITY),
                    RayEnd::Hit(hit) => {
                        assert_eq!(t[row], hit.t);
                        let met = intersect(&is, trace.bvh().corners(hit.triangle as usize), f32::INFINITY);
                        assert_eq!(met.map(|met| met.t), Some(t[row]), "the row's ray meets the row's triangle");
                    }
                    RayEnd::Light { .. } => assert!(t[row].is_nan()),
                }
                (row, number) = (row + 1, number + 1);
            }
        }
        assert_eq!(row, rows.len());
    }
}

#[test]
fn hits_are_those_of_the_rays_with_their_colours() {
    for trace in traces() {
        let (rays, hits) = (Rows::of(&Data::new(&trace, What::Rays)), Rows::of(&Data::new(&trace, What::Hits)));
        let of_rays: Vec<usize> = (0..rays.len()).filter(|&row| rays.words("outcome")[row] == "hit").take(3).collect();
        assert_eq!(of_rays.len(), 3);
        let met: Vec<bool> = rays.words("outcome").iter().map(|word| *word == "hit").collect();
        for name in ["frame", "tile", "x", "y", "index", "ray", "class", "depth", "triangle"] {
            let all = rays.integers(name);
            let expected: Vec<i64> = (0..rays.len()).filter(|&row| met[row]).map(|row| all[row]).collect();
            assert_eq!(hits.integers(name), expected, "{name}");
        }
        let at: Vec<usize> = (0..rays.len()).filter(|&row| met[row]).collect();
        for axis in ["x", "y", "z"] {
            let [origin, direction] = ["origin", "direction"].map(|name| rays.floats(&format!("{name}_{axis}")));
            let position = hits.floats(&format!("position_{axis}"));
            assert!((0..at.len()).all(|i| position[i] == origin[at[i]] + direction[at[i]] * rays.floats("t")[at[i]]));
        }
        let [nx, ny, nz] = ["normal_x", "normal_y", "normal_z"].map(|name| hits.floats(name));
        assert!((0..hits.len()).all(|i| (nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i] - 1.0).abs() < 1.0e-5));
        let (mut row, bvh) = (0, trace.bvh());
        let (shadows, objects, materials) =
            (hits.integers("shadows"), hits.integers("object"), hits.integers("material"));
        for (frame, index) in tiles(&trace) {
            let tile = trace.tile(frame, index, &Column::ALL).unwrap();
            for (node, (hit, colours)) in tile.tree.nodes.iter().zip(tile.hits.iter().zip(&tile.radiance)) {
                if node.hit {
                    let triangle = bvh.triangles[hit.triangle as usize];
                    assert_eq!(shadows[row], i64::from(node.shadows.0));
                    assert_eq!((objects[row], materials[row]), (triangle.object.into(), triangle.material.into()));
                    for (name, half) in
                        [("local", colours.local), ("reflect", colours.reflect), ("refract", colours.refract)]
                    {
                        let found = ["r", "g", "b"].map(|channel| hits.floats(&format!("{name}_{channel}"))[row]);
                        assert_eq!(found, half.to_vec3().to_array());
                    }
                    row += 1;
                }
            }
        }
        assert_eq!(row, hits.len());
    }
}

/// Walks the tree anew from the rows alone: each says where the next one must be.
#[test]
fn steps_lead_through_the_tree() {
    for trace in traces() {
        let data =
            Data { selection: Selection::all(trace.meta()).tiles("1").unwrap(), ..Data::new(&trace, What::Steps) };
        let rows = Rows::of(&data);
        let [tile, index, number, step_number] = ["tile", "index", "number", "step"].map(|name| rows.integers(name));
        let (at, outcome, bvh) = (rows.words("at"), rows.words("outcome"), trace.bvh());
        let mut row = 0;
        for (frame, of_tile) in tiles(&trace).into_iter().filter(|(_, tile)| *tile == 1) {
            let recorded = trace.tile(frame, of_tile, &[Column::Paths]).unwrap();
            for ray in 0..recorded.paths.spans.len() {
                let mut stack = Vec::new();
                let mut next = Some(rayreel_formats::bvh::Child::ROOT);
                let mut tests = Vec::new();
                for (i, &code) in recorded.paths.ray(ray).iter().enumerate() {
                    assert_eq!((tile[row], index[row], step_number[row]), (of_tile.into(), ray as i64, i as i64));
                    if let Some(leaf) = next.filter(|child| child.is_leaf()) {
                        tests = leaf.triangles().collect();
                        next = None;
                    }
                    let words = [
                        "none",
                        "left",
                        "right",
                        "left_first",
                        "right_first",
                        "visited",
                        "culled",
                        "miss",
                        "hit",
                        "pass",
                    ];
                    assert_eq!(outcome[row], words[usize::from(code)]);
                    if !tests.is_empty() {
                        assert_eq!((at[row], number[row]), ("triangle", tests.remove(0) as i64));
                    } else if let Some(node) = next.take() {
                        assert_eq!((at[row], number[row]), ("node", node.node() as i64));
                        let [left, right] = bvh.nodes[node.node()].children;
                        let (near, far) = match code {
                            step::NONE => (None, None),
                            step::LEFT => (Some(left), None),
                            step::RIGHT => (Some(right), None),
                            step::LEFT_FIRST => (Some(left), Some(right)),
                            _ => (Some(right), Some(left)),
                        };
                        stack.extend(far.map(|far| (far, node.node())));
                        next = near;
                    } else {
                        let (child, node) = stack.pop().unwrap();
                        assert_eq!((at[row], number[row]), ("stack", node as i64));
                        next = (code == step::POP).then_some(child);
                    }
                    row += 1;
                }
            }
        }
        assert_eq!(row, rows.len());
        assert!(row > 1000);
    }
}

#[test]
fn samples_add_up_the_other_tables() {
    for trace in traces() {
        let all = |what| Rows::of(&Data::new(&trace, what));
        let (samples, rays, steps) = (all(What::Samples), all(What::Rays), all(What::Steps));
        let key = |rows: &Rows| -> Vec<[i64; 4]> {
            let [frame, tile, x, y] = ["frame", "tile", "x", "y"].map(|name| rows.integers(name));
            (0..rows.len()).map(|i| [frame[i], tile[i], x[i], y[i]]).collect()
        };
        // Rays, shadow rays, node visits, triangle tests, pops.
        let mut sums: BTreeMap<[i64; 4], [i64; 5]> = BTreeMap::new();
        for (key, kind) in key(&rays).into_iter().zip(rays.words("kind")) {
            let sum = sums.entry(key).or_default();
            sum[0] += 1;
            sum[1] += i64::from(kind == RayKind::Shadow.name());
        }
        for (key, at) in key(&steps).into_iter().zip(steps.words("at")) {
            let place = ["node", "triangle", "stack"].iter().position(|word| *word == at).unwrap();
            sums.get_mut(&key).unwrap()[2 + place] += 1;
        }
        let found = ["rays", "shadow_rays", "node_visits", "triangle_tests", "pops"].map(|name| samples.integers(name));
        let keys = key(&samples);
        assert_eq!(keys.len(), sums.len());
        for (i, key) in keys.iter().enumerate() {
            assert_eq!(found.each_ref().map(|column| column[i]), sums[key], "sample {key:?}");
        }
        assert_eq!(samples.count("state", "recorded"), samples.len() as u64);
        let mut row = 0;
        for (frame, index) in tiles(&trace) {
            let tile = trace.tile(frame, index, &[Column::Hits, Column::Radiance]).unwrap();
            for sample in 0..tile.tree.samples() {
                let nodes = tile.tree.sample(sample);
                let colour = composite(&tile.tree.nodes[nodes.clone()], &tile.radiance[nodes]);
                assert_eq!(["r", "g", "b"].map(|name| samples.floats(name)[row]), colour.to_array());
                row += 1;
            }
        }
    }
}

/// With one R-sample in a block of 8x8 and refinement by halves, a sample that is traced stands in the middle of a gap: its place says in
/// which round that was, of the X step on R-rows and of the Y step elsewhere.
#[test]
fn rounds_and_blocks_are_those_of_the_places() {
    let policy = NamedPolicy::load("adaptive-8", &[]).unwrap();
    for trace in traces() {
        let samples = Rows::of(&Data { policy: Some(&policy), ..Data::new(&trace, What::Samples) });
        let [x, y, round, block] = ["x", "y", "round", "block"].map(|name| samples.integers(name));
        let (width, height) = (trace.meta().width * trace.meta().samples, trace.meta().height * trace.meta().samples);
        // Halvings until a middle falls on a place; the last gap is one short, so it has other middles.
        let level = |place: i64| 3 - i64::from(place.trailing_zeros());
        let (last_x, last_y) = (i64::from(width) - 1, i64::from(height) - 1);
        let is_reference = |place: i64, last: i64| place % 8 == 0 || place == last;
        let mut traced = [0; 7];
        for (i, state) in samples.words("state").into_iter().enumerate() {
            assert_eq!(block[i], 8);
            let (on_column, on_row) = (is_reference(x[i], last_x), is_reference(y[i], last_y));
            assert_eq!((state == "reference", round[i] == 0), (on_column && on_row, on_column && on_row));
            if on_column && on_row || x[i] > last_x - 8 || y[i] > last_y - 8 {
                continue;
            }
            let latest = if on_row { level(x[i]) } else { 3 + level(y[i]) };
            match state {
                "traced" => assert_eq!(round[i], latest, "({}, {})", x[i], y[i]),
                // A gap whose ends are alike is filled at once.
                _ => assert!((if on_row { 1 } else { 4 }..=latest).contains(&round[i]), "({}, {})", x[i], y[i]),
            }
            traced[round[i] as usize] += u32::from(state == "traced");
        }
        assert!(traced[1..].iter().all(|&samples| samples > 0), "each round traces some: {traced:?}");
    }
}

/// What is traced of a sample follows from its state, but for partial ones and where lights are known; all sums are those of the replay.
#[test]
fn traced_rays_are_those_of_the_replay() {
    for (trace, name) in
        traces().iter().flat_map(|trace| ["full", "adaptive-8", "multirate", "temporal"].map(|name| (trace, name)))
    {
        let policy = NamedPolicy::load(name, &[]).unwrap();
        let samples = Rows::of(&Data { policy: Some(&policy), ..Data::new(trace, What::Samples) });
        let [all, shadow, traced, shadow_traced] =
            ["rays", "shadow_rays", "rays_traced", "shadow_rays_traced"].map(|name| samples.integers(name));
        for (i, state) in samples.words("state").into_iter().enumerate() {
            let (rays, of) = ((traced[i], shadow_traced[i]), (all[i], shadow[i]));
            let fits = match state {
                "interpolated" => rays == (0, 0),
                "reference" | "traced" if name != "temporal" => rays == of,
                _ => rays.0 > 0 && rays.0 <= of.0 && rays.1 <= of.1,
            };
            assert!(fits, "{name}: {rays:?} of {of:?} of a {state} sample");
        }
        let replayed = replay(trace, &policy.policy, trace.meta().frame_numbers(), Options::default()).unwrap();
        let counts: RayCounts = replayed.frames.iter().map(|frame| frame.stats.counts.rays_traced).sum();
        let sum = |values: &[i64]| values.iter().sum::<i64>() as u64;
        assert_eq!((sum(&traced), sum(&shadow_traced)), (counts.total(), counts.shadow), "{name}");
    }
}

#[test]
fn geometry_is_that_of_the_tree() {
    for trace in traces() {
        let bvh = trace.bvh();
        let (nodes, triangles) =
            (Rows::of(&Data::new(&trace, What::Nodes)), Rows::of(&Data::new(&trace, What::Triangles)));
        assert_eq!((nodes.len(), triangles.len()), (bvh.nodes.len(), bvh.triangles.len()));
        let (parent, depth) = (nodes.integers("parent"), nodes.integers("depth"));
        for (side, name) in ["left", "right"].into_iter().enumerate() {
            let (kind, number) = (nodes.words(&format!("{name}_kind")), nodes.integers(name));
            let count = nodes.integers(&format!("{name}_triangles"));
            for (i, node) in bvh.nodes.iter().enumerate() {
                let child = node.children[side];
                let expected = if child.is_leaf() { ("leaf", child.first()) } else { ("inner", child.node()) };
                assert_eq!((kind[i], number[i] as usize), expected);
                assert_eq!(count[i] as usize, if child.is_leaf() { child.count() } else { 0 });
                if !child.is_leaf() {
                    assert_eq!((parent[child.node()], depth[child.node()]), (i as i64, depth[i] + 1));
                }
                let corner = |end: &str| ["x", "y", "z"].map(|axis| nodes.floats(&format!("{name}_{end}_{axis}"))[i]);
                assert_eq!(corner("min"), node.bounds[side].min.to_array());
                assert_eq!(corner("max"), node.bounds[side].max.to_array());
            }
        }
        assert_eq!((parent[0], depth[0]), (-1, 0));
        for (i, triangle) in bvh.triangles.iter().enumerate() {
            let corner = |name: &str| ["x", "y", "z"].map(|axis| triangles.floats(&format!("{name}_{axis}"))[i]);
            assert_eq!(["a", "b", "c"].map(corner), bvh.corners(i).map(|corner| corner.to_array()));
            assert_eq!(triangles.words("object_name")[i], bvh.objects[triangle.object as usize]);
            assert_eq!(triangles.words("material_name")[i], bvh.material(i).name);
            if i > 200 {
                break; // words are looked up anew for each
            }
        }
    }
}

/// Whichever columns are looked at hold what they hold beside all others; what is left out holds that too, or 0 where nobody decoded it.
#[test]
fn columns_that_are_left_out_change_no_other() {
    let all_of = |rows: &Rows, column| format!("{:?}", rows.column(column));
    let is_zero = |rows: &Rows, column| match rows.column(column) {
        Values::F32(values) => values.iter().all(|value| *value == 0.0),
        Values::U32(values) => values.iter().all(|value| *value == 0),
        _ => false,
    };
    for trace in traces() {
        for (what, dear) in
            [(What::Hits, &["local_g", "refract_b"][..]), (What::Samples, &["g", "pops", "node_visits"])]
        {
            let all = Rows::of(&Data::new(&trace, what));
            let names: Vec<_> = what.table().columns.iter().map(|column| column.name).collect();
            let alone = names.iter().map(|name| vec![*name]);
            for asked in alone.chain([vec![dear[0], "x"], vec!["y", dear[1], dear[0]]]) {
                let columns = Some(asked.iter().map(|name| (*name).to_string()).collect());
                let data = Data { columns, ..Data::new(&trace, what) };
                assert!(data.head().unwrap().columns().map(|(column, _)| column.name).eq(asked.iter().copied()));
                let found = Rows::of(&data);
                for &name in &names {
                    let (same, looked_at) = (all_of(&found, name) == all_of(&all, name), asked.contains(&name));
                    assert!(same || !looked_at && is_zero(&found, name), "{name} beside {asked:?}");
                }
                if asked == ["x"] {
                    assert!(
                        dear.iter().all(|name| is_zero(&found, name) && !is_zero(&all, name)),
                        "nothing is decoded"
                    );
                }
            }
        }
        let error = |columns: &[&str]| {
            let columns = Some(columns.iter().map(|name| (*name).to_string()).collect());
            Data { columns, ..Data::new(&trace, What::Hits) }.collect().unwrap_err().to_string()
        };
        assert!(error(&["colour"]).starts_with("table hits has no column \"colour\""));
        assert!(error(&[]).starts_with("no column is asked for"));
    }
}

#[test]
fn batches_have_rows_and_not_too_many() {
    let (trace, machine) = (trace("teapot"), NamedMachine::load("sgrt-ti2", &[]).unwrap());
    let sizes = |data: &Data<'_>| {
        let mut sizes = Vec::new();
        let mut take = |batch: Batch, _| {
            sizes.push(batch.rows());
            Ok(())
        };
        data.run(Use { make: &Ok, take: &mut take }).unwrap();
        sizes
    };
    let mut split = Vec::new();
    for what in What::ALL {
        let data = Data { machine: what.takes_machine().then_some(&machine), ..Data::new(&trace, what) };
        let sizes = sizes(&data);
        assert!(sizes.iter().all(|rows| (1..=ROWS).contains(rows)), "{}: {sizes:?}", what.name());
        assert_eq!(sizes.iter().sum::<usize>(), data.collect().unwrap().rows(), "{}", what.name());
        if sizes.len() > trace.meta().tile_count() as usize * 2 {
            split.push(what.name());
        }
    }
    assert_eq!(split, ["steps", "addresses", "lookups"], "tiles of these have more rows than a batch");
    let mut none = Data::new(&trace, What::Rays);
    none.selection.tiles.clear();
    assert_eq!(sizes(&none), [0], "what has no rows is still a table");
}
