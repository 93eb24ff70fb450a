//! How metallic-roughness materials, alpha modes and lights become what the scene has.

use glam::Vec3;
use rayreel_scenes::{Light, Material, Optics, Wrap};
use serde_json::{Value, json};

use crate::{assert_warned, message, warnings, writer::Writer};

fn material(material: Value) -> Material {
    let (_folder, scene) = Writer::triangle(material).load();
    scene.materials[0].clone()
}

fn pbr(metallic: f32, roughness: f32) -> Value {
    let base = [0.8, 0.4, 0.2, 1.0];
    json!({"pbrMetallicRoughness": {"baseColorFactor": base, "metallicFactor": metallic, "roughnessFactor": roughness}})
}

fn close(a: Vec3, b: [f32; 3]) -> bool {
    (a - Vec3::from(b)).abs().max_element() < 1e-5
}

#[test]
fn roughness_decides_whether_rays_are_reflected() {
    for (roughness, optics) in
        [(0.0, Optics::FresnelMirror), (0.39, Optics::FresnelMirror), (0.4, Optics::Opaque), (1.0, Optics::Opaque)]
    {
        for metallic in [0.0, 1.0] {
            assert_eq!(material(pbr(metallic, roughness)).optics, optics, "metallic {metallic}, roughness {roughness}");
        }
    }
    let plastic = material(pbr(0.0, 0.25));
    assert!(close(plastic.diffuse, [0.8, 0.4, 0.2]) && close(plastic.specular, [0.03; 3]), "{plastic:?}");
    let metal = material(pbr(1.0, 0.25));
    assert!(close(metal.specular, [0.6, 0.3, 0.15]) && close(metal.diffuse, [0.2, 0.1, 0.05]), "{metal:?}");
    let rough = material(pbr(1.0, 1.0));
    assert!(close(rough.diffuse, [0.8, 0.4, 0.2]) && rough.specular == Vec3::ZERO && rough.shininess == 1, "{rough:?}");
    // 2 / 0.5^4 - 2.
    assert_eq!(material(pbr(0.0, 0.5)).shininess, 30);
}

#[test]
fn glass_has_the_index_and_the_tint_of_the_file() {
    let mut glass = pbr(0.0, 0.0);
    glass["extensions"] =
        json!({"KHR_materials_transmission": {"transmissionFactor": 0.5}, "KHR_materials_ior": {"ior": 1.33}});
    let glass = material(glass);
    assert_eq!((glass.optics, glass.ior), (Optics::Dielectric, 1.33));
    assert!(close(glass.transmission, [0.4, 0.2, 0.1]) && close(glass.diffuse, [0.4, 0.2, 0.1]), "{glass:?}");
}

