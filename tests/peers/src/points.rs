//! A flat list of points: no hierarchy, no order, a depth buffer, dots of 2x2 pixels.
//!
//! What a careful programmer writes first. Integers only: a point is two words, its
//! projection nine products, a division and two long products.

use core::hint::black_box;

use rho_grid::camera::Camera;
use rho_grid::normal;
use rho_viewer::count::{Phase, Stopwatch};
use rho_viewer::request::Scene;
use rho_viewer::size::{HEIGHT, PIXELS, WIDTH};

use rho_mps2_an385::Clock;

use crate::{Buffer, grey, lit, pixels};

/// The first word of the data: `FLAT`.
pub const MAGIC: u32 = u32::from_le_bytes(*b"FLAT");

/// x and y, then z and the index of the normal; coordinates are in 2^-16 of the cube's side.
pub type Point = [u32; 2];

/// What drawing needs beside the frame.
#[derive(Debug)]
pub struct Memory {
    /// focal / w of what each pixel shows; 0 where it shows nothing.
    depth: Buffer,
    /// The colour of each normal.
    colours: [u16; normal::COUNT],
}

impl Memory {
    /// All zeros.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            depth: crate::empty(),
            colours: [0; normal::COUNT],
        }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

/// The points in the model's memory: the magic number, how many there are, and they.
#[must_use]
pub fn points(memory: &[u8]) -> Option<&[Point]> {
    let words: &[u32] = bytemuck::try_cast_slice(memory).ok()?;
    let [magic, count, rest @ ..] = words else {
        return None;
    };
    let count = usize::try_from(*count).ok().filter(|_| *magic == MAGIC)?;
    rest.as_chunks().0.get(..count)
}

/// Draws them.
///
/// # Errors
/// When there are none, or the eye stands within the model or next to it.
pub fn draw(
    points: Option<&[Point]>,
    scene: &Scene,
    frame: &mut Buffer,
    memory: &mut Memory,
    watch: &mut Stopwatch<'_, Clock>,
) -> Result<(), &'static str> {
    let points = points.ok_or("there is no list of points here")?;
    let eye = watch
        .time(Phase::Setup, || Eye::new(&scene.camera))
        .ok_or("the eye is too near to the model for this program")?;
    watch.time(Phase::ShadingTables, || {
        for (index, colour) in (0..).zip(&mut memory.colours) {
            *colour = grey(lit(normal::normal(index), scene.light));
        }
    });
    watch.time(Phase::Clear, || {
        frame.fill([0; 8]);
        memory.depth.fill([0; 8]);
    });
    watch.time(Phase::Draw, || {
        let depth = pixels(&mut memory.depth);
        eye.draw(points, &memory.colours, pixels(frame), depth);
    });
    Ok(())
}

/// A camera in the formats of the loop.
struct Eye {
    /// World to eye, 2^-14.
    rotation: [[i32; 3]; 3],
    /// How far before the eye the world's origin lies, 2^-16; it lies on the axis.
    distance: i32,
    /// The focal length in 2^-22 pixels.
    focal: u32,
}

/// Bits under a pixel in focal / w and in screen coordinates.
const SCALE_BITS: u32 = 6;
const SCREEN_BITS: u32 = 4;

impl Eye {
    /// A camera that looks at the origin from outside the model; `None` when it stands so near
    /// that a point may lie behind it, or focal / w take more than 16 bits.
    fn new(camera: &Camera) -> Option<Self> {
        /// Half the diagonal of the cube, 2^-16.
        const REACH: i32 = 56_756;
        let [_, _, z] = camera.translation;
        let distance = -z.to_bits() >> 4;
        let focal = camera
            .focal
            .to_bits()
            .checked_mul(1 << (16 + SCALE_BITS - 12))?;
        let nearest = u32::try_from(distance - REACH).ok()?;
        (nearest > focal >> 16).then(|| Self {
            rotation: camera.rotation.map(|row| row.map(|r| r.to_bits() >> 16)),
            distance,
            focal,
        })
    }

    #[inline(never)]
    fn draw(
        &self,
        points: &[Point],
        colours: &[u16; normal::COUNT],
        frame: &mut [u16; PIXELS],
        depth: &mut [u16; PIXELS],
    ) {
        const ROW: usize = WIDTH as usize;
        let [rx, ry, rz] = self.rotation;
        // Their addresses are known before the program runs, and would be put together again for
        // each point; so they stay in registers.
        let (colours, frame, depth) = black_box((colours, frame, depth));
        // Of the pixel whose centre lies left of and above the point, by half a pixel at most.
        let middle = |side: u16| (i32::from(side) << (SCREEN_BITS - 1)) - (1 << (SCREEN_BITS - 1));
        let (cx, cy) = (middle(WIDTH), middle(HEIGHT));
        for [xy, zn] in points {
            let (x, y) = (i32::from(*xy as i16), *xy as i32 >> 16);
            let z = i32::from(*zn as i16);
            let along = |r: [i32; 3]| r[0] * x + r[1] * y + r[2] * z;
            let w = self.distance - (along(rz) >> 14);
            // Never 0 (Eye::new); the lowest bit does not matter, and tells that to the compiler.
            let scale = (self.focal / (w as u32 | 1)) as i32;
            let screen = |v: i32| ((i64::from(v) * i64::from(scale)) >> 32) as i32;
            let column = (cx + screen(along(rx))) >> SCREEN_BITS;
            let row = (cy - screen(along(ry))) >> SCREEN_BITS;
            if column as u32 >= u32::from(WIDTH) - 1 || row as u32 >= u32::from(HEIGHT) - 1 {
                continue;
            }
            let at = row as usize * ROW + column as usize;
            let (Some(colour), Some(frame), Some(depth)) = (
                colours.get((zn >> 16) as usize % normal::COUNT),
                frame
                    .get_mut(at..)
                    .and_then(<[u16]>::first_chunk_mut::<{ ROW + 2 }>),
                depth
                    .get_mut(at..)
                    .and_then(<[u16]>::first_chunk_mut::<{ ROW + 2 }>),
            ) else {
                continue;
            };
            for at in [0, 1, ROW, ROW + 1] {
                // 16 bits hold it (Eye::new).
                if i32::from(depth[at]) < scale {
                    depth[at] = scale as u16;
                    frame[at] = *colour;
                }
            }
        }
    }
}
