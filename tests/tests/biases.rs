//! What the biases of shadows cost and gain: prints docs/shadows.md.
//!
//! `cargo test --release --package rho-tests --test biases -- --ignored --nocapture`

use glam::DVec3;
use host_tools::picture::Picture;
use host_tools::reference::{Caster as Rays, Shot};
use host_tools::render;
use host_tools::shadows::{Pair, Wrong, compare};
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::blob::Instance;
use rho_grid::mode::{LightSplat, MapSize, Preset};
use rho_grid::render::shadow::{Bias, Caster, LightSpace, ShadowMap, ShadowView, Shadowed};
use rho_grid::render::{self as draw, Tones, tone_words};
use rho_grid::scene::{Placed, SceneTones};
use rho_tests::scan::{bunny, standard_bunny};

const WIDTH: usize = 240;

/// The standard light, and three from the sides.
const LIGHTS: [DVec3; 4] = [
    STANDARD_LIGHT,
    DVec3::new(1.0, 0.5, 0.2),
    DVec3::new(-0.9, 0.6, 0.1),
    DVec3::new(0.2, 1.0, 0.1),
];

/// The bunny by `balanced`, with these biases of look-ups and of splats (256ths of a texel inwards for each
/// texel of their side), and without shadows.
fn drawn(view: &View, light: DVec3, map: u16, looked_up: Bias, inwards: i32) -> [Picture; 2] {
    let blob = standard_bunny().blob().unwrap();
    let (camera, towards) = (view.camera().unwrap(), render::light(light));
    let mode = Preset::Balanced.mode(&blob, &camera);
    let placed = Placed::new(&blob, 0, &camera, mode).unwrap();
    let grid = &placed.grid;
    let (instance, size) = (Instance::AS_IS, MapSize::of(map).unwrap());

    let mut space = LightSpace::towards(towards);
    space.hold(&instance, grid);
    let splat = LightSplat::of(2).unwrap();
    let caster = Caster::of(&blob, &instance, &space, size, splat).unwrap();
    let mut cast = Box::new(ShadowView::empty());
    let bias = Bias {
        texels: -inwards * caster.splat as i32,
        ..Bias::splat(caster.splat)
    };
    cast.prepare(&space, size, &instance, (&caster.grid, caster.level), bias);
    let mut texels = vec![0; size.words()];
    let mut map = ShadowMap::cleared(&mut texels, size).unwrap();
    caster.cast(&cast, &mut map);
    let mut view = Box::new(ShadowView::empty());
    let leaves = (grid, grid.subdivisions());
    view.prepare(&space, size, &instance, leaves, looked_up);

    let mut tables = Box::new(draw::View::empty());
    tables.prepare(&camera, grid, mode.cell_size).unwrap();
    let mut tones = Box::new(SceneTones::empty());
    tones.shade(&blob, &placed, towards);
    let palette = tones.palette(&blob);
    [true, false].map(|shadows| {
        let mut buffer = vec![0; tone_words(WIDTH, camera.height)];
        let frame = Tones::cleared(&mut buffer, WIDTH, camera.width, camera.height);
        let mut frame = frame.unwrap();
        let reach = if shadows {
            let shade = Shadowed {
                shade: &*tones,
                view: &view,
                map: &map,
            };
            draw::draw_seen(mode, grid, &tables, &shade, &mut frame)
        } else {
            draw::draw_seen(mode, grid, &tables, &*tones, &mut frame)
        };
        frame.fill(reach.unwrap());
        let words: Vec<u16> = frame.rows().flatten().map(|t| palette.colour(*t)).collect();
        Picture::from_rgb565(camera.width.into(), camera.height.into(), &words)
    })
}

/// With these biases, over both near views and all lights.
fn wrong(truths: &[(View, DVec3, [Picture; 2])], map: u16, looked_up: Bias, inwards: i32) -> Wrong {
    let mut sum = Wrong::default();
    for (view, light, [shadowed, lit]) in truths {
        let ours = drawn(view, *light, map, looked_up, inwards);
        let ours = Pair {
            shadowed: &ours[0],
            lit: &ours[1],
        };
        let wrong = compare(ours, Pair { shadowed, lit }, [0; 3]).unwrap();
        sum.covered += wrong.covered;
        sum.shadowed += wrong.shadowed;
        sum.acne += wrong.acne;
        sum.leaks += wrong.leaks;
    }
    sum
}

#[test]
#[ignore = "prints a page; nothing is judged"]
fn biases() {
    let rays = Rays::new(bunny());
    let mut truths = Vec::new();
    for view in [StandardView::Near, StandardView::NearTurned] {
        for light in LIGHTS {
            let pictures = [true, false].map(|shadows| {
                let shot = Shot {
                    samples: 1,
                    light: light.normalize(),
                    shadows,
                    ..Shot::standard(view.into())
                };
                rays.render(&shot, &|| ()).unwrap().picture
            });
            truths.push((View::from(view), light, pictures));
        }
    }
    println!("# Biases of shadows\n");
    println!(
        "Pixels of the bunny, drawn by `balanced`, that a ray-caster shades otherwise, of a hundred that are"
    );
    println!(
        "covered: too dark (acne) and too bright (leaks), over `near` and `near-turned` and four lights, the"
    );
    println!(
        "standard one and three from the sides. Look-ups are moved outwards by texels and by cells and towards the"
    );
    println!(
        "light by texels, splats of two texels inwards. The line in use is the first of each map. By"
    );
    println!(
        "`cargo test --release --package rho-tests --test biases -- --ignored --nocapture`.\n"
    );
    println!(
        "| map | outwards, texels | outwards, cells | towards, texels | splats inwards, texels | acne | leaks | wrong |"
    );
    println!("| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    let used = Bias::LOOKED_UP;
    for map in [64, 128, 256] {
        for (texels, cells, towards, inwards) in [
            (used.texels, used.cells, used.towards, 80),
            (0, 0, 0, 0),
            (used.texels, used.cells, used.towards, 0),
            (0, used.cells, used.towards, 80),
            (used.texels, 0, used.towards, 80),
            (used.texels, used.cells, 0, 80),
            (used.texels, 2 * used.cells, used.towards, 80),
            (2 * used.texels, used.cells, used.towards, 80),
        ] {
            let bias = Bias {
                texels,
                cells,
                towards,
                back: 0,
            };
            let wrong = wrong(&truths, map, bias, inwards);
            let per_cent = |n: usize| 100.0 * n as f64 / wrong.covered as f64;
            let part = |n: i32| f64::from(n) / 256.0;
            println!(
                "| {map} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} % | {:.2} % | {:.2} % |",
                part(texels),
                part(cells),
                part(towards),
                2.0 * part(inwards),
                per_cent(wrong.acne),
                per_cent(wrong.leaks),
                wrong.per_cent()
            );
        }
    }
}
