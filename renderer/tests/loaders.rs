//! Scene files: small ones made here, broken ones, and real ones if they are there.

mod common;

use common::{data, data_files};
use glam::{DVec3, Vec2, Vec3};
use layered_bsdf::prelude::Tree;
use renderer::camera::FieldOfView;
use renderer::loaders::{LoadError, LoadedScene, load_scene};
use renderer::progress::Silent;
use renderer::render::render;
use renderer::scene::{Environment, Scene};
use renderer::settings::RenderSettings;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn write(folder: &str, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("loaders").join(folder);
    fs::create_dir_all(&folder).expect("a folder for test files");
    let path = folder.join(name);
    fs::write(&path, content).expect("a file");
    path
}

fn load(folder: &str, name: &str, content: impl AsRef<[u8]>) -> Result<LoadedScene, LoadError> {
    load_scene(&write(folder, name, content))
}

/// The message of an error, which names the file.
fn failure(folder: &str, name: &str, content: impl AsRef<[u8]>) -> String {
    let text = String::from_utf8_lossy(content.as_ref()).into_owned();
    let error = load(folder, name, content).map(|scene| scene.notes).expect_err(&text);
    assert!(error.to_string().contains(name), "{error}");
    error.cause
}

fn renders(scene: &LoadedScene) {
    let ready = Scene::new(scene.description.clone()).expect("a valid scene");
    let settings = RenderSettings { width: 8, height: 8, spp: 1, threads: 1, ..RenderSettings::default() };
    let image = render(&ready, &scene.build_materials(), &settings, &Silent).expect("a valid job");
    assert_eq!(image.counters.faults, 0);
}

const OBJ: &str = "
mtllib a.mtl
mtllib missing.mtl
o lamp
usemtl lamp
v 0 2 0
v 0 2 1
v 1 2 1
f 1 2 3
o quad
usemtl shiny
v 0 0 0
v 1 0 0
v 1 0 -1
v 0 0 -1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 1 0
f -4/1/1 -3/2/1 -2/3/1 -1/4/1
usemtl nowhere
f 4 5 6
l 1 2
";

const MTL: &str = "
newmtl lamp
Kd 0 0 0
Ke 2 3 4
newmtl shiny
Kd 0.1 0.2 0.3
Ks 0.5 0.5 0.5
Ns 98
d 0.5
map_Kd wood.png
newmtl unused
Kd 1 1 1
";

#[test]
fn obj_has_meshes_materials_and_notes() {
    write("obj", "a.mtl", MTL);
    let scene = load("obj", "a.obj", OBJ).expect("a good file");
    assert_eq!(scene.description.materials, ["lamp", "shiny", "nowhere"]);
    let names: Vec<&str> = scene.description.meshes.iter().map(|m| &m.name[..]).collect();
    assert_eq!(names, ["lamp", "quad", "quad"]);
    let quad = &scene.description.meshes[1];
    assert_eq!(quad.triangles.len(), 2);
    assert_eq!(quad.normals, [Vec3::Y; 4]);
    assert_eq!(quad.uvs[0][2], Vec2::ONE);
    let exitance = scene.materials[0].emission.as_ref().expect("a light").1;
    assert!((exitance[1] - 3.0 * std::f32::consts::PI).abs() < 1e-5);
    let Tree::Layer { weight, layer, .. } = &scene.materials[1].scattering else { panic!("no layer") };
    let Tree::GgxSmith { roughness_u, .. } = **layer else { panic!("not glossy") };
    assert_eq!((weight[0], scene.materials[1].cutout_opacity), (0.5, 0.5));
    assert!((roughness_u - 0.02f32.sqrt()).abs() < 1e-6);
    assert!(matches!(scene.description.environment, Environment::None));
    for part in ["missing.mtl", "`nowhere`", "textures of material `shiny`"] {
        assert!(scene.notes.iter().any(|n| n.contains(part)), "{part}: {:?}", scene.notes);
    }
    renders(&scene);
}

