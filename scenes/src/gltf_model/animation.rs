//! Animated nodes: translation, rotation and scale at a time.

use std::collections::BTreeMap;

use glam::DVec3;
use gltf::json::animation::{Interpolation, Property};
use gltf::json::validation::Checked;

use super::document::Source;
use crate::{error::SceneError, warnings::Warnings};

/// Translation, rotation (x, y, z, w) and scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub translation: DVec3,
    pub rotation: [f64; 4],
    pub scale: DVec3,
}

/// What is animated of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Translation,
    Rotation,
    Scale,
}

/// Values over time. A cubic spline has three for each time: tangent in, value, tangent out.
struct Track {
    times: Vec<f64>,
    values: Vec<[f64; 4]>,
    how: Interpolation,
}

/// All animations of a file, played together from their start.
#[derive(Default)]
pub(crate) struct Animations {
    /// Frames a second.
    fps: f64,
    tracks: BTreeMap<(usize, Part), Track>,
}

impl Animations {
    /// Reads all animations. Where two move the same part of a node, the first counts.
    pub fn read(source: &Source, fps: f64, warnings: &mut Warnings) -> Result<Self, SceneError> {
        let mut all = Self { fps, tracks: BTreeMap::new() };
        for (a, animation) in source.root().animations.iter().enumerate() {
            for (c, channel) in animation.channels.iter().enumerate() {
                let place = format!("animation {a}, channel {c}");
                let node = channel.target.node.value();
                if node >= source.root().nodes.len() {
                    return Err(source.bad(place, format!("there is no node {node}"), "export the model again"));
                }
                let part = match channel.target.path {
                    Checked::Valid(Property::Translation) => Part::Translation,
                    Checked::Valid(Property::Rotation) => Part::Rotation,
                    Checked::Valid(Property::Scale) => Part::Scale,
                    Checked::Valid(Property::MorphTargetWeights) => {
                        let file = source.path.display();
                        warnings.add("weights", || format!("{file}: {place}: animated morph targets are not read"));
                        continue;
                    }
                    Checked::Invalid => {
                        let file = source.path.display();
                        warnings.add("path", || {
                            format!("{file}: {place}: it moves something else than a node's translation, rotation or scale, and is not read")
                        });
                        continue;
                    }
                };
                if all.tracks.contains_key(&(node, part)) {
                    warnings.add("clips", || {
                        let file = source.path.display();
                        format!("{file}: {place}: an earlier animation moves the same node, and the first counts")
                    });
                    continue;
                }
                let sampler = &animation.samplers[channel.sampler.value()];
                let how = if let Checked::Valid(how) = sampler.interpolation { how } else { Interpolation::Linear };
                let times = times(source, &place, sampler.input.value())?;
                let values = values(source, &place, sampler.output.value(), part)?;
                let each = if how == Interpolation::CubicSpline { 3 } else { 1 };
                if values.len() != times.len() * each {
                    let what = format!("{} times have {} values, not {each} each", times.len(), values.len());
                    return Err(source.bad(place, what, "export the model again"));
                }
                all.tracks.insert((node, part), Track { times, values, how });
            }
        }
        Ok(all)
    }

    /// Whether a node itself is animated.
    pub fn moves(&self, node: usize) -> bool {
        [Part::Translation, Part::Rotation, Part::Scale].iter().any(|part| self.tracks.contains_key(&(node, *part)))
    }

    /// When the last animation ends, in seconds.
    pub fn end(&self) -> f64 {
        self.tracks.values().filter_map(|track| track.times.last()).fold(0.0, |end, time| end.max(*time))
    }

    /// A node's pose at a time; what is not animated stays.
    pub fn pose(&self, node: usize, still: Pose, time: f64) -> Pose {
        let at =
            |part: Part| self.tracks.get(&(node, part)).map(|track| track.at(time, self.fps, part == Part::Rotation));
        let triple = |value: [f64; 4]| DVec3::new(value[0], value[1], value[2]);
        Pose {
            translation: at(Part::Translation).map_or(still.translation, triple),
            rotation: at(Part::Rotation).unwrap_or(still.rotation),
            scale: at(Part::Scale).map_or(still.scale, triple),
        }
    }
}

