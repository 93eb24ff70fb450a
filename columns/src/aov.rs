//! Pictures of what a frame holds beside its colours (arbitrary output variables): for compositing programs, and to train on.

use rayreel_formats::trace::Trace;
use rayreel_replay::image::Image;
use rayreel_replay::image::layers::{Channel, Values};
use rayreel_replay::policy::view::SampleState;
use rayreel_replay::{NamedPolicy, Options, Replayer, Stop};

use crate::data::{Data, Use};
use crate::error::Result;
use crate::schema::Batch;
use crate::value::Column;
use crate::what::What;

/// What stands for no object and no material.
pub const NONE: u32 = u32::MAX;

/// The channels of a frame, one value a pixel. Distances, places, normals, objects, materials and shadows are those of the primary hit
/// of the pixel's first sample, its upper left one; counts are sums over the pixel's samples; colours are means.
///
/// # Errors
/// A frame that is not in the trace, a damaged trace, a policy that does not suit it, an interruption.
pub fn channels(trace: &Trace, policy: &NamedPolicy, frame: u32, stop: &Stop) -> Result<Vec<Channel>> {
    let mut planes = Planes::new(trace);
    let data = |what, columns: Vec<&str>| -> Result<Data<'_>> {
        let data = Data::new(trace, what);
        let columns = Some(columns.into_iter().map(str::to_string).collect());
        Ok(Data { selection: data.selection.clone().frames(frame..frame + 1)?, columns, stop: stop.clone(), ..data })
    };
    let named = |channels: &[(&str, &'static str)]| channels.iter().map(|(_, column)| *column).collect::<Vec<_>>();
    data(What::Hits, [vec!["x", "y", "ray", "shadows"], named(&OF_HITS), named(&OF_THINGS)].concat())?.run(Use {
        make: &Ok,
        take: &mut |batch, _| {
            planes.hits(&batch);
            Ok(())
        },
    })?;
    data(What::Samples, [vec!["x", "y"], named(&OF_SAMPLES)].concat())?.run(Use {
        make: &Ok,
        take: &mut |batch, _| {
            planes.samples(&batch);
            Ok(())
        },
    })?;
    let options = Options { traced: true, ..Options::default() };
    let replayed = Replayer::new(trace, &policy.policy, options)?.with_stop(stop.clone()).frame(frame)?;
    let mut all = Vec::new();
    let mut colours = |layer: &str, image: &Image| {
        for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
            let values = image.pixels.iter().map(|pixel| pixel[i]).collect();
            all.push(Channel { name: format!("{layer}{name}"), values: Values::Floats(values) });
        }
    };
    replayed.reference.iter().for_each(|image| colours("", image));
    colours("policy.", &replayed.image);
    if let Some(flip) = replayed.flip {
        all.push(Channel { name: "flip.value".into(), values: Values::Floats(flip.values) });
    }
    let (states, n) = (&replayed.states, planes.samples);
    let is_traced = |x, y| f32::from(u8::from(states.state(x, y) != SampleState::Interpolated));
    let share = planes.pixels(|samples| samples.map(|(x, y)| is_traced(x, y)).sum::<f32>() / (n * n) as f32);
    all.push(Channel { name: "policy.traced".into(), values: Values::Floats(share) });
    if let Some(traced) = &replayed.traced {
        let rays = planes.pixels(|samples| samples.map(|(x, y)| traced.at(x, y).all).sum());
        let shadow = planes.pixels(|samples| samples.map(|(x, y)| traced.at(x, y).shadow).sum());
        all.push(Channel { name: "policy.rays".into(), values: Values::Whole(rays) });
        all.push(Channel { name: "policy.shadow_rays".into(), values: Values::Whole(shadow) });
    }
    all.extend(planes.channels);
    Ok(all)
}

/// Where the pixels' values are gathered.
struct Planes {
    width: u32,
    height: u32,
    samples: u32,
    lights: u32,
    channels: Vec<Channel>,
}

/// Channels of primary hits, with their columns: a value of nothing stands where the sky is.
const OF_HITS: [(&str, &str); 7] = [
    ("depth.Z", "t"),
    ("position.X", "position_x"),
    ("position.Y", "position_y"),
    ("position.Z", "position_z"),
    ("normal.X", "normal_x"),
    ("normal.Y", "normal_y"),
    ("normal.Z", "normal_z"),
];

/// Channels of numbers of things.
const OF_THINGS: [(&str, &str); 2] = [("object.id", "object"), ("material.id", "material")];