#[test]
fn obj_without_materials_is_framed_in_a_studio() {
    let scene = load("obj", "bare.obj", "v 10 0 0\nv 12 0 0\nv 10 2 0\nf 1 2 3").expect("a good file");
    assert_eq!(scene.description.materials, ["default"]);
    assert!(matches!(scene.description.environment, Environment::Map { .. }));
    assert_eq!(scene.description.camera.target, DVec3::new(11.0, 1.0, 0.0));
    let distance = (scene.description.camera.position - scene.description.camera.target).length();
    assert!((distance - 1.02 * 2f64.sqrt() / 15f64.to_radians().sin()).abs() < 1e-6);
    renders(&scene);
}

#[test]
fn obj_libraries_elsewhere_are_not_read() {
    write("", "secret.mtl", "newmtl red\nKd 1 0 0");
    let text = "mtllib ../secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3";
    let scene = load("obj", "outside.obj", text).expect("a good file");
    assert!(scene.notes.iter().any(|n| n.contains("secret.mtl") && n.contains("folder")));
    let Tree::DiffuseReflection { tint, .. } = scene.materials[0].scattering else { panic!("not grey") };
    assert_eq!(tint, [0.6; 3]);
}

#[test]
fn obj_that_is_broken_is_an_error_with_place_and_cause() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, part) in [
        ("", "empty"),
        ("# nothing\n", "no triangle"),
        (vertices, "no triangle"),
        ("v 0 0\nv 1 1 1\n", "line 1"),
        ("v 0 0 0\nv 0 zero 0\nv 1 1 1\n", "line 2"),
        (&format!("{vertices}f 1 2 4"), "out of bounds"),
        (&format!("{vertices}f 1 2 99999999999999999999"), "face parse"),
        (&format!("{vertices}f -9 2 3"), "out of bounds"),
        (&format!("{vertices}vt 0 0\nf 1/1 2/8 3/1"), "out of bounds"),
        ("o spoon\nv 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3", "vertex 1 of mesh `spoon`"),
        ("v 0 0 0\nv 1e39 0 0\nv 0 1 0\nf 1 2 3", "not finite"),
    ] {
        let cause = failure("broken", "a.obj", text);
        assert!(cause.contains(part), "{text:?}: {cause}");
    }
    // Broken libraries are notes.
    write("broken", "a.mtl", "newmtl a\nKd 1\n");
    let text = format!("mtllib a.mtl\n{vertices}usemtl a\nf 1 2 3");
    let scene = load("broken", "b.obj", text).expect("geometry is good");
    assert!(scene.notes.iter().any(|n| n.contains("a.mtl")), "{:?}", scene.notes);
}

#[test]
fn unknown_and_missing_files_are_errors() {
    assert!(failure("other", "a.stl", "solid").contains("kind"));
    let missing = load_scene(Path::new("/nowhere/at/all.obj")).expect_err("missing").to_string();
    assert!(missing.contains("/nowhere/at/all.obj") && missing.contains("No such file"), "{missing}");
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |c: &[u8]| {
        let word = c.iter().enumerate().fold(0u32, |w, (i, &b)| w | u32::from(b) << (16 - 8 * i));
        let digit = move |i: usize| match i <= c.len() {
            true => char::from(DIGITS[(word >> (18 - 6 * i) & 63) as usize]),
            false => '=',
        };
        (0..4).map(digit).collect::<String>()
    };
    bytes.chunks(3).map(group).collect()
}

/// A quad of 4 positions, 4 texture coordinates and 6 indices; positions from the caller.
fn quad_buffer(positions: [[f32; 3]; 4], indices: [u16; 6]) -> Vec<u8> {
    let uvs = [[0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.25]];
    let floats = positions.iter().flatten().chain(uvs.iter().flatten());
    floats.flat_map(|f| f.to_le_bytes()).chain(indices.iter().flat_map(|i| i.to_le_bytes())).collect()
}

