//! What holds for every format: good files give the same model, as the libraries read it too.

mod bad;

use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;

use super::*;

/// A pyramid over a square: five vertices, a quad and four triangles, six when cut.
const CORNERS: [[f32; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [2.0, 0.0, 2.0],
    [0.0, 0.0, 2.0],
    [1.0, 1.5, 1.0],
];
const FACES: [&[u32]; 5] = [
    &[0, 1, 2, 3],
    &[1, 0, 4],
    &[2, 1, 4],
    &[3, 2, 4],
    &[0, 3, 4],
];
const TRIANGLES: [[u32; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 3],
    [1, 0, 4],
    [2, 1, 4],
    [3, 2, 4],
    [0, 3, 4],
];
const COLOURS: [[u8; 3]; 5] = [
    [255, 0, 0],
    [0, 255, 0],
    [0, 0, 255],
    [255, 255, 255],
    [51, 102, 153],
];

fn ply_header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a pyramid\nelement vertex 5\nproperty float x\n\
         property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nelement face 5\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ply_ascii() -> Vec<u8> {
    let mut text = ply_header("ascii");
    for ([x, y, z], [r, g, b]) in CORNERS.iter().zip(COLOURS) {
        writeln!(text, "{x} {y} {z} {r} {g} {b}").unwrap();
    }
    for face in FACES {
        write!(text, "{}", face.len()).unwrap();
        for index in face {
            write!(text, " {index}").unwrap();
        }
        text.push('\n');
    }
    text.into_bytes()
}

fn ply_binary(little: bool) -> Vec<u8> {
    let format = if little {
        "binary_little_endian"
    } else {
        "binary_big_endian"
    };
    let order = |mut bytes: [u8; 4]| {
        if !little {
            bytes.reverse();
        }
        bytes
    };
    let mut bytes = ply_header(format).into_bytes();
    for (corner, colour) in CORNERS.iter().zip(COLOURS) {
        bytes.extend(corner.iter().flat_map(|x| order(x.to_le_bytes())));
        bytes.extend(colour);
    }
    for face in FACES {
        bytes.push(face.len() as u8);
        bytes.extend(face.iter().flat_map(|i| order(i.to_le_bytes())));
    }
    bytes
}

fn obj() -> Vec<u8> {
    let mut text = "# a pyramid\no pyramid\n".to_owned();
    for ([x, y, z], c) in CORNERS.iter().zip(COLOURS) {
        let [r, g, b] = c.map(|c| f64::from(c) / 255.0);
        writeln!(text, "v {x} {y} {z} {r} {g} {b}").unwrap();
    }
    for face in FACES {
        text.push('f');
        for index in face {
            write!(text, " {}", index + 1).unwrap();
        }
        text.push('\n');
    }
    text.into_bytes()
}

fn stl_binary(header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((TRIANGLES.len() as u32).to_le_bytes());
    for triangle in TRIANGLES {
        bytes.extend([0; 12]);
        for index in triangle {
            bytes.extend(CORNERS[index as usize].iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn stl_ascii() -> Vec<u8> {
    let mut text = "solid pyramid\n".to_owned();
    for triangle in TRIANGLES {
        text.push_str(" facet normal 0 0 0\n  outer loop\n");
        for index in triangle {
            let [x, y, z] = CORNERS[index as usize];
            writeln!(text, "   vertex {x} {y} {z}").unwrap();
        }
        text.push_str("  endloop\n endfacet\n");
    }
    text.push_str("endsolid pyramid\n");
    text.into_bytes()
}

/// Positions, then colours as RGBA bytes, then indices as u16.
fn gltf_buffer() -> Vec<u8> {
    let mut buffer: Vec<u8> = CORNERS
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    buffer.extend(COLOURS.iter().flat_map(|&[r, g, b]| [r, g, b, 255]));
    buffer.extend(
        TRIANGLES
            .iter()
            .flatten()
            .flat_map(|&i| (i as u16).to_le_bytes()),
    );
    buffer
}

fn gltf_json(node: &str, buffer_uri: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"COLOR_0":1}},"indices":2}}]}}],
        "accessors":[
        {{"bufferView":0,"componentType":5126,"count":5,"type":"VEC3","min":[0,0,0],"max":[2,1.5,2]}},
        {{"bufferView":1,"componentType":5121,"normalized":true,"count":5,"type":"VEC4"}},
        {{"bufferView":2,"componentType":5123,"count":18,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":60}},
        {{"buffer":0,"byteOffset":60,"byteLength":20}},{{"buffer":0,"byteOffset":80,"byteLength":36}}],
        "buffers":[{{{buffer_uri}"byteLength":116}}]}}"#
    )
}

