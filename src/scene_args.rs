//! The scene of a command: its name, and flags that replace its camera, lights and sky.

use anyhow::Result;
use rayreel_scenes::{LoadOptions, MAX_FPS, Overrides, Scene};

use crate::common::tell_warnings;

/// Which scene, and what to replace of it.
#[derive(Clone, Debug, clap::Args)]
pub struct SceneArgs {
    /// Built-in scene, scene file (.toml) or model (.obj, .gltf, .glb).
    pub scene: String,
    #[command(flatten)]
    pub changes: SceneChanges,
}

impl SceneArgs {
    /// Loads the scene for `frames` frames from `frame` on and for pictures of a size in pixels, with what the flags replace, and tells its
    /// warnings.
    pub fn load(&self, frames: (u32, u32), size: (u32, u32)) -> Result<Scene> {
        self.changes.load(&self.scene, frames, size)
    }
}

/// What to replace of a scene.
#[derive(Clone, Debug, clap::Args)]
pub struct SceneChanges {
    /// Where the camera stands, in every frame, instead of where the scene says.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    eye: Option<[f32; 3]>,
    /// The point that the camera looks at, in every frame.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    target: Option<[f32; 3]>,
    /// The direction that is up in the picture.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    up: Option<[f32; 3]>,
    /// Vertical field of view in degrees.
    #[arg(long, value_name = "DEG", value_parser = field_of_view)]
    fov: Option<f32>,
    /// A point light instead of the scene's lights, with its colour (0.7,0.7,0.7 if not given); may be repeated.
    #[arg(long, value_name = "X,Y,Z[,R,G,B]", value_parser = light, allow_hyphen_values = true)]
    light: Vec<[f32; 6]>,
    /// The colour of the sky around the scene.
    #[arg(long, value_name = "R,G,B", value_parser = colour)]
    sky: Option<[f32; 3]>,
    /// Frames a second of an animated glTF model; 30 if neither this nor the scene file says it.
    #[arg(long, value_name = "N", value_parser = frames_a_second)]
    fps: Option<f64>,
}

impl SceneChanges {
    /// The same of scene `name`.
    pub fn load(&self, name: &str, (frame, frames): (u32, u32), (width, height): (u32, u32)) -> Result<Scene> {
        let aspect = f64::from(width) / f64::from(height);
        let mut scene = rayreel_scenes::load_with(name, &LoadOptions { fps: self.fps, frame, frames, aspect })?;
        tell_warnings(&scene);
        self.overrides().apply(&mut scene)?;
        Ok(scene)
    }

    /// A flag that was given and is for a scene.
    pub fn first_flag(&self) -> Option<&'static str> {
        let given = [
            ("--eye", self.eye.is_some()),
            ("--target", self.target.is_some()),
            ("--up", self.up.is_some()),
            ("--fov", self.fov.is_some()),
            ("--light", !self.light.is_empty()),
            ("--sky", self.sky.is_some()),
            ("--fps", self.fps.is_some()),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag)
    }

    /// The flags that were given, as words of a command.
    pub fn words(&self) -> Vec<String> {
        let list = |numbers: &[f32]| numbers.iter().map(f32::to_string).collect::<Vec<_>>().join(",");
        let triple = |value: Option<[f32; 3]>| value.map(|value| list(&value));
        let mut given = vec![("--eye", triple(self.eye)), ("--target", triple(self.target)), ("--up", triple(self.up))];
        given.push(("--fov", self.fov.map(|fov| fov.to_string())));
        given.extend(self.light.iter().map(|light| ("--light", Some(list(light)))));
        given.extend([("--sky", triple(self.sky)), ("--fps", self.fps.map(|fps| fps.to_string()))]);
        given.into_iter().filter_map(|(flag, value)| Some([flag.to_owned(), value?])).flatten().collect()
    }

    fn overrides(&self) -> Overrides {
        Overrides {
            eye: self.eye.map(Into::into),
            target: self.target.map(Into::into),
            up: self.up.map(Into::into),
            vfov_deg: self.fov,
            lights: self.light.iter().map(|&[x, y, z, r, g, b]| Overrides::point_light([x, y, z], [r, g, b])).collect(),
            sky: self.sky.map(Into::into),
        }
    }
}