const QUAD: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const ORDER: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// A file with the quad; `nodes` and `more` are JSON.
fn gltf(uri: &str, nodes: &str, more: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{nodes}],
        "meshes": [{{"name": "quad", "primitives": [
            {{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}},
            {{"attributes": {{"POSITION": 0}}, "material": 1, "mode": 5}}]}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0,0,0], "max": [1,1,0]}},
            {{"bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC2"}},
            {{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 80}}, {{"buffer": 0, "byteOffset": 80, "byteLength": 12}}],
        "buffers": [{{"byteLength": 92, "uri": "{uri}"}}],
        "materials": [
            {{"name": "paint", "pbrMetallicRoughness": {{"baseColorFactor": [0.1, 0.2, 0.3, 1],
                "metallicFactor": 0, "roughnessFactor": 0.5}}}},
            {{"name": "paint", "emissiveFactor": [1, 0.5, 0],
                "extensions": {{"KHR_materials_emissive_strength": {{"emissiveStrength": 4}}}}}}]
        {more}}}"#
    )
}

fn data_of(positions: [[f32; 3]; 4], order: [u16; 6]) -> String {
    format!("data:application/octet-stream;base64,{}", base64(&quad_buffer(positions, order)))
}

const NODES: &str = r#"{"children": [1, 2], "translation": [0, 0, 5], "scale": [2, 2, 2]},
    {"name": "left", "mesh": 0}, {"name": "right", "mesh": 0, "translation": [3, 0, 0], "children": [3]},
    {"camera": 0, "translation": [0, 0, 10], "rotation": [0, 1, 0, 0]}"#;
const CAMERA: &str = r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]"#;