/// It glowed: its highlight was as wide as that of a rough surface and as strong as that of glass.
#[test]
fn rough_glass_is_drawn_as_clear_glass() {
    let glass = |roughness: f32| {
        let mut glass = pbr(0.0, roughness);
        glass["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
        material(glass)
    };
    let (clear, rough) = (glass(0.0), glass(1.0));
    assert_eq!((rough.optics, rough.specular, rough.shininess), (Optics::Dielectric, Vec3::ONE, clear.shininess));
    assert_eq!(format!("{rough:?}"), format!("{clear:?}"));
}

#[test]
fn metal_lets_no_light_through() {
    let read = |metallic: f32| {
        let mut mixed = pbr(metallic, 0.0);
        mixed["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
        Writer::triangle(mixed).load()
    };
    let (folder, scene) = read(1.0);
    assert_eq!(scene.materials[0].optics, Optics::FresnelMirror);
    assert_warned(&folder, &scene, 1, "transmission is of what is no metal");
    let (folder, scene) = read(0.75);
    assert_eq!(scene.materials[0].optics, Optics::Dielectric);
    assert!(close(scene.materials[0].transmission, [0.2, 0.1, 0.05]), "{:?}", scene.materials[0]);
    assert_warned(&folder, &scene, 1, "it is taken times 1 - metallic (0.75 here)");
}

#[test]
fn numbers_a_rounding_beyond_their_limits_are_taken() {
    let near =
        json!({"baseColorFactor": [0.5, 0.5, 0.5, 1.000_000_1], "metallicFactor": -1e-7, "roughnessFactor": 1.0005});
    let (folder, scene) = Writer::triangle(json!({"pbrMetallicRoughness": near})).load();
    assert!(warnings(&folder, &scene).is_empty());
    let bright = json!({"baseColorFactor": [1.5, 0.5, 0.5, 1.0], "metallicFactor": 0});
    let (folder, scene) = Writer::triangle(json!({"pbrMetallicRoughness": bright})).load();
    assert!(close(scene.materials[0].diffuse, [1.0, 0.5, 0.5]), "{:?}", scene.materials[0]);
    assert_warned(&folder, &scene, 1, "a base colour above 1 would create light and was lowered to 1");
}

#[test]
fn samplers_say_what_lies_beyond_the_edges() {
    for (sampler, wrap) in [
        (json!({}), [Wrap::Repeat, Wrap::Repeat]),
        (json!({"wrapS": 33071}), [Wrap::Clamp, Wrap::Repeat]),
        (json!({"wrapS": 10497, "wrapT": 33648}), [Wrap::Repeat, Wrap::Mirror]),
    ] {
        let mut writer = pictured([10, 255], &json!({"alphaMode": "MASK"}));
        writer.push("samplers", sampler);
        writer.json["textures"][0]["sampler"] = json!(0);
        let (_folder, scene) = writer.load();
        let [map, mask] = [scene.materials[0].diffuse_map, scene.materials[0].alpha_map].map(Option::unwrap);
        assert_eq!((scene.textures[map].wrap, scene.textures[mask].wrap), (wrap, wrap));
    }
}

/// A triangle with a picture of 2 x 1 texels, whose alpha is given, as base colour.
fn pictured(alphas: [u8; 2], extra: &Value) -> Writer {
    let mut png = Vec::new();
    let picture = image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([200, 100, 50, alphas[x as usize]]));
    picture.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).expect("encodes");
    let mut material = extra.clone();
    material["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    material["name"] = json!("m");
    let mut writer = Writer::triangle(material);
    let view = writer.view(&png);
    writer.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    writer.push("textures", json!({"source": 0}));
    writer
}

/// In base64.
const ONE_PIXEL_PNG: &str =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGM4kWIEAANWAV/oF4RSAAAAAElFTkSuQmCC";

/// A picture that OBJ only warns of was an error here.
#[test]
fn pictures_in_other_formats_have_a_warning() {
    for (image, kind) in [
        (json!({"uri": "b.bmp"}), "bmp"),
        (json!({"uri": "B.TGA"}), "tga"),
        (json!({"uri": "data:image/tiff;base64,SUkqAA==", "mimeType": "image/tiff"}), "tiff"),
        (json!({"uri": "data:image/WebP;base64,AAAA"}), "webp"),
        // What the bytes say, where nothing else does: `RIFF....WEBP`, `BM`.
        (json!({"uri": "data:image/png;base64,UklGRgAAAABXRUJQVlA4IAAAAAA="}), "webp"),
        (json!({"uri": "data:application/octet-stream,BM%00%00"}), "bmp"),
    ] {
        let mut writer = pictured([255; 2], &json!({}));
        writer.json["images"] = json!([image]);
        let (folder, scene) = writer.load();
        assert_warned(&folder, &scene, 1, &format!("pictures in {kind} are not read, and the plain colour is used"));
    }
}

/// A picture of another format under the name of one that is read stopped the load; one that is damaged must.
#[test]
fn the_bytes_of_a_picture_say_its_format() {
    let load = |bytes: &[u8]| {
        let mut writer = pictured([255; 2], &json!({}));
        let view = writer.view(bytes);
        writer.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
        writer.try_load(&rayreel_scenes::LoadOptions::default())
    };
    let (folder, scene) = load(b"RIFF\x10\0\0\0WEBPVP8 ");
    assert_warned(&folder, &scene.expect("loads"), 1, "pictures in webp are not read, and the plain colour is used");
    for damaged in [&b"\x89PNG\r\n\x1a\n"[..], &[0xff, 0xd8, 0xff, 0xe0], b"no picture"] {
        let (folder, scene) = load(damaged);
        let text = message(&folder, &scene.expect_err("is damaged"));
        assert!(text.contains("image 0: the texture `image 0` cannot be decoded"), "{text}");
    }
    // A picture that is in the file itself is what its bytes say, whatever its type.
    let mut writer = pictured([255; 2], &json!({}));
    writer.json["images"] = json!([{"uri": format!("data:image/webp;base64,{ONE_PIXEL_PNG}")}]);
    let (folder, scene) = writer.load();
    assert!(warnings(&folder, &scene).iter().all(|(_, words)| !words.contains("not read")));
    let mut writer = pictured([255; 2], &json!({}));
    writer.json["images"] = json!([{"uri": "a.png"}]);
    let folder = crate::folder();
    std::fs::write(folder.path().join("a.png"), b"BM\0\0\0\0").expect("writes");
    let scene = crate::load_file(&writer.write_glb(folder.path(), "a"), &rayreel_scenes::LoadOptions::default());
    assert_warned(&folder, &scene.expect("loads"), 1, "pictures in bmp are not read");
}

/// What metal reflects and glass lets through was that of the factor alone, and white for most files.
#[test]
fn metal_and_glass_have_the_mean_colour_of_their_picture() {
    let (r, g, b) = (0.577_580, 0.127_438, 0.031_896);
    let read = |pbr: Value, extensions: Value| {
        let writer = pictured([255, 255], &json!({"pbrMetallicRoughness": pbr, "extensions": extensions}));
        let (folder, scene) = writer.load();
        let told = warnings(&folder, &scene).iter().any(|(_, words)| words.contains("the mean of the texture"));
        (scene.materials[0].clone(), told)
    };
    let (metal, told) = read(
        json!({"baseColorFactor": [1.0, 0.5, 1.0, 1.0], "metallicFactor": 1.0, "roughnessFactor": 0.25}),
        json!({}),
    );
    assert!(close(metal.specular / 0.75, [r, g / 2.0, b]) && told, "{metal:?}");
    // The texture is still looked up where it can be.
    assert!(metal.diffuse_map.is_some() && close(metal.diffuse, [0.25, 0.125, 0.25]), "{metal:?}");
    let (glass, told) = read(
        json!({"metallicFactor": 0.0, "roughnessFactor": 0.0}),
        json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}}),
    );
    assert!(close(glass.transmission, [r, g, b]) && told, "{glass:?}");
    let (plastic, told) = read(json!({"metallicFactor": 0.0, "roughnessFactor": 0.0}), json!({}));
    assert!(close(plastic.specular, [0.04; 3]) && !told, "{plastic:?}");
}

