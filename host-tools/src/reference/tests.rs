//! What the ground truth must show, by hand and on the scans.

use super::*;
use crate::model::{LoadOptions, load, scan};
use crate::view::StandardView;

/// A square in the plane z, facing +z.
fn square(z: f64, half: f64) -> Mesh {
    Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x * half, y * half, z))
            .to_vec(),
        normals: vec![DVec3::Z; 4],
        colours: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn shoot(mesh: &Mesh, shot: &Shot) -> Truth {
    Caster::new(mesh).render(shot, &|| ()).unwrap()
}

#[test]
fn the_front_face_of_the_cube_is_216_pixels_wide_and_lit_by_the_rule() {
    let view = View::from(StandardView::Near);
    let truth = shoot(&square(0.5, 0.5), &Shot::standard(view));
    assert_eq!(truth.covered_centres(), 216 * 216);
    let light = crate::view::STANDARD_LIGHT.normalize();
    let grey = (255.0 * (0.1 + 0.9 * light.z)).round() as u8;
    let middle = 160 * 240 + 120;
    assert_eq!(truth.picture.rgb[middle], [grey; 3]);
    assert_eq!(truth.picture.coverage.as_ref().unwrap()[middle], 255);
    assert!((truth.depth.values[middle] - (2.2883 - 0.5)).abs() < 1e-12);
    assert_eq!(truth.picture.rgb[0], [0; 3]);
    assert_eq!(truth.depth.values[0], f64::INFINITY);
    // No ray slips between the two triangles.
    let inside = (60..250).flat_map(|y| (20..220).map(move |x| y * 240 + x));
    let coverage = truth.picture.coverage.unwrap();
    assert!(inside.into_iter().all(|i| coverage[i] == 255));
}

#[test]
fn a_half_covered_pixel_is_half_as_bright() {
    let mut shot = Shot::standard(View::from(StandardView::Near));
    shot.samples = 4;
    // The edge passes through the middle of the pixels of column 120.
    let mut mesh = square(0.0, 0.4);
    let pixel = shot.view.distance / shot.view.focal();
    for p in &mut mesh.positions {
        p.x = p.x.max(0.5 * pixel);
    }
    let truth = shoot(&mesh, &shot);
    let row = 160 * 240;
    assert_eq!(truth.picture.coverage.as_ref().unwrap()[row + 120], 128);
    let (half, full) = (
        truth.picture.rgb[row + 120][0],
        truth.picture.rgb[row + 121][0],
    );
    assert!(full.div_ceil(2).abs_diff(half) <= 1, "{half} {full}");
}

#[test]
fn a_back_is_lit_by_its_outward_normal_unless_two_sided() {
    let mut mesh = square(0.0, 0.4);
    mesh.triangles = vec![[0, 2, 1], [0, 3, 2]];
    mesh.normals = vec![-DVec3::Z; 4];
    let mut shot = Shot::standard(View::from(StandardView::Far));
    let middle = 160 * 240 + 120;
    assert_eq!(shoot(&mesh, &shot).picture.rgb[middle], [26; 3]);
    shot.two_sided = true;
    let front = shoot(&square(0.0, 0.4), &shot);
    assert!(shoot(&mesh, &shot).picture == front.picture);
}

#[test]
fn colours_multiply_the_light() {
    let mut mesh = square(0.0, 0.4);
    let mut shot = Shot::standard(View::from(StandardView::Near));
    shot.light = DVec3::Z;
    mesh.colours = vec![[200, 100, 0]; 4];
    assert_eq!(
        shoot(&mesh, &shot).picture.rgb[160 * 240 + 120],
        [200, 100, 0]
    );
}

#[test]
fn a_view_or_a_number_of_rays_out_of_range_is_refused() {
    let mesh = square(0.0, 0.4);
    let mut shot = Shot::standard(View::from(StandardView::Near));
    shot.samples = 0;
    let failure = Caster::new(&mesh).render(&shot, &|| ()).unwrap_err();
    assert!(failure.message.contains("--samples 0"));
    shot.samples = 5;
    shot.view.fov = 200.0;
    let failure = Caster::new(&mesh).render(&shot, &|| ()).unwrap_err();
    assert!(failure.message.contains("--fov"));
}

#[test]
fn the_bunny_covers_the_pixel_centres_of_the_standard_scene() {
    let mesh = load(&scan("bunny").unwrap(), &LoadOptions::default())
        .unwrap()
        .mesh;
    let caster = Caster::new(&mesh);
    let expected = [19_416, 1_090, 18_853, 1_149];
    for (view, expected) in StandardView::ALL.into_iter().zip(expected) {
        let mut shot = Shot::standard(View::from(view));
        shot.samples = 1;
        let truth = caster.render(&shot, &|| ()).unwrap();
        assert_eq!(truth.covered_centres(), expected, "{}", view.name());
    }
}

#[test]
fn one_exact_ray_a_pixel_scores_what_the_standard_scene_says() {
    let mesh = load(&scan("bunny").unwrap(), &LoadOptions::default())
        .unwrap()
        .mesh;
    let caster = Caster::new(&mesh);
    for (view, union, inside) in [
        (StandardView::Near, 34.7, 44.5),
        (StandardView::Far, 26.0, 30.1),
    ] {
        let mut shot = Shot::standard(View::from(view));
        let truth = caster.render(&shot, &|| ()).unwrap();
        shot.samples = 1;
        let exact = caster.render(&shot, &|| ()).unwrap();
        let score = crate::compare::compare(&exact.picture, &truth.picture, [0; 3], None).unwrap();
        println!("{} {score:?}", view.name());
        assert!((score.psnr_union.unwrap() - union).abs() < 0.1, "{score:?}");
        assert!(
            (score.psnr_inside.unwrap() - inside).abs() < 0.1,
            "{score:?}"
        );
        assert!(score.iou > 0.9985, "{score:?}");
    }
}
