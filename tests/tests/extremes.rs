//! Any view: tests are compiled with overflow checks, so a frame that overflows panics here.

use host_tools::geometry::triangles::Triangles;
use host_tools::render;
use host_tools::sampling::Separation;
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::blob::Layout;
use rho_grid::mode::{FootprintMode, FrameMode, Mode, ReciprocalMode, VisibilityMode};
use rho_grid::q::PixelSize;
use rho_tests::random::Random;
use rho_tests::scan::{bunny, encoded, sampled, standard_bunny};

fn pick<T: Copy>(random: &mut Random, choices: &[T]) -> T {
    choices[random.bits() as usize % choices.len()]
}

/// From on the surface to 2,000 sides away, zoom 1/8 to 2,000, fields of view of 1 to 175 degrees,
/// frames of 1 to 400 pixels a side; cells of up to 255 pixels drawn from their own sample.
fn view(random: &mut Random) -> View {
    View {
        yaw: random.between(-180.0, 180.0),
        pitch: random.between(-90.0, 90.0),
        distance: match random.bits() % 3 {
            0 => random.between(0.0, 0.9),
            1 => random.between_by_factor(1e-4, 1.0),
            _ => random.between_by_factor(0.5, 2040.0),
        },
        zoom: match random.bits() % 2 {
            0 => 1.0,
            _ => random.between_by_factor(0.125, 2000.0),
        },
        fov: random.between(1.0, 175.0),
        width: 1 + (random.bits() % 400) as u16,
        height: 1 + (random.bits() % 400) as u16,
    }
}

#[test]
fn no_view_overflows_in_any_mode() {
    let mesh = Triangles::new(bunny());
    let of = |sequence: &[u8], separation, layout| {
        encoded(&sampled(&mesh, sequence, separation), layout)
    };
    let blobs = [
        of(&[3; 4], Separation::TwentySix, Layout::MATERIAL),
        of(&[5, 4, 2, 2], Separation::TwentySix, Layout::OFFSET),
        of(&[2, 3, 2, 3, 3], Separation::Six, Layout::OFFSET_THIN),
        of(&[4], Separation::TwentySix, Layout::MATERIAL),
        standard_bunny().clone(),
    ];
    let mut random = Random::new(11);
    let mut drawn = 0;
    for _ in 0..3000 {
        let view = view(&mut random);
        let blob = blobs[random.bits() as usize % blobs.len()].blob().unwrap();
        let visibility = pick(&mut random, VisibilityMode::ALL);
        let mode = Mode {
            visibility,
            footprint: pick(&mut random, FootprintMode::ALL),
            reciprocal: pick(&mut random, ReciprocalMode::ALL),
            frame: match visibility {
                VisibilityMode::Eye => pick(&mut random, FrameMode::ALL),
                VisibilityMode::Z => FrameMode::Words,
            },
            grid: random.bits() as u16 % blob.grid_count(),
            fineness: None,
            cell_size: PixelSize::from_bits((random.bits() as u16) >> (random.bits() % 16)),
            ..Mode::default()
        };
        // A focal length beyond its Q format is refused by name; everything else is drawn.
        if view.camera().is_ok() && mode.contradiction().is_none() {
            let frame = render::render(&blob, &view, STANDARD_LIGHT, mode);
            drawn += usize::from(frame.unwrap().pixels() > 0);
        }
    }
    assert!(drawn > 800, "most views see something: {drawn}");
}

#[test]
fn a_model_far_beyond_sight_is_at_most_a_pixel_or_two() {
    let mesh = Triangles::new(bunny());
    let blob = encoded(
        &sampled(&mesh, &[3; 4], Separation::TwentySix),
        Layout::MATERIAL,
    );
    let view = View {
        distance: 2000.0,
        ..StandardView::Near.into()
    };
    let blob = blob.blob().unwrap();
    let frame = render::render(&blob, &view, STANDARD_LIGHT, Mode::default()).unwrap();
    assert!(frame.pixels() <= 4, "{}", frame.pixels());
}
