//! Bad files of every format: each is refused with a message, none panics.

use super::*;

#[test]
fn required_extensions_are_refused_with_advice() {
    let json = gltf_json("", "").replacen(
        '{',
        r#"{"extensionsRequired":["EXT_meshopt_compression"],"extensionsUsed":["EXT_meshopt_compression"],"#,
        1,
    );
    let message = refused("a.glb", glb_of(&json));
    assert!(message.contains("EXT_meshopt_compression"), "{message}");
    assert!(message.contains("gltfpack -noq"), "{message}");
}

#[test]
fn hostile_counts_and_indices_in_a_gltf_are_refused() {
    let json = gltf_json("", "");
    let with = |from: &str, to: &str| {
        assert!(json.contains(from));
        refused("a.glb", glb_of(&json.replace(from, to)))
    };
    assert!(with("\"count\":5", "\"count\":4000000000").contains("4000000000"));
    let message = with("\"count\":5", "\"count\":18446744073709551615");
    assert!(message.contains("are allowed"), "{message}");
    with("\"POSITION\":0", "\"POSITION\":7");
    with("\"indices\":2", "\"indices\":0");
    with("\"byteOffset\":80", "\"byteOffset\":18446744073709551615");
    with(
        "\"byteOffset\":80,",
        "\"byteOffset\":80,\"byteStride\":255,",
    );
    with(
        "\"nodes\":[{\"mesh\":0",
        "\"nodes\":[{\"children\":[0],\"mesh\":0",
    );
    let mut bytes = glb();
    let last = bytes.len() - 2;
    bytes[last] = 9;
    assert!(refused("a.glb", bytes).contains("face 5): it refers to vertex 9"));
    let mut bytes = glb();
    bytes[8..12].copy_from_slice(&3u32.to_le_bytes());
    assert!(refused("a.glb", bytes).contains("byte 8"));
}

#[test]
fn a_number_that_is_not_finite_is_placed() {
    let message = refused("nan.ply", ply("0 0 0\n1 nan 0\n0 1 0\n", "3 0 1 2\n"));
    assert!(message.contains("line 11 (vertex 1)"), "{message}");
    let mut bytes = ply_binary(true);
    let start = ply_header("binary_little_endian").len() + 2 * 15;
    bytes[start..start + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let message = refused("inf.ply", bytes);
    assert!(
        message.contains(&format!("byte {start} (vertex 2)")),
        "{message}"
    );
    let message = refused("nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n");
    assert!(message.contains("line 2"), "{message}");
    let mut bytes = stl_binary(b"");
    bytes[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = refused("nan.stl", bytes);
    assert!(message.contains("byte 134 (facet 1)"), "{message}");
    let text = String::from_utf8(stl_ascii()).unwrap();
    let message = refused("nan.stl", text.replace("vertex 1 1.5", "vertex nan 1.5"));
    assert!(message.contains("line 16 (facet 2)"), "{message}");
    let mut bytes = glb();
    let start = bytes.len() - 116;
    bytes[start..start + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = refused("nan.glb", bytes);
    assert!(message.contains("accessor 0, vertex 0"), "{message}");
}

#[test]
fn an_index_out_of_range_is_placed() {
    for bad in ["3 0 1 3\n", "3 0 1 -1\n", "3 0 1 99999999999\n"] {
        let message = refused("index.ply", ply(THREE, bad));
        assert!(message.contains("line 13 (face 0)"), "{message}");
        assert!(message.contains("there are 3"), "{message}");
    }
    for bad in [
        "f 1 2 4",
        "f 1 2 0",
        "f 1 2 -4",
        "f 1 2 9223372036854775807",
        "f 1 2 -9223372036854775808",
    ] {
        let message = refused("index.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{bad}\n"));
        assert!(
            message.contains("line 4: face 0 refers to vertex"),
            "{message}"
        );
    }
    let message = refused("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3//1\n");
    assert!(message.contains("normal 1, and there are 0"), "{message}");
}

#[test]
fn a_face_of_two_corners_is_refused_with_its_number() {
    let message = refused("two.ply", ply(THREE, "3 0 1 2\n2 0 1\n"));
    assert!(
        message.contains("line 14 (face 1): it has 2 corners"),
        "{message}"
    );
    let message = refused("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\n");
    assert!(
        message.contains("line 5: face 1 has 2 corners"),
        "{message}"
    );
}

#[test]
fn models_without_vertices_faces_area_or_extent_are_refused() {
    assert!(refused("none.ply", ply("", "")).contains("no vertices"));
    assert!(refused("cloud.ply", ply(THREE, "")).contains("3 different points"));
    assert!(refused("cloud.obj", "v 0 0 0\nv 1 0 0\n").contains("2 different points"));
    assert!(refused("one.ply", ply("1 2 3\n", "")).contains("has 1 point"));
    assert!(refused("same.ply", ply("1 2 3\n1 2 3\n", "")).contains("same point"));
    assert!(refused("nan.ply", ply("0 0 0\n1 nan 0\n0 1 0\n0 0 1\n", "")).contains("line 11"));
    let flat = ply("0 0 0\n1 0 0\n2 0 0\n", "3 0 1 2\n3 0 0 1\n");
    assert!(refused("flat.ply", flat).contains("all 2 triangles have zero area"));
    assert!(refused("same.ply", ply("1 2 3\n1 2 3\n1 2 3\n", "3 0 1 2\n")).contains("same point"));
    let none = plain("x.ply", ply(THREE, "3 0 1 2\n3 0 1 1\n")).unwrap();
    assert!(none.warnings[0].contains("1 triangle of zero area"));
}

#[test]
fn a_billion_claimed_vertices_are_refused_at_once() {
    let started = Instant::now();
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for count in ["1000000000", "18446744073709551615"] {
            let header = ply_header(format).replace("vertex 5", &format!("vertex {count}"));
            let message = refused("many.ply", header + "0 0 0\n1 0 0\n");
            assert!(message.contains("cut short"), "{message}");
        }
    }
    let mut bytes = stl_binary(b"");
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refused("many.stl", bytes).contains("claims 4294967295 facets and holds 6"));
    let mut bytes = ply_binary(true);
    let faces = ply_header("binary_little_endian").len() + 75;
    bytes[faces] = 255;
    assert!(refused("list.ply", bytes).contains("a list of 255 numbers"));
    assert!(started.elapsed().as_secs() < 1);
}

