//! Blobs byte by byte: golden ones, and everything that must be refused.

use std::path::Path;
use std::sync::atomic::AtomicU64;

use glam::DVec3;
use host_tools::blob_file::BlobFile;
use host_tools::encode::{Encoding, ObjectEncoding, SceneEncoding, encode_all, encode_scene};
use host_tools::geometry::triangles::Triangles;
use host_tools::mesh::Mesh;
use host_tools::palette::Palette;
use host_tools::render::render;
use host_tools::sampling::{Sampling, Separation, Tree};
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use proptest::prelude::*;
use rho_grid::blob::facing::BACKS_BYTES;
use rho_grid::blob::format::kind;
use rho_grid::blob::{Blob, BlobError, Instance, Layout, Light, Material};
use rho_grid::mode::Mode;
use rho_grid::q::{PixelSize, Place, Rotation, Scale, Unit};

/// Four faces in three colours, off centre, so that no two axes are alike.
fn tetrahedron() -> Mesh {
    let corners = [
        [-0.5, -0.4, -0.3],
        [0.5, -0.3, -0.2],
        [-0.2, 0.45, -0.1],
        [0.1, 0.0, 0.4],
    ];
    let positions: Vec<DVec3> = corners.map(DVec3::from).to_vec();
    let centre = positions.iter().sum::<DVec3>() / 4.0;
    Mesh {
        normals: positions.iter().map(|p| (p - centre).normalize()).collect(),
        positions,
        colours: vec![[200, 30, 10], [200, 30, 10], [200, 30, 10], [200, 30, 10]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

/// A grid for each of the sequences, which blanks part.
fn blob(sequences: &str, separation: Separation, layout: Layout) -> Vec<u8> {
    let trees: Vec<Tree> = sequences
        .split(' ')
        .map(|sequence| tree(sequence, separation))
        .collect();
    encoded(&trees, layout)
}

fn tree(sequence: &str, separation: Separation) -> Tree {
    let sampling = Sampling {
        sequence: sequence.parse().unwrap(),
        separation,
        memory: 1 << 24,
    };
    sampling
        .sample(&Triangles::new(&tetrahedron()), &AtomicU64::new(0))
        .unwrap()
}

fn encoded(trees: &[Tree], layout: Layout) -> Vec<u8> {
    let encoding = Encoding {
        layout,
        palette: Palette::of(tetrahedron().colours.into_iter()),
        origin: "generator=test\n".to_owned(),
    };
    encode_all(trees, &encoding)
}

/// The blob that most tests damage.
fn small() -> Vec<u8> {
    blob("2,3", Separation::TwentySix, Layout::MATERIAL)
}

/// The same at 6 and at 4 cells an axis.
fn two_grids() -> Vec<u8> {
    blob("2,3 4", Separation::Six, Layout::OFFSET_THIN)
}

/// Two objects, the first in two grids, three instances, two lights and a camera.
fn scene() -> Vec<u8> {
    let object = |trees: Vec<Tree>, layout, first_material, materials| ObjectEncoding {
        trees,
        layout,
        palette: Palette::of(std::iter::empty()),
        first_material,
        materials,
        bounds: [DVec3::splat(-0.5), DVec3::new(0.5, 0.25, 0.125)],
    };
    let objects = [
        object(
            vec![tree("2,3", Separation::Six), tree("4", Separation::Six)],
            Layout::OFFSET_THIN,
            0,
            1,
        ),
        object(vec![tree("3", Separation::Six)], Layout::BOTH_THIN, 1, 1),
    ];
    let quarter = [[0, 0, 1 << 30], [0, 1 << 30, 0], [-(1 << 30), 0, 0]];
    let turned = Instance {
        object: 1,
        material: Some(2),
        rotation: quarter.map(|row| row.map(Rotation::from_bits)),
        scale: Scale::from_num(0.5),
        translation: [0.25, 0.0, -0.5].map(Place::from_num),
    };
    let own = Instance {
        object: 1,
        ..Instance::AS_IS
    };
    let material = |level: u16| Material {
        ambient: [level; 3],
        diffuse: [2 * level; 3],
        specular: [100; 3],
        exponent: 9,
    };
    encode_scene(&SceneEncoding {
        objects: &objects,
        materials: [1000, 2000, 3000].map(material).to_vec(),
        instances: vec![Instance::AS_IS, turned, own],
        lights: vec![
            Light {
                casts_shadows: true,
                ..Light::white([Unit::ZERO, Unit::ONE, Unit::ZERO])
            },
            Light {
                towards: [Unit::ZERO, Unit::ZERO, -Unit::ONE],
                colour: [1 << 15, 0, 1 << 14],
                casts_shadows: false,
            },
        ],
        camera: View::from(StandardView::NearTurned).camera().unwrap(),
        background: 0x1234,
        origin: "generator=test\n".to_owned(),
    })
}

#[test]
fn what_stands_where_reads_back() {
    let bytes = scene();
    let file = BlobFile::from_bytes(&bytes, "scene");
    let blob = file.blob().unwrap();
    assert!(blob.is_scene() && assemble(&sections(&bytes)) == bytes);
    let grids: Vec<_> = blob.objects().map(|o| (o.first_grid, o.grids)).collect();
    assert_eq!(grids, [(0, 2), (2, 1)]);
    assert_eq!(blob.instance_count(), 3);
    assert_eq!(blob.instance(0), Some(Instance::AS_IS));
    let turned = blob.instance(1).unwrap();
    assert_eq!((turned.object, turned.material), (1, Some(2)));
    assert_eq!(turned.scale, Scale::from_num(0.5));
    assert_eq!(blob.materials_of(&turned), Some((2, 1)));
    assert_eq!(blob.lights().filter(|light| light.casts_shadows).count(), 1);
    let camera = View::from(StandardView::NearTurned).camera().unwrap();
    assert_eq!((blob.camera(), blob.background()), (Some(camera), 0x1234));
}

/// A scene's sections with the bytes of one of them changed.
fn with_bytes(kind: u16, at: usize, bytes: &[u8]) -> Result<(), BlobError> {
    let mut all = sections(&scene());
    let section = all.iter_mut().find(|s| s.0 == kind).unwrap();
    section.2[at..at + bytes.len()].copy_from_slice(bytes);
    parse(&assemble(&all))
}

#[test]
fn what_cannot_stand_anywhere_is_refused_by_its_number() {
    let object = |object| Err(BlobError::Object { object });
    let instance = |instance| Err(BlobError::Instance { instance });
    let light = |light| Err(BlobError::Light { light });
    for (kind, at, bytes, expected) in [
        // Objects: no grids, grids and materials that are not there, a box inside out.
        (6, 2, &[0, 0][..], object(0)),
        (6, 20, &[3, 0], object(1)),
        (6, 4, &[3, 0], object(0)),
        (6, 6, &[9, 0], object(0)),
        (6, 8, &[0, 0x7F], object(0)),
        // Instances: an object and a material that are not there, no rotation, no scale.
        (7, 0, &[2, 0], instance(0)),
        (7, 58, &[3, 0], instance(1)),
        (7, 60, &[1, 0, 0, 64], instance(1)),
        (7, 40, &[0; 4], instance(0)),
        (7, 40, &[0, 0, 0, 0xFF], instance(0)),
        // Lights: no length, two that cast shadows, brighter than white.
        (8, 2, &[0, 0], light(0)),
        (8, 22, &[1, 0], light(1)),
        (8, 24, &[1, 0x80], light(1)),
        // Camera: no focal length, no width.
        (9, 48, &[0; 4], Err(BlobError::Camera)),
        (9, 52, &[0, 0], Err(BlobError::Camera)),
    ] {
        assert_eq!(with_bytes(kind, at, bytes), expected, "{kind} {at}");
    }
    // Sections of other lengths, and one of a pair alone.
    for kind in [6, 7, 8, 9] {
        let mut all = sections(&scene());
        let section = all.iter_mut().find(|s| s.0 == kind).unwrap();
        section.2.pop();
        assert_eq!(parse(&assemble(&all)), Err(BlobError::Section { kind }));
    }
    for (kind, other) in [(6, 7), (7, 6)] {
        let mut all = sections(&scene());
        all.retain(|s| s.0 != kind);
        let found = parse(&assemble(&all));
        assert!(found.is_err(), "{kind} {other}");
    }
    for kind in [8, 9] {
        let mut all = sections(&scene());
        all.retain(|s| s.0 != kind);
        assert_eq!(parse(&assemble(&all)), Ok(()));
    }
}

/// What parsing says; the bytes are copied to an aligned place.
fn parse(bytes: &[u8]) -> Result<(), BlobError> {
    let file = BlobFile::from_bytes(bytes, "test");
    Blob::parse(file.bytes()).map(|_| ())
}

/// The bytes of every version 1 blob stand fast. `RHO_REFRESH=1` writes them anew, which is right
/// only together with a new version of the format.
#[test]
fn the_bytes_are_those_of_version_1() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let mut blobs = vec![("2-3-leaves-thin", leaves_alone()), ("scene", scene())];
    for (name, sequence, separation, layout) in [
        ("3-3", "3,3", Separation::TwentySix, Layout::MATERIAL),
        ("2-3", "2,3", Separation::TwentySix, Layout::MATERIAL),
        ("4", "4", Separation::TwentySix, Layout::OFFSET),
        ("5-thin", "5", Separation::Six, Layout::OFFSET_THIN),
        ("2-2-thin", "2,2", Separation::Six, Layout::MATERIAL),
        (
            "3-and-2-2-thin",
            "3 2,2",
            Separation::Six,
            Layout::OFFSET_THIN,
        ),
    ] {
        blobs.push((name, blob(sequence, separation, layout)));
    }
    for (name, bytes) in blobs {
        let text: String = bytes
            .chunks(32)
            .map(|row| row.iter().map(|b| format!("{b:02x}")).collect::<String>() + "\n")
            .collect();
        let path = folder.join(format!("tetrahedron-{name}.hex"));
        if std::env::var_os("RHO_REFRESH").is_some_and(|v| v == "1") {
            std::fs::write(&path, &text).unwrap();
        }
        let golden = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, golden, "{name}");
        assert_eq!(parse(&bytes), Ok(()), "{name}");
    }
}

/// SPEC.md's numbers, spelled out once more.
#[test]
fn the_header_is_as_the_specification_says() {
    let bytes = small();
    assert_eq!(&bytes[..8], b"\x89RHO\r\n\x1a\n");
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!((bytes[8], bytes[9], bytes[10], bytes[11]), (1, 0, 32, 0));
    assert_eq!(word(12) as usize, bytes.len());
    let sections = word(24);
    assert_eq!((word(20), sections), (4096, 6));
    let pages = (word(12) - word(16)).div_ceil(4096);
    assert_eq!(word(16), 32 + 16 * sections + 4 * pages);
    let checked = [&bytes[..28], &bytes[32..word(16) as usize]].concat();
    assert_eq!(word(28), crc32fast::hash(&checked));
}

#[test]
fn a_blob_cut_anywhere_is_called_truncated() {
    assert_eq!(parse(&[]), Err(BlobError::Missing));
    for bytes in [small(), scene()] {
        for length in 1..bytes.len() {
            let found = parse(&bytes[..length]);
            assert!(
                matches!(found, Err(BlobError::Truncated { .. })),
                "{length}: {found:?}"
            );
        }
    }
}

#[test]
fn a_blob_whose_tail_was_never_copied_is_called_truncated() {
    for fill in [0x00, 0xFF] {
        let mut bytes = blob("3,3", Separation::TwentySix, Layout::MATERIAL);
        let length = bytes.len();
        bytes[length - 200..].fill(fill);
        let found = parse(&bytes);
        assert!(
            matches!(found, Err(BlobError::Truncated { .. })),
            "{found:?}"
        );
    }
}

#[test]
fn no_byte_can_change_unseen() {
    for mut bytes in [small(), scene()] {
        for at in 0..bytes.len() {
            for flip in [0x01, 0x80, 0xFF] {
                bytes[at] ^= flip;
                assert!(parse(&bytes).is_err(), "byte {at} ^ {flip:02x}");
                bytes[at] ^= flip;
            }
        }
        assert_eq!(parse(&bytes), Ok(()));
    }
}

/// A section: kind, grid, contents.
type Section = (u16, u16, Vec<u8>);

fn sections(bytes: &[u8]) -> Vec<Section> {
    let file = BlobFile::from_bytes(bytes, "test");
    let blob = file.blob().unwrap();
    blob.sections()
        .map(|s| (s.kind, s.grid, s.bytes.to_vec()))
        .collect()
}

/// Puts a blob together as SPEC.md says, with nothing of the encoder.
fn assemble(sections: &[Section]) -> Vec<u8> {
    let mut body = Vec::new();
    let mut places = Vec::new();
    for (_, _, bytes) in sections {
        places.push(body.len());
        body.extend_from_slice(bytes);
        while !body.len().is_multiple_of(4) {
            body.push(0);
        }
    }
    let pages: Vec<u8> = body
        .chunks(4096)
        .flat_map(|page| crc32fast::hash(page).to_le_bytes())
        .collect();
    let start = 32 + 16 * sections.len() + pages.len();
    let mut head = b"\x89RHO\r\n\x1a\n\x01\x00\x20\x00".to_vec();
    for word in [start + body.len(), start, 4096, sections.len()] {
        head.extend((word as u32).to_le_bytes());
    }
    let mut rest = Vec::new();
    for ((kind, grid, bytes), place) in sections.iter().zip(places) {
        rest.extend(kind.to_le_bytes());
        rest.extend(grid.to_le_bytes());
        for word in [start + place, bytes.len(), 0] {
            rest.extend((word as u32).to_le_bytes());
        }
    }
    rest.extend(pages);
    let crc = crc32fast::hash(&[&head[..], &rest].concat());
    [&head[..], &crc.to_le_bytes(), &rest, &body].concat()
}

#[test]
fn two_writers_of_the_specification_agree() {
    for bytes in [
        small(),
        leaves_alone(),
        blob("5", Separation::Six, Layout::OFFSET_THIN),
        blob("3,3,3,3", Separation::TwentySix, Layout::MATERIAL),
        two_grids(),
    ] {
        assert!(assemble(&sections(&bytes)) == bytes);
    }
}

#[test]
fn a_newer_version_is_refused_even_when_all_else_is_right() {
    let mut bytes = small();
    bytes[8] = 2;
    let body = u32::from_le_bytes(bytes[16..20].try_into().unwrap()) as usize;
    let crc = crc32fast::hash(&[&bytes[..28], &bytes[32..body]].concat());
    bytes[28..32].copy_from_slice(&crc.to_le_bytes());
    assert_eq!(parse(&bytes), Err(BlobError::Newer { version: 2 }));
    let failure = BlobFile::from_bytes(&bytes, "new.rho").blob().unwrap_err();
    assert!(
        failure.message.contains("new.rho: blob version 2 is newer"),
        "{failure}"
    );
}

#[test]
fn what_faces_away_is_told_of_all_nodes_of_a_grid_that_is_there_or_not_at_all() {
    let known = sections(&small());
    let blob = BlobFile::from_bytes(&small(), "small.rho");
    let grid = blob.blob().unwrap().grid(0).unwrap();
    assert!(grid.backs().is_none());
    let bytes = BACKS_BYTES + 2 * (grid.nodes() - grid.leaf_samples()) as usize;
    let refused = Err(BlobError::Section { kind: kind::FACING });
    for (more, expected) in [
        (vec![(0, bytes)], Ok(())),
        (vec![(0, bytes - 2)], refused),
        (vec![(0, bytes + 2)], refused),
        (vec![(0, bytes - 1)], refused),
        (vec![(0, BACKS_BYTES - 4)], refused),
        (vec![(0, bytes), (0, bytes)], refused),
        (vec![(7, bytes)], refused),
    ] {
        let more: Vec<_> = more
            .iter()
            .map(|(grid, bytes)| (kind::FACING, *grid, vec![0; *bytes]))
            .collect();
        let all = [&known[..], &more].concat();
        assert_eq!(parse(&assemble(&all)), expected, "{more:?}");
    }
}

#[test]
fn an_unknown_section_is_refused_unless_it_is_optional() {
    let known = sections(&small());
    for kind in [0, 10, 15, 0x7FFF] {
        let all = [&known[..], &[(kind, 0, vec![1, 2, 3])]].concat();
        assert_eq!(
            parse(&assemble(&all)),
            Err(BlobError::UnknownSection { kind })
        );
    }
    for kind in [0x8000, 0x8003, 0xFFFF] {
        for at in 0..=known.len() {
            let mut all = known.clone();
            all.insert(at, (kind, 7, vec![9; 5]));
            assert_eq!(parse(&assemble(&all)), Ok(()), "{kind:04x}");
        }
    }
}

#[test]
fn a_missing_section_is_named_but_the_origin_may_be_missing() {
    let known = sections(&small());
    for at in 0..known.len() {
        let mut all = known.clone();
        let (kind, _, _) = all.remove(at);
        let expected = match kind {
            0x8001 => Ok(()),
            kind => Err(BlobError::MissingSection { kind }),
        };
        assert_eq!(parse(&assemble(&all)), expected);
    }
}

/// The tetrahedron by 2,3 with samples at its leaves alone.
fn leaves_alone() -> Vec<u8> {
    let mut tree = tree("2,3", Separation::Six);
    tree.drop_intermediate_samples();
    encoded(&[tree], Layout::OFFSET_THIN)
}

#[test]
fn without_intermediate_samples_cells_are_opened_however_small() {
    let all = blob("2,3", Separation::Six, Layout::OFFSET_THIN);
    let drawn = |bytes: &[u8], cell_size: u16| {
        let file = BlobFile::from_bytes(bytes, "drawn");
        let mode = Mode {
            cell_size: PixelSize::from_num(cell_size),
            ..Mode::default()
        };
        let view = StandardView::FarTurned.into();
        let drawn = render(&file.blob().unwrap(), &view, STANDARD_LIGHT, mode);
        drawn.unwrap().words
    };
    let leaves = leaves_alone();
    assert!(drawn(&all, 0) != drawn(&all, 60), "else nothing is shown");
    assert!(drawn(&leaves, 60) == drawn(&all, 0));
    assert!(drawn(&leaves, 0) == drawn(&all, 0));

    let file = BlobFile::from_bytes(&all, "all");
    let (whole, file) = (
        file.blob().unwrap().grid(0).unwrap(),
        BlobFile::from_bytes(&leaves, "leaves"),
    );
    let grid = file.blob().unwrap().grid(0).unwrap();
    assert_eq!((grid.first_sampled(), whole.first_sampled()), (2, 0));
    assert_eq!(grid.nodes(), whole.nodes());
    assert_eq!(
        (grid.first_leaf(), grid.leaf_samples()),
        (0, whole.leaf_samples())
    );
    assert_eq!(
        all.len() - leaves.len(),
        2 * whole.first_leaf() as usize / 4 * 4
    );
}

#[test]
fn every_grid_of_a_blob_is_there_and_one_more_is_not() {
    let file = BlobFile::from_bytes(&two_grids(), "two");
    let blob = file.blob().unwrap();
    let cells: Vec<u32> = blob
        .grids()
        .map(|grid| grid.cells(grid.subdivisions()))
        .collect();
    assert_eq!(cells, [6, 4]);
    assert_eq!(blob.grid_count(), 2);
    for (index, grid) in (0..).zip(blob.grids()) {
        let same = blob.grid(index).unwrap();
        assert_eq!(same.attributes(), grid.attributes());
    }
    assert!(blob.grid(2).is_none() && blob.grid(u16::MAX).is_none());
}

#[test]
fn a_part_of_a_grid_that_is_not_there_is_refused_and_so_is_a_second_one() {
    let known = sections(&two_grids());
    for at in 0..known.len() {
        let (kind, grid, bytes) = known[at].clone();
        if kind == 0x8001 {
            continue;
        }
        // Twice, or of a grid beyond those that are there.
        for owner in [grid, grid + 3, u16::MAX] {
            let all = [&known[..], &[(kind, owner, bytes.clone())]].concat();
            let found = parse(&assemble(&all));
            assert_eq!(found, Err(BlobError::Section { kind }), "{kind} of {owner}");
        }
        // Missing from the second grid.
        if grid == 1 {
            let mut all = known.clone();
            all.remove(at);
            let expected = match kind {
                // The first of what it leaves behind.
                1 => BlobError::Section { kind: 2 },
                kind => BlobError::MissingSection { kind },
            };
            assert_eq!(parse(&assemble(&all)), Err(expected));
        }
    }
}

#[test]
fn the_second_grid_is_checked_as_the_first_is() {
    for (kind, at, value, expected) in [
        (1, 8, 7, BlobError::Sequence),
        (2, 0, 0, BlobError::Mask { level: 0, node: 0 }),
        (3, 0, 9, BlobError::Children { level: 0, node: 0 }),
    ] {
        let mut all = sections(&two_grids());
        let section = all.iter_mut().find(|s| (s.0, s.1) == (kind, 1)).unwrap();
        let many = if kind == 2 { section.2.len() } else { 1 };
        section.2[at..at + many].fill(value);
        assert_eq!(parse(&assemble(&all)), Err(expected));
    }
}

#[test]
fn contents_that_contradict_each_other_are_refused() {
    let place = |kind: u16| {
        let known = sections(&small());
        known.iter().position(|s| s.0 == kind).unwrap()
    };
    let damaged = |kind: u16, at: usize, value: u8| {
        let mut all = sections(&small());
        all[place(kind)].2[at] = value;
        parse(&assemble(&all))
    };
    // The grid's own numbers.
    for (at, value, expected) in [
        (0, 0, BlobError::Sequence),
        (0, 13, BlobError::Sequence),
        (1, 18, BlobError::Sequence),
        (2, 3, BlobError::Layout),
        (3, 12, BlobError::Layout),
        (4, 5, BlobError::Layout),
        (6, 1, BlobError::Layout),
        (8, 1, BlobError::Sequence),
        (8, 6, BlobError::Sequence),
        (20, 2, BlobError::Section { kind: 4 }),
        (72, 1, BlobError::Section { kind: 4 }),
        (72, 3, BlobError::Section { kind: 1 }),
    ] {
        assert_eq!(damaged(1, at, value), Err(expected), "byte {at} = {value}");
    }
    // Nodes: an empty mask, a bit beyond 27, a child elsewhere, a material that is not there.
    assert_eq!(damaged(2, 0, 0), Err(BlobError::Mask { level: 0, node: 0 }));
    assert_eq!(
        damaged(2, 7, 0x08),
        Err(BlobError::Mask { level: 1, node: 0 })
    );
    assert_eq!(
        damaged(3, 4, 1),
        Err(BlobError::Children { level: 0, node: 0 })
    );
    let mut all = sections(&small());
    all[place(4)].2[2] |= 1;
    assert_eq!(parse(&assemble(&all)), Err(BlobError::Material { node: 1 }));
    // Lengths.
    for kind in [1, 2, 3, 4, 5] {
        for change in [-4_isize, 4] {
            let mut all = sections(&small());
            let bytes = &mut all[place(kind)].2;
            bytes.resize(bytes.len().wrapping_add_signed(change), 0);
            let found = parse(&assemble(&all));
            assert_eq!(found, Err(BlobError::Section { kind }), "{kind} {change}");
        }
    }
}

proptest! {
    #[test]
    fn bytes_at_random_are_refused_without_a_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        prop_assert!(parse(&bytes).is_err());
    }

    #[test]
    fn bytes_at_random_behind_the_magic_are_refused_without_a_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        let magic = b"\x89RHO\r\n\x1a\n\x01\x00\x20\x00";
        prop_assert!(parse(&[magic, &bytes[..]].concat()).is_err());
    }

    /// With every CRC right again: what is accepted then can also be drawn.
    #[test]
    fn contents_changed_at_random_are_refused_or_drawn_without_a_panic(
        changes in prop::collection::vec((0..10_usize, any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut all = sections(&two_grids());
        for (section, at, value) in changes {
            let bytes = &mut all[section].2;
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let file = BlobFile::from_bytes(&assemble(&all), "changed");
        if let Ok(blob) = file.blob() {
            let view = View { width: 24, height: 32, ..StandardView::NearTurned.into() };
            for grid in 0..blob.grid_count() {
                let mode = Mode {
                    grid,
                    ..Mode::default()
                };
                let drawn = render(&blob, &view, STANDARD_LIGHT, mode);
                prop_assert!(drawn.is_ok());
            }
        }
    }
}
