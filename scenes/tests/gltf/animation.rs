//! Sampled frames against closed forms.

use glam::{Quat, Vec3};
use rayreel_scenes::LoadOptions;
use serde_json::json;

use crate::{assert_warned, message, writer::Writer};

/// A still triangle and a camera node that hangs on an arm; `channels` are (node, path, interpolation, times, values).
struct Film {
    writer: Writer,
    samplers: Vec<serde_json::Value>,
    channels: Vec<serde_json::Value>,
}

const ARM: usize = 1;
const CAMERA: usize = 2;

impl Film {
    fn new() -> Self {
        let mut writer = Writer::triangle(json!(null));
        writer.push(
            "cameras",
            json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 2.0}}),
        );
        assert_eq!(writer.root(json!({"name": "arm", "children": [CAMERA]})), ARM);
        writer.push("nodes", json!({"name": "eye", "camera": 0, "translation": [0, 0, 5]}));
        Self { writer, samplers: Vec::new(), channels: Vec::new() }
    }

    fn channel<const N: usize>(&mut self, node: usize, path: &str, how: &str, times: &[f32], values: &[[f32; N]]) {
        let times: Vec<[f32; 1]> = times.iter().map(|t| [*t]).collect();
        let (input, output) = (self.writer.floats(&times), self.writer.floats(values));
        self.samplers.push(json!({"input": input, "output": output, "interpolation": how}));
        self.channels.push(json!({"sampler": self.samplers.len() - 1, "target": {"node": node, "path": path}}));
    }

    fn finish(mut self) -> Writer {
        self.writer.push("animations", json!({"samplers": self.samplers, "channels": self.channels}));
        self.writer
    }
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5 * (1.0 + b.length())
}

#[test]
fn linear_translation_is_a_line() {
    let mut film = Film::new();
    film.channel(ARM, "translation", "LINEAR", &[0.5, 2.0], &[[0.0, 0.0, 0.0], [3.0, 6.0, 0.0]]);
    let (_folder, scene) = film.finish().load();
    assert_eq!(scene.cameras.len(), 61, "frames 0 to 60 at 30 a second");
    for (frame, camera) in scene.cameras.iter().enumerate() {
        let t = ((frame as f32 / 30.0 - 0.5) / 1.5).clamp(0.0, 1.0);
        assert!(close(camera.eye, Vec3::new(3.0 * t, 6.0 * t, 5.0)), "frame {frame}: {}", camera.eye);
        assert!(close((camera.target - camera.eye).normalize(), Vec3::NEG_Z) && close(camera.up, Vec3::Y));
        assert!((camera.vfov_deg - 0.8_f32.to_degrees()).abs() < 1e-4);
    }
}

