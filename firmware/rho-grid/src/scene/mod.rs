//! Many objects in one frame.
//!
//! The camera of an instance is the scene's, composed with the instance's transform in integers: a
//! grid is then drawn as if it were alone, and no view, table or walk knows of the others.
//!
//! ```text
//! Arrangement::arrange   instances in view, from front to back                    arrange.rs
//! for each of its turns
//!     Placed::new        camera and grid of the instance, what its depths are worth
//!     View::prepare
//!     shading            lights turned into the instance's axes
//!     draw_seen          into the frame; what is tangled, into a depth buffer over it
//! ```

mod arrange;
mod body;
mod tones;

pub use arrange::{Arrangement, Turn};
pub use tones::SceneTones;

use crate::blob::{Blob, Grid, Instance, Light};
use crate::camera::Camera;
use crate::lighting::Lighting;
use crate::mode::{FootprintMode, Mode, choose};
use crate::q::{Length, Rotation, Unit};
use crate::render::View;

/// An instance as a camera sees it.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// Its number.
    pub number: u16,
    /// What the blob says of it.
    pub instance: Instance,
    /// The camera in the axes and the unit of the instance's cube.
    pub camera: Camera,
    /// The grid that is drawn.
    pub grid: Grid<'a>,
    /// That grid's number.
    pub index: u16,
    /// How it is drawn.
    pub mode: Mode,
}

impl<'a> Placed<'a> {
    /// Instance `number` of `blob` as `camera` sees it, in the grid that `mode` names or that is fine
    /// enough for its size on the screen. `None` when there is none, or it is farther away than 2,047
    /// of its own sides.
    #[must_use]
    pub fn new(blob: &Blob<'a>, number: u16, camera: &Camera, mode: Mode) -> Option<Self> {
        let instance = blob.instance(number)?;
        let object = blob.object(instance.object)?;
        let near = body::cells(camera, &object, &instance);
        let camera = seen_from(camera, &instance)?;
        let grid = match mode.fineness {
            Some(preset) => {
                let grids = object.first_grid..object.first_grid.saturating_add(object.grids);
                choose(blob.finenesses(grids), preset.cells(&camera).max(near))
            }
            None => mode.grid.min(object.grids - 1),
        };
        let index = object.first_grid + grid;
        let grid = blob.grid(index)?;
        let discs = mode.footprint == FootprintMode::Disc;
        let footprint = if mode.fineness.is_some() && discs && grid.layout().offset == 0 {
            FootprintMode::Box
        } else {
            mode.footprint
        };
        Some(Self {
            number,
            instance,
            camera,
            grid,
            index,
            mode: Mode { footprint, ..mode },
        })
    }

    /// Towards the eye from the cube's centre, in the cube's axes, of length 1; along the optical
    /// axis when the eye is there.
    #[must_use]
    pub fn towards_eye(&self) -> [Unit; 3] {
        let [right, up, back] = self
            .camera
            .rotation
            .map(|row| row.map(|v| v.to_bits() >> 16));
        let t = self.camera.translation.map(|v| i64::from(v.to_bits()));
        let largest = t.iter().fold(0, |most, v| most | v.unsigned_abs());
        // At most 15 bits each.
        let drop = (64 - largest.leading_zeros()).saturating_sub(15);
        let [x, y, z] = t.map(|v| -(v >> drop) as i32);
        let length = ((x * x + y * y) as u32)
            .wrapping_add((z * z) as u32)
            .isqrt() as i32;
        let [x, y, z] = if length < 1 << 8 {
            [0, 0, 1 << 14]
        } else {
            [x, y, z].map(|v| (v << 14) / length)
        };
        let along = |axis: usize| {
            let of = |row: [i32; 3]| row.get(axis).copied().unwrap_or(0);
            let sum = i64::from(of(right)) * i64::from(x)
                + i64::from(of(up)) * i64::from(y)
                + i64::from(of(back)) * i64::from(z);
            Unit::from_bits(((sum + (1 << 13)) >> 14).clamp(-(1 << 14), 1 << 14) as i16)
        };
        [along(0), along(1), along(2)]
    }

    /// The lights as this instance sees them: the blob's, the first of them towards `first`; one white
    /// one if it has none.
    #[must_use]
    pub fn lighting(&self, blob: &Blob<'_>, first: [Unit; 3]) -> Lighting {
        let turned = lights(blob, first).map(|light| Light {
            towards: self.instance.into_cube(light.towards),
            ..light
        });
        Lighting::new(turned, self.towards_eye())
    }

    /// What [`ZBuffer`](crate::render::ZBuffer) multiplies `view`'s w by, so that depths of all
    /// instances are in one unit: `unit` says how many bits a side of the scene's cube has in w.
    #[must_use]
    pub fn depth_factor(&self, view: &View, unit: u32) -> u32 {
        let scale = u64::from(self.instance.scale.to_bits());
        let shift = unit as i32 - view.w_bits() as i32 - 11;
        let factor = if shift < 0 {
            scale.checked_shr(shift.unsigned_abs()).unwrap_or(0)
        } else {
            scale << shift.min(31)
        };
        u32::try_from(factor).unwrap_or(u32::MAX)
    }
}

/// The blob's lights, the first of them towards `first`; one white one if it has none.
fn lights<'a>(blob: &Blob<'a>, first: [Unit; 3]) -> impl Iterator<Item = Light> + use<'a> {
    let mut lights = blob.lights();
    let own = lights.next().map_or(Light::white(first), |light| Light {
        towards: first,
        ..light
    });
    core::iter::once(own).chain(lights)
}

/// `camera` in the axes and the unit of the instance's cube; `None` when that is farther away than
/// its numbers reach. Rounded to nearest.
fn seen_from(camera: &Camera, instance: &Instance) -> Option<Camera> {
    if *instance == Instance::AS_IS {
        return Some(*camera);
    }
    let scale = i64::from(instance.scale.to_bits()).max(1);
    let mut composed = *camera;
    let eye = body::place(camera, &instance.translation);
    for (t, eye) in composed.translation.iter_mut().zip(eye) {
        // Q40 over Q30, to Q20.
        let bits = ((eye << 10) + scale / 2).div_euclid(scale);
        *t = Length::from_bits(i32::try_from(bits).ok()?);
    }
    composed.rotation = turned(&camera.rotation, &instance.rotation);
    Some(composed)
}

/// The product of two rotations, rounded to nearest.
fn turned(a: &[[Rotation; 3]; 3], b: &[[Rotation; 3]; 3]) -> [[Rotation; 3]; 3] {
    let [x, y, z] = *b;
    a.map(|[ax, ay, az]| {
        let entry = |bx: Rotation, by: Rotation, bz: Rotation| {
            let product =
                |a: Rotation, b: Rotation| i64::from(a.to_bits()) * i64::from(b.to_bits());
            // Rows of length 1: a sum of products is at most 1, and a thousandth.
            let sum = product(ax, bx) + product(ay, by) + product(az, bz);
            let one = 1 << 30;
            Rotation::from_bits(((sum + (1 << 29)) >> 30).clamp(-one, one) as i32)
        };
        let ([a, b, c], [d, e, f], [g, h, i]) = (x, y, z);
        [entry(a, d, g), entry(b, e, h), entry(c, f, i)]
    })
}