/// Channels of counts.
const OF_SAMPLES: [(&str, &str); 5] = [
    ("rays.all", "rays"),
    ("rays.shadow", "shadow_rays"),
    ("work.node_visits", "node_visits"),
    ("work.triangle_tests", "triangle_tests"),
    ("work.pops", "pops"),
];

impl Planes {
    fn new(trace: &Trace) -> Self {
        let meta = trace.meta();
        let pixels = meta.width as usize * meta.height as usize;
        let floats = |name: &str, value| Channel { name: name.into(), values: Values::Floats(vec![value; pixels]) };
        let whole = |name: &str, value| Channel { name: name.into(), values: Values::Whole(vec![value; pixels]) };
        // A ray that meets nothing goes on for ever; it has no place and no normal.
        let of_hits = OF_HITS.map(|(name, _)| floats(name, if name == "depth.Z" { f32::INFINITY } else { 0.0 }));
        let lights = meta.lights.len() as u32;
        let channels = of_hits
            .into_iter()
            .chain(OF_THINGS.map(|(name, _)| whole(name, NONE)))
            .chain(OF_SAMPLES.map(|(name, _)| whole(name, 0)))
            .chain((0..lights).map(|light| whole(&format!("shadow.light{light}"), 0)))
            .collect();
        Self { width: meta.width, height: meta.height, samples: meta.samples, lights, channels }
    }

    /// A value for each pixel, made of column and row of its samples.
    fn pixels<T>(&self, value: impl Fn(&mut dyn Iterator<Item = (u32, u32)>) -> T) -> Vec<T> {
        let n = self.samples;
        let pixels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x * n, y * n)));
        pixels.map(|(x, y)| value(&mut (0..n * n).map(|s| (x + s % n, y + s / n)))).collect()
    }

    /// Takes the primary hits of the pixels' first samples.
    fn hits(&mut self, batch: &Batch) {
        let (x, y, ray) =
            (whole(What::Hits, batch, "x"), whole(What::Hits, batch, "y"), whole(What::Hits, batch, "ray"));
        let n = self.samples;
        let first = |row: &usize| ray[*row] == 0 && x[*row] % n == 0 && y[*row] % n == 0;
        let width = self.width as usize;
        let pixel = |row: usize| (y[row] / n) as usize * width + (x[row] / n) as usize;
        let rows: Vec<usize> = (0..batch.rows()).filter(first).collect();
        for (place, (_, column)) in OF_HITS.into_iter().enumerate() {
            if let (Values::Floats(to), Some(Column::F32(from))) =
                (&mut self.channels[place].values, find(What::Hits, batch, column))
            {
                rows.iter().for_each(|&row| to[pixel(row)] = from[row]);
            }
        }
        for (place, (_, column)) in (OF_HITS.len()..).zip(OF_THINGS) {
            if let Values::Whole(to) = &mut self.channels[place].values {
                let from = whole(What::Hits, batch, column);
                rows.iter().for_each(|&row| to[pixel(row)] = from[row]);
            }
        }
        let shadows = whole(What::Hits, batch, "shadows");
        for light in 0..self.lights {
            let place = OF_HITS.len() + OF_THINGS.len() + OF_SAMPLES.len() + light as usize;
            if let Values::Whole(to) = &mut self.channels[place].values {
                rows.iter().for_each(|&row| to[pixel(row)] = shadows[row] >> (2 * light) & 3);
            }
        }
    }

    /// Adds what the samples of pixels cost.
    fn samples(&mut self, batch: &Batch) {
        let (x, y) = (whole(What::Samples, batch, "x"), whole(What::Samples, batch, "y"));
        let (n, width) = (self.samples, self.width as usize);
        let pixel = |row: usize| (y[row] / n) as usize * width + (x[row] / n) as usize;
        for (place, (_, column)) in (OF_HITS.len() + OF_THINGS.len()..).zip(OF_SAMPLES) {
            if let Values::Whole(to) = &mut self.channels[place].values {
                let from = whole(What::Samples, batch, column);
                (0..batch.rows()).for_each(|row| to[pixel(row)] += from[row]);
            }
        }
    }
}

fn find<'a>(what: What, batch: &'a Batch, name: &str) -> Option<&'a Column> {
    let place = what.table().columns.iter().position(|column| column.name == name)?;
    batch.columns.get(place)
}

/// A column of numbers that are declared as `u32`.
fn whole<'a>(what: What, batch: &'a Batch, name: &str) -> &'a [u32] {
    match find(what, batch, name) {
        Some(Column::U32(values)) => values,
        _ => &[],
    }
}