#[test]
fn linear_rotation_has_constant_speed_and_turns_the_children() {
    let mut film = Film::new();
    // A quarter turn about y; the second key is written the long way round (as -q) and must not be taken so.
    let quarter = (-Quat::from_rotation_y(std::f32::consts::FRAC_PI_2)).to_array();
    film.channel(ARM, "rotation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], quarter]);
    let writer = film.finish();
    let options = LoadOptions { fps: Some(8.0), ..LoadOptions::default() };
    let (_folder, scene) = writer.try_load(&options);
    let scene = scene.expect("loads");
    assert_eq!(scene.cameras.len(), 9);
    for (frame, camera) in scene.cameras.iter().enumerate() {
        let angle = std::f32::consts::FRAC_PI_2 * frame as f32 / 8.0;
        let wanted = Vec3::new(angle.sin(), 0.0, angle.cos());
        assert!(close(camera.eye, wanted * 5.0), "frame {frame}: {} not {}", camera.eye, wanted * 5.0);
        assert!(close((camera.eye - camera.target).normalize(), wanted), "frame {frame} looks along the arm");
    }
}

#[test]
fn steps_hold_and_splines_are_cubic() {
    let mut film = Film::new();
    film.channel(ARM, "translation", "STEP", &[0.0, 0.5, 1.0], &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    // x(t) = t^3 - 2t + 3 between 1 and 3 seconds: x(1) = 2, x'(1) = 1, x(3) = 24, x'(3) = 25.
    let keys = [[9.0, 0.0, 0.0], [2.0, 0.0, 5.0], [1.0, 0.0, 0.0], [25.0, 0.0, 0.0], [24.0, 0.0, 5.0], [9.0, 0.0, 0.0]];
    film.channel(CAMERA, "translation", "CUBICSPLINE", &[1.0, 3.0], &keys);
    let options = LoadOptions { fps: Some(4.0), ..LoadOptions::default() };
    let scene = film.finish().try_load(&options).1.expect("loads");
    assert_eq!(scene.cameras.len(), 13);
    for (frame, camera) in scene.cameras.iter().enumerate() {
        let t = frame as f32 / 4.0;
        let step = [1.0, 2.0, 4.0][((t / 0.5) as usize).min(2)];
        let spline = |t: f32| t * t * t - 2.0 * t + 3.0;
        let wanted = step + spline(t.clamp(1.0, 3.0));
        assert!((camera.eye.x - wanted).abs() < 1e-4 * wanted, "frame {frame}: {} not {wanted}", camera.eye.x);
    }
}

/// Keys at n / 30 s are single precision, and a frame's time is not: two of three frames showed the key before.
#[test]
fn a_step_counts_from_its_frame_on() {
    for (fps, far) in [(24.0, 0.0), (25.0, 50.0), (29.97, 0.0), (30.0, 0.0), (60.0, 600.0)] {
        let mut film = Film::new();
        // As exact as they can be, or in milliseconds as texts have them.
        let digits = if far == 0.0 { 1e3 } else { 1e9 };
        let times: Vec<f32> =
            (0..48).map(|n| ((far + f64::from(n) / fps) * digits).round() / digits).map(|t| t as f32).collect();
        let places: Vec<[f32; 3]> = (0..48).map(|n| [n as f32, 0.0, 0.0]).collect();
        film.channel(ARM, "translation", "STEP", &times, &places);
        let scene = film.finish().try_load(&LoadOptions { fps: Some(fps), ..LoadOptions::default() }).1.expect("loads");
        let first = (far * fps) as usize;
        assert_eq!(scene.cameras.len(), first + 48);
        let x = |frame: usize| scene.cameras[first + frame].eye.x - scene.cameras[0].eye.x;
        assert!((0..48).all(|frame| (x(frame) - frame as f32).abs() < 1e-4), "{fps} frames a second");
    }
}

#[test]
fn scale_moves_what_hangs_below() {
    let mut film = Film::new();
    film.channel(ARM, "scale", "LINEAR", &[0.0, 1.0], &[[1.0, 1.0, 1.0], [3.0, 3.0, 3.0]]);
    let (_folder, scene) = film.finish().load();
    let last = scene.cameras.last().expect("has frames");
    assert!(close(scene.cameras[15].eye, Vec3::new(0.0, 0.0, 10.0)) && close(last.eye, Vec3::new(0.0, 0.0, 15.0)));
}

#[test]
fn a_moving_mesh_stands_as_at_the_first_frame_that_is_asked_for() {
    let mut film = Film::new();
    film.channel(0, "translation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
    let writer = film.finish();
    for (frame, frames) in [(0, 1), (10, 1), (10, 3), (30, 1), (90, 1)] {
        let (folder, scene) = writer.try_load(&LoadOptions { frame, frames, ..LoadOptions::default() });
        let scene = scene.expect("loads");
        assert_eq!(scene.cameras.len(), 31, "the still camera stands for all frames");
        let low = scene.bounds().0.y;
        assert!((low - 0.1 * frame.min(30) as f32).abs() < 1e-5, "frame {frame}: {low}");
        if frames > 1 {
            assert_warned(&folder, &scene, 1, "moving meshes and lights stand as at frame 10; take frames one by one");
        } else {
            assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        }
    }
}

#[test]
fn frames_a_second_stand_in_the_scene_file() {
    let mut film = Film::new();
    film.channel(ARM, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [1.0, 0.0, 0.0]]);
    let folder = crate::folder();
    film.finish().write_glb(folder.path(), "a");
    let write = |text: &str| {
        let path = folder.path().join("s.toml");
        std::fs::write(&path, format!("model = \"a.glb\"\n{text}")).expect("writes");
        path
    };
    let frames = |path: &std::path::Path, fps| {
        crate::load_file(path, &LoadOptions { fps, ..LoadOptions::default() }).map(|scene| scene.cameras.len())
    };
    let file = write("[animation]\nfps = 10\n");
    assert_eq!(frames(&file, None).expect("loads"), 11);
    assert_eq!(frames(&file, Some(5.0)).expect("loads"), 6, "the caller's word counts");
    let still = write("[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n");
    assert_eq!(frames(&still, None).expect("loads"), 31, "it stands there for all frames");
    let error = frames(&write("[animation]\nfps = 0\n"), None).expect_err("no fps");
    assert_eq!(message(&folder, &error), "s.toml: animation.fps is 0; use a value above 0, at most 1000");
}

#[test]
fn animations_that_lie_are_refused() {
    let broken = |change: &dyn Fn(&mut Film)| {
        let mut film = Film::new();
        change(&mut film);
        let (folder, scene) = film.finish().try_load(&LoadOptions::default());
        message(&folder, &scene.expect_err("must not load"))
    };
    let text = broken(&|film| film.channel(ARM, "translation", "LINEAR", &[1.0, 0.5], &[[0.0; 3], [1.0; 3]]));
    assert_eq!(text, "a.glb: animation 0, channel 0: its times do not rise from zero or above; export the model again");
    let text = broken(&|film| film.channel(ARM, "translation", "CUBICSPLINE", &[0.0, 0.5], &[[0.0; 3], [1.0; 3]]));
    assert!(text.contains("2 times have 2 values, not 3 each"), "{text}");
    let text = broken(&|film| film.channel(77, "translation", "LINEAR", &[0.0], &[[0.0; 3]]));
    assert!(text.contains("there is no node 77"), "{text}");
    let text = broken(&|film| film.channel(ARM, "rotation", "LINEAR", &[0.0], &[[0.0; 3]]));
    assert!(text.contains("its elements are Vec3 of F32, and 4 numbers are needed"), "{text}");
    let text = broken(&|film| film.channel(ARM, "scale", "LINEAR", &[0.0, 1e9], &[[1.0; 3], [2.0; 3]]));
    let all = "its animation has 30000000001 frames at 30 frames a second; at most a million are possible";
    assert!(text.contains(all), "{text}");
    let text = broken(&|film| film.channel(ARM, "scale", "LINEAR", &[0.0, 1.0], &[[1.0; 3], [0.0; 3]]));
    assert!(text.contains("node 2 `eye`: the camera's node has a scale of zero"), "{text}");
}

#[test]
fn a_view_that_nobody_gave_stands_still() {
    let mut film = Film::new();
    film.channel(0, "translation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0], [0.0, 30.0, 0.0]]);
    let mut writer = film.finish();
    writer.json["nodes"].as_array_mut().expect("is a list").iter_mut().for_each(|node| {
        node.as_object_mut().expect("is an object").remove("camera");
    });
    let at = |frame| writer.try_load(&LoadOptions { frame, ..LoadOptions::default() }).1.expect("loads");
    let (first, last) = (at(0), at(30));
    assert!(last.bounds().0.y > first.bounds().0.y + 29.0, "the mesh moves");
    assert_eq!((&last.cameras, &last.lights), (&first.cameras, &first.lights));
    // All of it is in view: from the eye no corner is more than half the picture's height away from the middle.
    let camera = last.cameras[0];
    let ahead = (camera.target - camera.eye).normalize();
    for position in first.mesh.positions.iter().chain(&last.mesh.positions) {
        let arm = *position - camera.eye;
        let slope = (arm / arm.dot(ahead) - ahead).length();
        assert!(slope < 1.2 * (camera.vfov_deg / 2.0).to_radians().tan(), "{position} at {slope}");
    }
}

#[test]
fn a_light_that_moves_has_frames() {
    let mut film = Film::new();
    film.channel(ARM, "translation", "LINEAR", &[0.0, 1.0], &[[0.0, 5.0, 0.0], [9.0, 5.0, 0.0]]);
    let mut writer = film.finish();
    for node in writer.json["nodes"].as_array_mut().expect("is a list") {
        if node.as_object_mut().expect("is an object").remove("camera").is_some() {
            node["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        }
    }
    writer.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    writer.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    let place = |frame| {
        let scene = writer.try_load(&LoadOptions { frame, ..LoadOptions::default() }).1.expect("loads");
        assert_eq!(scene.cameras.len(), 31);
        match scene.lights[..] {
            [rayreel_scenes::Light::Point { position, .. }] => position.x,
            _ => panic!("{:?}", scene.lights),
        }
    };
    assert!((place(30) - place(0) - 9.0).abs() < 1e-5, "{} {}", place(0), place(30));
}

/// Things that appear or go have no area before or after.
#[test]
fn a_mesh_may_be_scaled_to_nothing_at_times() {
    let mut film = Film::new();
    film.channel(0, "scale", "LINEAR", &[0.0, 0.5, 1.0], &[[1.0; 3], [0.0; 3], [1.0; 3]]);
    film.writer.json["cameras"] = json!([]);
    film.writer.json["nodes"][CAMERA].as_object_mut().unwrap().remove("camera");
    let writer = film.finish();
    let at = |frame| writer.try_load(&LoadOptions { frame, ..LoadOptions::default() });
    let cameras: Vec<_> = [0, 14, 30].map(|frame| at(frame).1.expect("it is seen then").cameras).into();
    assert!(cameras.iter().all(|other| *other == cameras[0]), "it is filmed from one place");
    let (folder, gone) = at(15);
    let said = message(&folder, &gone.expect_err("nothing is there"));
    assert!(said.contains("the scene is empty at frame 15") && said.contains("take another frame"), "{said}");
}
