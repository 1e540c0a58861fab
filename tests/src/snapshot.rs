//! Pictures that lie beside the tests and are compared pixel by pixel.
//!
//! `RHO_REFRESH=1 cargo test` writes them anew; look at each one before it is committed.

use std::env;
use std::path::Path;

use embedded_graphics::Drawable;
use embedded_graphics::Pixel;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics_simulator::{OutputSettings, SimulatorDisplay};
use host_tools::picture::rgb888;

/// Compares RGB565 words, `width` a row, with `snapshots/NAME.png`.
///
/// # Panics
/// When they differ, with the first pixel that does; or when there is no such picture.
pub fn check(name: &str, words: &[u16], width: u16) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("snapshots")
        .join(name)
        .with_extension("png");
    let height = words.len() / usize::from(width);
    let size = Size::new(width.into(), height.try_into().expect("a small picture"));
    let colours = words.iter().map(|word| {
        let [r, g, b] = rgb888(*word);
        Rgb888::new(r, g, b)
    });
    let points =
        (0..size.height as i32).flat_map(|y| (0..i32::from(width)).map(move |x| Point::new(x, y)));
    let mut picture = SimulatorDisplay::with_default_color(size, Rgb888::new(0, 0, 0));
    for (point, colour) in points.clone().zip(colours) {
        let Ok(()) = Pixel(point, colour).draw(&mut picture);
    }
    if env::var_os("RHO_REFRESH").is_some() {
        picture
            .to_rgb_output_image(&OutputSettings::default())
            .save_png(&path)
            .expect("the snapshot can be written");
        return;
    }
    let kept = SimulatorDisplay::<Rgb888>::load_png(&path)
        .unwrap_or_else(|e| panic!("{}: {e} (RHO_REFRESH=1 writes it)", path.display()));
    assert_eq!(kept.size(), picture.size(), "{name}");
    for point in points {
        assert_eq!(
            picture.get_pixel(point),
            kept.get_pixel(point),
            "{name} at ({}, {}): left is new, right is kept (RHO_REFRESH=1 takes the new one)",
            point.x,
            point.y
        );
    }
}