/// Parses numbers between commas, all finite.
fn numbers(text: &str) -> Option<Vec<f32>> {
    let number = |s: &str| s.trim().parse::<f32>().ok().filter(|v| v.is_finite());
    text.split(',').map(number).collect()
}

/// Parses `X,Y,Z`.
fn triple(text: &str) -> Result<[f32; 3], String> {
    let values = numbers(text).and_then(|values| values.try_into().ok());
    values.ok_or_else(|| "give three numbers, such as 1,2.5,-3".to_string())
}

/// Parses `R,G,B`.
fn colour(text: &str) -> Result<[f32; 3], String> {
    let values = triple(text).ok().filter(|values| values.iter().all(|v| *v >= 0.0));
    values.ok_or_else(|| "give three numbers from 0 on: red, green, blue, such as 0.5,0.6,0.75".to_string())
}

/// Parses `X,Y,Z` or `X,Y,Z,R,G,B`.
fn light(text: &str) -> Result<[f32; 6], String> {
    let wrong = || "give a place and, if you like, a colour from 0 on: 1,2.5,-3 or 1,2.5,-3,0.9,0.8,0.7".to_string();
    let all = match numbers(text).ok_or_else(wrong)?[..] {
        [x, y, z] => [x, y, z, 0.7, 0.7, 0.7],
        [x, y, z, r, g, b] => [x, y, z, r, g, b],
        _ => return Err(wrong()),
    };
    if all[3..].iter().all(|v| *v >= 0.0) { Ok(all) } else { Err(wrong()) }
}

/// Parses a field of view.
fn field_of_view(text: &str) -> Result<f32, String> {
    let value = text.parse::<f32>().ok().filter(|v| *v > 0.0 && *v < 180.0);
    value.ok_or_else(|| "give degrees between 0 and 180".to_string())
}

/// Parses frames a second.
fn frames_a_second(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| *v > 0.0 && *v <= MAX_FPS);
    value.ok_or_else(|| format!("give a number above 0, at most {MAX_FPS}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_say_what_was_given() {
        #[derive(clap::Parser)]
        struct Command {
            #[command(flatten)]
            scene: SceneArgs,
        }
        let given = "a --eye -1,2.5,3 --target 0,0,0 --up 0,0,1 --fov 33.3 --light 1,2,3,0.7,0.7,0.7 --light 4,5,6,1,0,0 --sky 0.1,0.2,0.3 --fps 12.5";
        let all: Vec<&str> = given.split(' ').collect();
        let Command { scene } = clap::Parser::parse_from(["x"].into_iter().chain(all.iter().copied()));
        assert_eq!(scene.changes.words(), all[1..]);
        let Command { scene } = clap::Parser::parse_from(["x", "a"]);
        assert!(scene.changes.words().is_empty());
    }

    #[test]
    fn triples_and_lights_are_numbers_between_commas() {
        assert_eq!(triple("1,-2.5, 3e1"), Ok([1.0, -2.5, 30.0]));
        assert_eq!(light("1,2,3"), Ok([1.0, 2.0, 3.0, 0.7, 0.7, 0.7]));
        assert_eq!(light("1,2,3,4,5,6"), Ok([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "1,2,inf", "1;2;3", "1,2,3,4,5,-1"] {
            assert!(light(wrong).is_err() && triple(wrong).is_err(), "{wrong}");
        }
        assert!(colour("1,2,-3").is_err() && colour("0,0,0").is_ok());
        for wrong in ["0", "180", "-5", "nan", "x"] {
            assert!(field_of_view(wrong).is_err(), "{wrong}");
        }
        for wrong in ["0", "-1", "inf", "nan", "1001"] {
            assert!(frames_a_second(wrong).is_err(), "{wrong}");
        }
    }
}