#[test]
fn a_cut_out_that_leaves_nothing_is_told() {
    let told = |alphas| {
        let (folder, scene) = pictured(alphas, &json!({"alphaMode": "MASK"})).load();
        warnings(&folder, &scene).iter().any(|(_, words)| words.contains("cuts all away"))
    };
    assert!(told([0, 127]) && !told([0, 128]));
}

#[test]
fn cut_outs_keep_their_cutoff() {
    for (cutoff, alphas, passes) in [
        (0.5, [127, 128], [true, false]),
        (0.1, [25, 26], [true, false]),
        (0.9, [229, 230], [true, false]),
        (1.0, [254, 255], [true, false]),
    ] {
        let writer = pictured(alphas, &json!({"alphaMode": "MASK", "alphaCutoff": cutoff}));
        let (_folder, scene) = writer.load();
        let map = scene.materials[0].alpha_map.expect("is a cut-out");
        // What the tracer asks: alpha below one half.
        let texels = scene.textures[map].texels.iter();
        assert_eq!(texels.map(|t| f32::from(t[3]) / 255.0 < 0.5).collect::<Vec<_>>(), passes, "cutoff {cutoff}");
    }
    let (_folder, scene) = pictured([200, 255], &json!({"alphaMode": "MASK", "alphaCutoff": 0.5})).load();
    assert_eq!(scene.materials[0].alpha_map, None, "nothing is cut away");
    let (_folder, scene) = pictured([0, 255], &json!({"alphaMode": "OPAQUE"})).load();
    assert_eq!(scene.materials[0].alpha_map, None, "OPAQUE ignores alpha");
}

#[test]
fn blending_is_a_cut_out_or_plain_transparency() {
    let (folder, scene) = pictured([10, 255], &json!({"alphaMode": "BLEND"})).load();
    assert!(scene.materials[0].alpha_map.is_some() && scene.materials[0].optics == Optics::Opaque);
    assert_warned(&folder, &scene, 1, "the blended texture is cut out where its alpha is below one half");
    let pane = material(
        json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25], "metallicFactor": 0}}),
    );
    assert_eq!((pane.optics, pane.ior), (Optics::Dielectric, 1.0));
    assert!(close(pane.transmission, [0.75; 3]) && close(pane.diffuse, [0.25; 3]), "{pane:?}");
}