fn glb_of(json: &str) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let buffer = gltf_buffer();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((28 + json.len() + buffer.len()) as u32).to_le_bytes());
    for (data, kind) in [(&json, b"JSON"), (&buffer, b"BIN\0")] {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
    }
    bytes
}

fn glb() -> Vec<u8> {
    glb_of(&gltf_json("", ""))
}

fn gzipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// One good file of each kind.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("ascii.ply", ply_ascii()),
        ("little.ply", ply_binary(true)),
        ("big.ply", ply_binary(false)),
        ("a.obj", obj()),
        ("binary.stl", stl_binary(b"made by hand")),
        ("ascii.stl", stl_ascii()),
        ("a.glb", glb()),
        ("packed.ply.gz", gzipped(&ply_binary(true))),
    ]
}

fn plain(name: &str, bytes: impl Into<Vec<u8>>) -> Outcome<Loaded> {
    read(name, bytes.into(), &LoadOptions::default())
}

/// The message of a file that must be refused, which names the file and has a cure.
fn refused(name: &str, bytes: impl Into<Vec<u8>>) -> String {
    let failure = plain(name, bytes).expect_err("this file is bad");
    assert_eq!(failure.exit, crate::failure::Exit::Input);
    assert!(failure.message.contains(name), "{failure}");
    assert!(failure.help.is_some(), "{failure}");
    failure.to_string()
}

fn ply(vertices: &str, faces: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\n\
         end_header\n{vertices}{faces}",
        vertices.lines().count(),
        faces.lines().count()
    )
}

const THREE: &str = "0 0 0\n1 0 0\n0 1 0\n";

#[test]
fn every_format_gives_the_same_triangles_in_space() {
    let first = plain("ascii.ply", ply_ascii()).unwrap();
    assert_eq!(first.mesh.triangles, TRIANGLES);
    assert_eq!(first.mesh.positions[4], DVec3::new(0.0, 0.375, 0.0));
    let corners = |mesh: &Mesh| -> Vec<[DVec3; 3]> {
        let at = |i: u32| mesh.positions[i as usize];
        mesh.triangles.iter().map(|t| t.map(at)).collect()
    };
    for (name, bytes) in samples() {
        let loaded = plain(name, bytes).unwrap();
        assert_eq!(corners(&loaded.mesh), corners(&first.mesh), "{name}");
        assert_eq!(loaded.mesh.positions.len(), 5, "{name}");
        assert!(loaded.warnings.is_empty(), "{name}: {:?}", loaded.warnings);
        assert_eq!(loaded.source.triangles, 6, "{name}");
        for normal in &loaded.mesh.normals {
            assert!((normal.length() - 1.0).abs() < 1e-12, "{name}");
        }
    }
}

#[test]
fn colours_are_read_and_can_be_ignored() {
    for name in ["ascii.ply", "little.ply", "a.obj"] {
        let (_, bytes) = samples().into_iter().find(|(n, _)| *n == name).unwrap();
        assert_eq!(
            plain(name, bytes.clone()).unwrap().mesh.colours,
            COLOURS,
            "{name}"
        );
        let white = LoadOptions {
            white: true,
            ..LoadOptions::default()
        };
        assert!(read(name, bytes, &white).unwrap().mesh.colours.is_empty());
    }
    // glTF holds linear colours: 51, 102, 153 of 255 are displayed as these.
    let colours = plain("a.glb", glb()).unwrap().mesh.colours;
    assert_eq!(colours[..4], COLOURS[..4]);
    assert_eq!(colours[4], [124, 170, 203]);
}