#[test]
fn gltf_has_shared_meshes_in_a_hierarchy() {
    let scene = load("gltf", "a.gltf", gltf(&data_of(QUAD, ORDER), NODES, CAMERA)).expect("a good file");
    let description = &scene.description;
    assert_eq!((description.meshes.len(), description.instances.len()), (2, 4));
    assert_eq!(description.materials, ["paint", "paint 2"]);
    assert_eq!(description.meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(description.meshes[1].triangles, [[0, 1, 2], [1, 3, 2]]);
    // Upwards is v.
    assert_eq!(description.meshes[0].uvs[0][3], Vec2::new(0.0, 0.75));
    let right = description.instances.iter().find(|i| i.name == "right").expect("a node");
    assert_eq!(right.transform.transform_point3(DVec3::ONE), DVec3::new(8.0, 2.0, 7.0));
    assert_eq!(description.instances[0].mesh, right.mesh);
    let camera = description.camera;
    assert_eq!(camera.position, DVec3::new(6.0, 0.0, 25.0));
    assert!((camera.target - camera.position - DVec3::Z).length() < 1e-12);
    assert_eq!(camera.fov, FieldOfView::Vertical(0.5f32.to_degrees()));
    let exitance = scene.materials[1].emission.as_ref().expect("a light").1;
    assert!((exitance[1] - 2.0 * std::f32::consts::PI).abs() < 1e-5);
    renders(&scene);
}

#[test]
fn gltf_reads_binary_files_and_files_beside_it() {
    write("gltf", "quad data.bin", quad_buffer(QUAD, ORDER));
    let beside = load("gltf", "b.gltf", gltf("quad%20data.bin", NODES, CAMERA)).expect("a good file");
    let mut json = gltf("x", NODES, CAMERA).replace(r#", "uri": "x""#, "").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let buffer = quad_buffer(QUAD, ORDER);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((12 + 8 + json.len() as u32 + 8 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &buffer)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    let binary = load("gltf", "c.glb", &glb).expect("a good file");
    for (a, b) in beside.description.meshes.iter().zip(&binary.description.meshes) {
        assert_eq!((&a.positions, &a.triangles, &a.uvs), (&b.positions, &b.triangles, &b.uvs));
    }
    // No cut or damage may do more than fail.
    for at in (0..glb.len()).step_by(7) {
        assert!(load("gltf", "cut.glb", &glb[..at]).is_err(), "{at}");
        for flip in [1, 0x20, 0xff] {
            let mut damaged = glb.clone();
            damaged[at] ^= flip;
            let _ = load("gltf", "damaged.glb", &damaged).map(|scene| Scene::new(scene.description).is_ok());
        }
    }
}

#[test]
fn gltf_that_is_broken_is_an_error_with_place_and_cause() {
    let good = data_of(QUAD, ORDER);
    let mut nan = QUAD;
    nan[2][1] = f32::NAN;
    let chain: Vec<String> = (0..1500).map(|i| format!(r#"{{"children": [{}]}}"#, i + 1)).collect();
    let deep = format!("{}, {{\"mesh\": 0}}", chain.join(", "));
    let one = r#"{"mesh": 0}"#;
    let cases: Vec<(String, &str)> = vec![
        ("{".to_string(), "EOF"),
        (gltf(&good, one, "").replace("\"2.0\"", "2"), "invalid type"),
        (gltf(&data_of(nan, ORDER), one, ""), "vertex 2 of mesh `quad/0`"),
        (gltf(&data_of(QUAD, [0, 1, 2, 0, 2, 4]), one, ""), "mesh `quad/0`: index 5 is 4"),
        (gltf("../up.bin", one, ""), "folder"),
        (gltf("/etc/hostname", one, ""), "folder"),
        (gltf("absent.bin", one, ""), "No such file"),
        (gltf("http://example.org/a.bin", one, ""), "buffer 0"),
        (gltf("data:application/octet-stream;base64,AAAA", one, ""), "3 bytes instead of 92"),
        (gltf("data:application/octet-stream;base64,*", one, ""), "base64"),
        (gltf(&good, r#"{"mesh": 7}"#, ""), "nodes[0].mesh"),
        (gltf(&good, r#"{"children": [0]}"#, ""), "node 0 has two parents"),
        (gltf(&good, r#"{"children": [1]}, {"children": [2]}, {"children": [1], "mesh": 0}"#, ""), "node 1"),
        (gltf(&good, r#"{"children": [1, 1]}, {"mesh": 0}"#, ""), "node 1 has two parents"),
        (gltf(&good, &deep, ""), "nested deeper"),
        (
            gltf(&good, r#"{"mesh": 0, "scale": [1e38, 1e38, 1e38], "translation": [1e39, 0, 0]}"#, ""),
            "finite",
        ),
        (gltf(&good, "{}", ""), "no triangle"),
        (
            gltf(&good, one, "").replace(r#""count": 4, "type": "VEC3""#, r#""count": 400, "type": "VEC3""#),
            "exceeds",
        ),
        (
            gltf(&good, one, "").replace(r#""count": 4, "type": "VEC3""#, r#""count": 0, "type": "VEC3""#),
            "index 0",
        ),
        (gltf(&good, one, "").replace(r#""byteLength": 80"#, r#""byteLength": 8000"#), "exceeds its buffer"),
        (
            gltf(&good, one, "").replace("\"byteOffset\": 48", "\"byteOffset\": 18446744073709551615"),
            "accessor 1",
        ),
        (
            gltf(&good, one, "").replace("\"byteLength\": 80", "\"byteLength\": 80, \"byteStride\": 4"),
            "overlap",
        ),
        (gltf(&good, one, "").replace("VEC3", "VEC2"), "components"),
        (gltf(&good, one, r#", "extensionsRequired": ["KHR_draco_mesh_compression"]"#), "extension"),
    ];
    for (text, part) in cases {
        let cause = failure("broken", "a.gltf", &text);
        assert!(cause.contains(part), "{part}: {cause}");
    }
}

#[test]
fn real_scenes_load_and_render() {
    let folders = ["geometry/cornell", "geometry/materialx", "gltf"];
    for file in folders.iter().flat_map(|f| data_files(f, &["obj", "gltf", "glb"])) {
        let start = Instant::now();
        let scene = load_scene(&file).unwrap_or_else(|e| panic!("{e}"));
        let time = start.elapsed();
        renders(&scene);
        let (meshes, instances) = (scene.description.meshes.len(), scene.description.instances.len());
        let triangles: usize = scene.description.meshes.iter().map(|m| m.triangles.len()).sum();
        let name = file.file_name().expect("a file").to_string_lossy();
        println!("{name}: {meshes} meshes, {instances} instances, {triangles} triangles, {time:.1?}");
        scene.notes.iter().for_each(|note| println!("    {note}"));
    }
    let Some(cornell) = data("geometry/cornell/cornell_box.obj") else { return };
    let scene = load_scene(&cornell).expect("a good file");
    let mut names = scene.description.materials.clone();
    names.sort();
    assert_eq!(names, ["green", "red", "white"]);
}