/// The times of keys: rising, from zero on.
fn times(source: &Source, place: &str, accessor: usize) -> Result<Vec<f64>, SceneError> {
    let times: Vec<f64> = source.floats::<1>(accessor)?.into_iter().map(|[t]| f64::from(t)).collect();
    let rising = times.windows(2).all(|pair| pair[0] < pair[1]) && times.first().is_some_and(|first| *first >= 0.0);
    if rising && times.iter().all(|time| time.is_finite()) {
        return Ok(times);
    }
    Err(source.bad(place, "its times do not rise from zero or above", "export the model again"))
}

fn values(source: &Source, place: &str, accessor: usize, part: Part) -> Result<Vec<[f64; 4]>, SceneError> {
    let wide = |[x, y, z]: [f32; 3]| [f64::from(x), f64::from(y), f64::from(z), 0.0];
    let values: Vec<[f64; 4]> = match part {
        Part::Rotation => source.floats::<4>(accessor)?.into_iter().map(|q| q.map(f64::from)).collect(),
        _ => source.floats::<3>(accessor)?.into_iter().map(wide).collect(),
    };
    if values.iter().flatten().all(|value| value.is_finite()) {
        return Ok(values);
    }
    Err(source.bad(place, "a value is not finite", "export the model again"))
}

/// Times are numbers of single precision, some of them written with three digits: one that is that of a frame up to so much of a frame, and so
/// much of itself, is that.
const ROUNDING: (f64, f64) = (0.05, 1.0 / (1 << 21) as f64);

/// A time in frames up to which what is written is that of it or before, rounding allowed for.
pub(crate) fn rounded_up(time: f64) -> f64 {
    time + (ROUNDING.0 + time * ROUNDING.1).min(0.5)
}

impl Track {
    /// The value at a time in an animation of so many frames a second; before the first key and behind the last it stands still.
    fn at(&self, time: f64, fps: f64, rotation: bool) -> [f64; 4] {
        let last = self.times.len() - 1;
        let reached = if self.how == Interpolation::Step { rounded_up(time * fps) / fps } else { time };
        let after = self.times.partition_point(|key| *key <= reached);
        if after == 0 || after > last {
            return self.key(if after == 0 { 0 } else { last });
        }
        let before = after - 1;
        let span = self.times[after] - self.times[before];
        let t = (time - self.times[before]) / span;
        let (a, b) = (self.key(before), self.key(after));
        match self.how {
            Interpolation::Step => a,
            Interpolation::Linear if rotation => slerp(a, b, t),
            Interpolation::Linear => mix(a, b, 1.0 - t, t),
            Interpolation::CubicSpline => {
                let (out, into) = (self.values[3 * before + 2], self.values[3 * after]);
                let (t2, t3) = (t * t, t * t * t);
                let places = mix(a, b, 2.0 * t3 - 3.0 * t2 + 1.0, 3.0 * t2 - 2.0 * t3);
                let slopes = mix(out, into, span * (t3 - 2.0 * t2 + t), span * (t3 - t2));
                mix(places, slopes, 1.0, 1.0)
            }
        }
    }

    fn key(&self, index: usize) -> [f64; 4] {
        if self.how == Interpolation::CubicSpline { self.values[3 * index + 1] } else { self.values[index] }
    }
}

fn mix(a: [f64; 4], b: [f64; 4], of_a: f64, of_b: f64) -> [f64; 4] {
    std::array::from_fn(|i| a[i] * of_a + b[i] * of_b)
}

/// From one rotation to another along the shorter way, with constant speed.
fn slerp(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    let length = |q: [f64; 4]| q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (la, lb) = (length(a), length(b));
    if la == 0.0 || lb == 0.0 {
        return a;
    }
    let (a, b) = (a.map(|x| x / la), b.map(|x| x / lb));
    let cos: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    let (cos, b) = if cos < 0.0 { (-cos, b.map(|x| -x)) } else { (cos, b) };
    // So close together a straight line is as good, and the sine too small to divide by.
    if cos > 0.9999995 {
        return mix(a, b, 1.0 - t, t);
    }
    let angle = libm::acos(cos);
    let sin = libm::sin(angle);
    mix(a, b, libm::sin((1.0 - t) * angle) / sin, libm::sin(t * angle) / sin)
}