#[test]
fn colours_as_numbers_from_0_to_1_are_read_too() {
    let text = ply(THREE, "3 0 1 2\n")
        .replace(
            "property float z\n",
            "property float z\nproperty float red\nproperty float green\nproperty float blue\n",
        )
        .replace(THREE, "0 0 0 1 0 0\n1 0 0 0 0.5 0\n0 1 0 0 0 2\n");
    let colours = plain("a.ply", text).unwrap().mesh.colours;
    assert_eq!(colours, [[255, 0, 0], [0, 128, 0], [0, 0, 255]]);
}

#[test]
fn a_gzipped_file_on_disk_is_read_by_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pyramid.stl");
    std::fs::write(&path, gzipped(&ply_ascii())).unwrap();
    let loaded = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(loaded.source.format, Format::Ply);
    assert!(loaded.warnings[0].contains("named as STL but holds PLY"));
}

#[test]
fn the_nodes_of_a_gltf_are_moved_and_a_mirror_keeps_the_outside() {
    let node = r#","scale":[-1,1,1],"translation":[5,0,0],"rotation":[0,0.70710678,0,0.70710678]"#;
    let turned = plain("a.glb", glb_of(&gltf_json(node, ""))).unwrap().mesh;
    let still = plain("a.glb", glb()).unwrap().mesh;
    // Mirrored in x, then turned by 90 degrees about y: (x, y, z) comes to (z, y, x).
    for (t, s) in turned.positions.iter().zip(&still.positions) {
        assert!((*t - DVec3::new(s.z, s.y, s.x)).length() < 1e-6, "{t} {s}");
    }
    for (t, s) in turned.normals.iter().zip(&still.normals) {
        assert!((*t - DVec3::new(s.z, s.y, s.x)).length() < 1e-6, "{t} {s}");
    }
}

#[test]
fn a_gltf_finds_its_buffer_beside_it_or_within() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pyramid.gltf");
    std::fs::write(&path, gltf_json("", r#""uri":"the%20buffer.bin","#)).unwrap();
    let failure = load(&path, &LoadOptions::default()).unwrap_err();
    assert!(failure.message.contains("the buffer.bin"), "{failure}");
    std::fs::write(folder.path().join("the buffer.bin"), gltf_buffer()).unwrap();
    let loaded = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(loaded.mesh.triangles, TRIANGLES);
    let bad = gltf_json("", r#""uri":"%ff%fe","#);
    assert!(refused("a.gltf", bad).contains("buffer 0"));
}

#[test]
fn a_binary_stl_may_begin_with_solid() {
    let loaded = plain("cad.stl", stl_binary(b"solid made by a CAD program")).unwrap();
    assert_eq!(loaded.mesh.triangles.len(), 6);
}

#[test]
fn an_ascii_stl_may_hold_several_solids_in_capitals() {
    let mut text = stl_ascii().to_ascii_uppercase();
    text.extend(
        String::from_utf8(stl_ascii())
            .unwrap()
            .replace("vertex ", "vertex 1")
            .into_bytes(),
    );
    assert_eq!(plain("two.stl", text).unwrap().source.triangles, 12);
}

fn check(mesh: &Mesh) {
    assert!(!mesh.triangles.is_empty());
    assert!(
        mesh.positions
            .iter()
            .all(|p| p.abs().max_element() <= 0.5 + 1e-12)
    );
    assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-9));
    assert_eq!(mesh.normals.len(), mesh.positions.len());
    assert!(mesh.colours.is_empty() || mesh.colours.len() == mesh.positions.len());
    let indices = mesh.triangles.iter().flatten();
    assert!(
        indices
            .clone()
            .all(|&i| (i as usize) < mesh.positions.len())
    );
}