#[test]
fn a_mirror_and_glass_stay_what_they_are_when_blended() {
    let blended = |metallic: f32, more: Value| {
        let pbr = json!({"baseColorFactor": [1, 1, 1, 0.5], "metallicFactor": metallic, "roughnessFactor": 0});
        let mut all = json!({"alphaMode": "BLEND", "pbrMetallicRoughness": pbr});
        all.as_object_mut().expect("is an object").extend(more.as_object().expect("is one").clone());
        Writer::triangle(all).load()
    };
    let (folder, scene) = blended(1.0, json!({}));
    assert_eq!((scene.materials[0].optics, scene.materials[0].specular), (Optics::FresnelMirror, Vec3::ONE));
    assert_warned(&folder, &scene, 1, "alpha is not read of a mirror: nothing passes it");
    let (folder, scene) =
        blended(0.0, json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}));
    assert!(close(scene.materials[0].transmission, [1.0; 3]), "{:?}", scene.materials[0]);
    assert_warned(&folder, &scene, 1, "alpha is not read of glass: transmission says what passes");
    // A varnish on a pane: light passes, and what it would reflect is told to be lost.
    let (folder, scene) = blended(0.0, json!({}));
    assert_eq!((scene.materials[0].optics, scene.materials[0].ior), (Optics::Dielectric, 1.0));
    assert_warned(&folder, &scene, 1, "lets light pass straight, and reflects nothing");
}

#[test]
fn a_picture_of_metal_and_roughness_is_its_mean() {
    let mut png = Vec::new();
    let picture = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([0, [51, 102][x as usize], [0, 255][x as usize]]));
    picture.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).expect("encodes");
    let mut writer = Writer::triangle(json!({"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}));
    let view = writer.view(&png);
    writer.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    writer.push("textures", json!({"source": 0}));
    let (folder, scene) = writer.load();
    // Metallic 0.5, roughness 0.3, white: F0 is half of 0.04 + 1, times 0.7.
    assert!(close(scene.materials[0].specular, [0.52 * 0.7; 3]), "{:?}", scene.materials[0]);
    assert!(scene.textures.is_empty(), "the picture is not kept");
    assert_warned(&folder, &scene, 1, "read as their mean (here metallic 0.50, roughness 0.30)");
}

#[test]
fn what_is_ignored_is_told_once_with_a_count() {
    let mut writer = pictured(
        [255, 255],
        &json!({"normalTexture": {"index": 0}, "occlusionTexture": {"index": 0},
        "emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_sheen": {}}}),
    );
    let other = json!({"normalTexture": {"index": 0}});
    let other = writer.push("materials", other);
    let mut primitive = writer.json["meshes"][0]["primitives"][0].clone();
    primitive["material"] = other.into();
    primitive["attributes"]["COLOR_0"] = primitive["attributes"]["POSITION"].clone();
    primitive["targets"] = json!([{"POSITION": primitive["attributes"]["POSITION"]}]);
    let lines = json!({"attributes": primitive["attributes"], "mode": 1});
    writer.json["meshes"][0]["primitives"].as_array_mut().expect("is a list").extend([primitive, lines]);
    writer.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9}}),
    );
    writer.root(json!({"camera": 0, "name": "plan"}));
    writer.push("scenes", json!({"name": "another", "nodes": [0]}));
    let (folder, scene) = writer.load();
    for (count, words) in [
        (2, "material `m`: normal maps are not read"),
        (1, "occlusion maps are not read"),
        (1, "mesh 0, primitive 0: without TEXCOORD_0 its texture has one colour"),
        (1, "textures of emission are not read"),
        (1, "the extension KHR_materials_sheen is not read"),
        (1, "mesh 0, primitive 1: colours of vertices are not read"),
        (1, "mesh 0, primitive 1: morph targets are not read"),
        (1, "mesh 0, primitive 2: points and lines have no surface"),
        (1, "`plan`: only cameras with a perspective are read"),
        (1, "scene 0 of 2 is shown"),
    ] {
        assert_warned(&folder, &scene, count, words);
    }
    assert_eq!(warnings(&folder, &scene).len(), 10);
    assert_eq!(scene.materials[0].emission, Vec3::ZERO);
}

/// A triangle lit by these lights, each at a node with this translation.
fn lit(lights: &[(Value, [f32; 3])]) -> Writer {
    let mut writer = Writer::triangle(json!(null));
    writer.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    let list: Vec<&Value> = lights.iter().map(|(light, _)| light).collect();
    writer.json["extensions"] = json!({"KHR_lights_punctual": {"lights": list}});
    for (index, (_, at)) in lights.iter().enumerate() {
        writer.root(json!({"translation": at, "extensions": {"KHR_lights_punctual": {"light": index}}}));
    }
    writer
}

