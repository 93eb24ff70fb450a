//! Odd OBJ files are drawn, and a warning says what is not as the file has it.

mod common;

use common::{TRIANGLE, folder, load_in, warnings};

#[test]
fn what_rounding_takes_from_a_model_far_away_is_told() {
    let far = "v 4000000 0 0\nv 4000400 0 0\nv 4000000 9000 0\nv 4000000.25 0 0\nv 4000000 0.25 0\nf 1 2 3\nf 1 4 5\nf 1 1 1\n";
    let scene = load_in(&folder(&[("a.obj", far)]), "a.obj").expect("loads");
    assert_eq!(scene.mesh.triangles.len(), 1);
    let found = warnings(&scene);
    let told = |text: &str| found.iter().any(|(count, message)| *count == 1 && message.contains(text));
    assert!(told("so small and so far from the origin") && told("triangles without area were dropped"), "{found:#?}");
}

#[test]
fn a_texture_that_cannot_be_drawn_as_it_is_is_told() {
    let picture = |alpha: u8| image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 0, alpha]));
    let load = |faces: &str, mtl: &str| {
        let obj = format!("mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n{faces}");
        let files = folder(&[
            ("a.obj", &obj),
            ("a.mtl", &format!("newmtl m\n{mtl}")),
            ("t.tga", "no picture"),
            ("w.png", "RIFF\x10\0\0\0WEBPVP8 "),
        ]);
        picture(0).save(files.path().join("clear.png")).expect("saves");
        picture(255).save(files.path().join("solid.png")).expect("saves");
        let scene = load_in(&files, "a.obj").expect("loads");
        (warnings(&scene).into_iter().map(|(_, message)| message).collect::<Vec<_>>().join("; "), scene)
    };
    let (bare, mapped) = ("f 1 2 3\n", "f 1/1 2/1 3/1\n");
    assert!(
        load(bare, "map_Kd solid.png\n").0.contains("a.obj:7: material `m`: without `vt` its texture has one colour")
    );
    assert!(load(mapped, "map_Kd clear.png\n").0.contains("name the file as `map_d` too to cut it out"));
    // By its name, and by its bytes.
    for file in ["t.tga", "w.png"] {
        let (told, scene) = load(mapped, &format!("map_Kd {file}\nKd 0.5 0.25 0\n"));
        assert!(told.contains("is no PNG or JPEG, and the material is drawn without it"), "{told}");
        assert_eq!((scene.materials[0].diffuse_map, scene.materials[0].diffuse.to_array()), (None, [0.5, 0.25, 0.0]));
    }
    let told = load(mapped, "map_Kd clear.png\nmap_d clear.png\n").0;
    assert_eq!(told, "a.mtl:1: material `m`: its texture is below the cutoff everywhere, and cuts all away");
    for (faces, mtl) in [(mapped, "map_Kd solid.png\n"), (mapped, "map_Kd solid.png\nmap_d solid.png\n"), (bare, "")] {
        assert_eq!(load(faces, mtl).0, "", "{mtl}");
    }
}

#[test]
fn names_of_materials_end_before_a_comment() {
    let load = |usemtl: &str| {
        let obj = format!("mtllib a.mtl\n{usemtl}\n{TRIANGLE}");
        let files = folder(&[("a.obj", &obj), ("a.mtl", "newmtl red\nKd 1 0 0\nnewmtl red # 2\nKd 0 1 0\n")]);
        let scene = load_in(&files, "a.obj").expect("loads");
        (scene.materials[scene.mesh.triangles[0].material as usize].diffuse.to_array(), warnings(&scene).len())
    };
    assert_eq!(load("usemtl red # the lid"), ([1.0, 0.0, 0.0], 0));
    assert_eq!(load("usemtl red # 2"), ([0.0, 1.0, 0.0], 0), "a name with a hash that is known");
    assert_eq!(load("usemtl").1, 2, "a name is missing, and a material");
}

/// The comment was taken for a part of the name, which no `usemtl` has.
#[test]
fn names_in_libraries_end_before_a_comment() {
    let mtl = "newmtl red # the lid\nKd 1 0 0\nnewmtl blue # 1\nKd 0 0 1\nnewmtl blue\nKd 0 1 0\n";
    let load = |usemtl: &str| {
        let obj = format!("mtllib a.mtl\nusemtl {usemtl}\n{TRIANGLE}");
        let scene = load_in(&folder(&[("a.obj", &obj), ("a.mtl", mtl)]), "a.obj").expect("loads");
        (scene.materials[scene.mesh.triangles[0].material as usize].diffuse.to_array(), warnings(&scene).len())
    };
    for usemtl in ["red", "red # mine", "red # the lid"] {
        assert_eq!(load(usemtl), ([1.0, 0.0, 0.0], 0), "{usemtl}");
    }
    assert_eq!(load("blue"), ([0.0, 1.0, 0.0], 0), "the whole name counts first");
    assert_eq!(load("blue # 1"), ([0.0, 0.0, 1.0], 0));
    // Of several that are told apart behind the sign alone none is meant.
    let obj = format!("mtllib a.mtl\nusemtl wood #3\n{TRIANGLE}");
    let wood = "newmtl wood #1\nKd 1 0 0\nnewmtl wood #2\nKd 0 0 1\n";
    let told = warnings(&load_in(&folder(&[("a.obj", &obj), ("a.mtl", wood)]), "a.obj").expect("loads"));
    assert!(told.iter().any(|(_, told)| told.contains("`wood #1`")), "{told:?}");
}

#[test]
fn lines_may_end_in_a_carriage_return_alone() {
    let old = TRIANGLE.replace('\n', "\r");
    assert_eq!(load_in(&folder(&[("a.obj", &old)]), "a.obj").expect("loads").mesh.triangles.len(), 1);
}
