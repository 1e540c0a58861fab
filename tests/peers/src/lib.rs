//! Other ways to draw the scene that rho-grid draws, each a program for the emulated board.
//!
//! | program | what it draws |
//! | --- | --- |
//! | `flat-points` | every vertex of a model as a dot of 2x2 pixels, no hierarchy ([`points`]) |
//! | `triangles-5k`, `triangles` | a model's triangles, by the crate embedded-3dgfx ([`triangles`]) |
//!
//! Each takes the request and gives the report of the viewer, draws the same view twice under the
//! same light, and sends the second frame to the same panel, so that `rho bench` measures them as
//! it measures the renderer. The model is data that the host makes and the emulator's loader puts
//! where a blob would be: words, the first of them a magic number of each program's own.
#![no_std]
#![forbid(unsafe_code)]

pub mod points;
pub mod triangles;

use core::fmt::Write;
use core::mem::MaybeUninit;

use rho_grid::q::Unit;
use rho_mps2_an385::{Clock, end, end_without_panel, line, panel};
use rho_viewer::count::{Phase, Stopwatch};
use rho_viewer::panel::Screen;
use rho_viewer::report::{Exit, Report};
use rho_viewer::request::{MAX_LINE, Request, Scene};
use rho_viewer::size::{HEIGHT, PIXELS, WIDTH};

/// Eight words at a time is how a buffer is cleared fastest.
pub type Octet = [u32; 8];
/// A buffer of 16 bits a pixel.
pub type Buffer = [Octet; PIXELS / 16];

/// A buffer of zeros.
#[must_use]
pub const fn empty() -> Buffer {
    [[0; 8]; PIXELS / 16]
}

/// The pixels of a buffer.
pub fn pixels(buffer: &mut Buffer) -> &mut [u16; PIXELS] {
    bytemuck::cast_mut(buffer)
}

/// The grey of RGB565 under `lit` = max(0, n.l), 32768 = 1: the standard scene's 0.1 + 0.9 lit.
#[must_use]
pub fn grey(lit: u32) -> u16 {
    let value = 3277 + ((29491 * lit.min(1 << 15)) >> 15);
    let channel = |levels: u32| (value.min(1 << 15) * levels + (1 << 14)) >> 15;
    (channel(31) << 11 | channel(63) << 5 | channel(31)) as u16
}

/// `n.l` of two unit vectors, 32768 = 1, 0 when they point apart.
#[must_use]
pub fn lit(normal: [Unit; 3], light: [Unit; 3]) -> u32 {
    let products = normal.iter().zip(light);
    let dot: i32 = products
        .map(|(n, l)| i32::from(n.to_bits()) * i32::from(l.to_bits()))
        .sum();
    (dot.max(0) >> 13) as u32
}

/// Takes the request, draws twice, sends the second frame and reports.
///
/// `draw` times the phases of a frame and returns what it cannot do.
pub fn show(
    buffer: &'static mut [MaybeUninit<u8>; MAX_LINE],
    frame: &mut Buffer,
    mut draw: impl FnMut(&Scene, &mut Buffer, &mut Stopwatch<'_, Clock>) -> Result<(), &'static str>,
) -> ! {
    let line = line(buffer);
    let mut screen = match panel() {
        Ok(screen) => screen,
        Err(error) => end_without_panel(&error),
    };
    let mut report = Report::default();
    let mut stop = |exit, message: &str| -> ! {
        report.exit = exit;
        // Cut, if it is too long.
        let _ = report.message.write_str(message);
        end(report.clone())
    };
    let scene = match Request::parse(line) {
        Ok(Request::Model(scene))
            if (scene.camera.width, scene.camera.height) == (WIDTH, HEIGHT) =>
        {
            scene
        }
        Ok(_) => stop(
            Exit::Request,
            "this program draws a model, as large as the panel",
        ),
        Err(_) => stop(Exit::Request, "this is no request"),
    };
    let clock = Clock;
    let mut watch = Stopwatch::new(&clock);
    for _ in 0..2 {
        watch.reset();
        if let Err(message) = draw(&scene, frame, &mut watch) {
            stop(Exit::Model, message);
        }
    }
    let words = pixels(frame);
    let sent = watch.time(Phase::Send, || screen.show(words, WIDTH, HEIGHT));
    if sent.is_err() {
        stop(Exit::Panel, "the panel did not take the frame");
    }
    end(Report {
        width: WIDTH,
        height: HEIGHT,
        frame_crc32: rho_viewer::flow::crc32(words),
        phases: watch.phases(),
        ..Report::default()
    })
}