#[test]
fn the_payload_of_a_ply_reads_as_the_library_reads_it() {
    use ply_rs_bw::ply::{DefaultElement, Property};
    let number = |element: &DefaultElement, key: &str| match &element[key] {
        Property::Float(x) => f64::from(*x),
        other => panic!("{other:?}"),
    };
    for bytes in [ply_ascii(), ply_binary(true), ply_binary(false)] {
        let parser = ply_rs_bw::parser::Parser::<DefaultElement>::new();
        let twin = parser.read_ply(&mut bytes.as_slice()).unwrap();
        let input = Input::from_bytes("twin.ply", bytes, 1 << 20).unwrap();
        let soup = ply::read(&input).unwrap();
        for (ours, theirs) in soup.positions.iter().zip(&twin.payload["vertex"]) {
            assert_eq!(
                ours.to_array(),
                ["x", "y", "z"].map(|key| number(theirs, key))
            );
        }
        let mut faces = polygon::Faces::default();
        for face in &twin.payload["face"] {
            for index in face["vertex_indices"].to_u32_list().unwrap() {
                faces.corner(index);
            }
            faces.end().unwrap();
        }
        assert_eq!(faces.cut(&soup.positions).triangles, soup.triangles);
    }
}

#[test]
fn an_obj_reads_as_tobj_reads_it() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 3 2\nvn 0 0 -1\nvn 0 1 0\nvn 1 0 0\n\
                f 1//1 4//1 3//1 2//1\no side\nf -5/1/2 -4//2 -1//2\nusemtl m\nf 2//3 3//3 5//3\n";
    let text = text.replace("/1/2", "//2");
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: true,
        ..tobj::LoadOptions::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
        Err(tobj::LoadError::OpenFileFailed)
    })
    .unwrap();
    let triple =
        |v: &[f32], i: u32| DVec3::from([0, 1, 2].map(|k| f64::from(v[3 * i as usize + k])));
    let theirs: Vec<(DVec3, DVec3)> = models
        .iter()
        .flat_map(|m| {
            m.mesh
                .indices
                .iter()
                .map(|&i| (triple(&m.mesh.positions, i), triple(&m.mesh.normals, i)))
        })
        .collect();
    let input = Input::from_bytes("twin.obj", text.into_bytes(), 1 << 20).unwrap();
    let soup = obj::read(&input).unwrap();
    let ours: Vec<(DVec3, DVec3)> = soup
        .triangles
        .iter()
        .flatten()
        .map(|&i| (soup.positions[i as usize], soup.normals[i as usize]))
        .collect();
    assert_eq!(ours, theirs);
}

#[test]
fn an_stl_reads_as_stl_io_reads_it() {
    for bytes in [stl_binary(b"no word"), stl_ascii()] {
        let twin = stl_io::read_stl(&mut std::io::Cursor::new(&bytes)).unwrap();
        let input = Input::from_bytes("twin.stl", bytes, 1 << 20).unwrap();
        let soup = stl::read(&input).unwrap();
        let theirs: Vec<DVec3> = twin
            .faces
            .iter()
            .flat_map(|f| f.vertices)
            .map(|i| DVec3::from(twin.vertices[i].0.map(f64::from)))
            .collect();
        let ours: Vec<DVec3> = soup
            .triangles
            .iter()
            .flatten()
            .map(|&i| soup.positions[i as usize])
            .collect();
        assert_eq!(ours, theirs);
    }
}

#[test]
fn an_ascii_ply_may_have_short_numbers_and_empty_lines() {
    let text = ply(THREE, "3 0 1 2\n").replace("1 0 0\n", "1. .0 -.0\n\n");
    assert_eq!(plain("a.ply", text).unwrap().mesh.positions.len(), 3);
}

#[test]
fn a_long_line_of_an_obj_may_be_continued() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 \\\n1 0\nf 1 2 \\\n3\n";
    assert_eq!(plain("a.obj", text).unwrap().mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn the_scans_have_the_counts_that_their_list_gives() {
    for (name, vertices, triangles) in [
        ("bunny", 35_947, 69_451),
        ("buddha_100k", 49_990, 100_000),
        ("cow", 2_903, 5_804),
        ("dragon", 437_645, 871_414),
        ("teapot", 3_644, 6_320),
        ("tree_oak", 871_051, 538_512),
    ] {
        let started = Instant::now();
        let loaded = load(&scan(name).unwrap(), &LoadOptions::default()).unwrap();
        println!(
            "{name}: {:.3} s {:?}",
            started.elapsed().as_secs_f64(),
            loaded.warnings
        );
        assert_eq!(
            (loaded.source.vertices, loaded.source.triangles),
            (vertices, triangles),
            "{name}"
        );
        check(&loaded.mesh);
    }
}