#[test]
fn what_needs_more_memory_than_allowed_is_refused_before_it_is_made() {
    let small = LoadOptions {
        memory_limit: 700,
        ..LoadOptions::default()
    };
    for (name, bytes) in samples() {
        let failure = read(name, bytes, &small).unwrap_err();
        assert!(failure.message.contains("allowed"), "{name}: {failure}");
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_or_gives_a_valid_model() {
    for (name, bytes) in samples() {
        for length in 0..bytes.len() {
            match plain(name, &bytes[..length]) {
                Ok(loaded) => check(&loaded.mesh),
                Err(failure) => assert!(failure.message.contains(name), "{failure}"),
            }
        }
    }
    // Cut in the numbers, it says so.
    for (name, bytes) in [
        ("little.ply", ply_binary(true)),
        ("a.stl", stl_binary(b"")),
        ("a.glb", glb()),
    ] {
        let message = refused(name, &bytes[..bytes.len() - 7]);
        assert!(message.contains("cut short"), "{message}");
    }
}

/// A small generator (SplitMix64), so that a failure repeats.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

#[test]
fn no_damage_to_a_file_panics() {
    const PIECES: [&[u8]; 12] = [
        b"nan",
        b"-1",
        b"1e999",
        b"99999999999999999999",
        b"element face 4000000000\n",
        b"\n",
        b"property list double double vertex_indices\n",
        b"\xff\xff\xff\xff",
        b"\0",
        b" ",
        b"/",
        b"[",
    ];
    let limits = LoadOptions {
        memory_limit: 1 << 22,
        ..LoadOptions::default()
    };
    let mut random = Random(1);
    for (name, good) in samples() {
        for _ in 0..3000 {
            let mut bytes = good.clone();
            for _ in 0..=random.below(4) {
                let at = random.below(bytes.len().max(1)).min(bytes.len());
                match random.below(5) {
                    0 => bytes.truncate(at.max(1)),
                    1 => {
                        if let Some(byte) = bytes.get_mut(at) {
                            *byte = random.next() as u8;
                        }
                    }
                    2 => {
                        if let Some(byte) = bytes.get_mut(at) {
                            *byte ^= 1 << random.below(8);
                        }
                    }
                    3 => {
                        let piece = PIECES[random.below(PIECES.len())];
                        bytes.splice(at..at, piece.iter().copied());
                    }
                    _ => {
                        let end = (at + random.below(40)).min(bytes.len());
                        bytes.drain(at..end);
                    }
                }
            }
            match read(name, bytes, &limits) {
                Ok(loaded) => check(&loaded.mesh),
                Err(failure) => assert!(failure.message.contains(name)),
            }
        }
    }
}

#[test]
fn random_bytes_under_any_name_never_panic() {
    let mut random = Random(2);
    for name in [
        "x", "x.ply", "x.obj", "x.stl", "x.glb", "x.gltf", "x.ply.gz",
    ] {
        for start in [
            &b""[..],
            b"ply\n",
            b"glTF",
            b"solid ",
            b"v ",
            b"{",
            b"\x1f\x8b\x08",
        ] {
            for _ in 0..100 {
                let mut bytes = start.to_vec();
                bytes.extend((0..random.below(200)).map(|_| random.next() as u8));
                let _ = plain(name, bytes);
            }
        }
    }
}