/// A lamp amid the model outshone all others, the more the nearer it was to the middle: it counts as half a radius away.
#[test]
fn a_lamp_amid_the_model_leaves_the_sun_its_light() {
    let ratio = |at: [f32; 3]| {
        let sun = json!({"type": "directional", "intensity": 1, "color": [0, 0, 1]});
        let (_folder, scene) = lit(&[(json!({"type": "point", "intensity": 1}), at), (sun, [0.0; 3])]).load();
        let [Light::Point { colour: lamp, .. }, Light::Directional { colour: sun, .. }] = scene.lights[..] else {
            panic!("{:?}", scene.lights);
        };
        lamp.x / sun.z
    };
    // The radius is half of the box's diagonal, which is the root of 2: half of that squared is 1/8.
    for at in [[0.5, 0.5, 0.0], [0.5, 0.5, 1e-3], [0.5, 0.5, 0.35]] {
        assert!((ratio(at) - 8.0).abs() < 1e-4, "{at:?}: {}", ratio(at));
    }
    assert!((ratio([0.5, 0.5, 2.0]) - 0.25).abs() < 1e-5);
}

#[test]
fn what_a_file_uses_and_nobody_reads_is_told() {
    let mut writer = Writer::triangle(json!(null));
    writer.json["extensionsUsed"] = json!(["KHR_materials_ior", "KHR_animation_pointer", "EXT_lights_image_based"]);
    let (folder, scene) = writer.load();
    assert_warned(&folder, &scene, 1, "the extension KHR_animation_pointer is not read");
    assert_warned(&folder, &scene, 1, "the extension EXT_lights_image_based is not read");
    assert_eq!(warnings(&folder, &scene).len(), 2);
}

#[test]
fn lights_keep_their_places_and_ratios() {
    let point = |intensity: f32| json!({"type": "point", "intensity": intensity, "color": [1, 0.5, 0.25]});
    // The middle of the triangle's box is (0.5, 0.5, 0): the second is twice as far and twice as strong.
    let (_folder, scene) = lit(&[(point(100.0), [0.5, 0.5, 2.0]), (point(200.0), [0.5, 0.5, 4.0])]).load();
    let [Light::Point { position, colour }, Light::Point { colour: other, .. }] = scene.lights[..] else {
        panic!("two points: {:?}", scene.lights);
    };
    assert_eq!(position, Vec3::new(0.5, 0.5, 2.0));
    assert!((colour.x / other.x - 2.0).abs() < 1e-5 && (colour.y / colour.x - 0.5).abs() < 1e-5);
    assert!((colour.x + other.x - 1.13).abs() < 1e-5, "together as strong as the default lights");
    let spot = json!({"type": "spot", "intensity": 5, "spot": {}});
    let (folder, scene) = lit(&[(spot, [0.0, 0.0, 3.0]), (json!({"type": "directional"}), [0.0; 3])]).load();
    assert!(matches!(scene.lights[0], Light::Point { .. }));
    assert!(
        matches!(scene.lights[1], Light::Directional { to_light, .. } if to_light == Vec3::Z),
        "a light shines along -z"
    );
    assert_warned(&folder, &scene, 1, "a spot light shines to all sides here");
}

#[test]
fn too_many_lights_leave_the_strongest_and_none_gives_the_default() {
    let list: Vec<(Value, [f32; 3])> =
        (0..20).map(|i| (json!({"type": "directional", "intensity": 1 + i}), [0.0; 3])).collect();
    let (folder, scene) = lit(&list).load();
    assert_eq!(scene.lights.len(), 16);
    assert_warned(&folder, &scene, 4, "the weakest were left out");
    let (_folder, dark) = lit(&[(json!({"type": "point", "intensity": 0}), [0.0; 3])]).load();
    let (_folder, none) = Writer::triangle(json!(null)).load();
    assert_eq!(dark.lights, none.lights);
    let (folder, scene) =
        lit(&[(json!({"type": "point", "intensity": -1}), [0.0; 3])]).try_load(&rayreel_scenes::LoadOptions::default());
    let text = message(&folder, &scene.expect_err("is negative"));
    assert!(text.contains("node 1: light 0 has a colour or intensity that is negative"), "{text}");
}
