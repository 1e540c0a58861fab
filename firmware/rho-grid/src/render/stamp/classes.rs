//! Normals as the eye sees them, once a frame.
//!
//! The 8,192 normals of attribute words are drawn as 512 classes, the faces two refinements above
//! them: a normal's class is the upper nine bits of its index. (Colours take all of a normal.)

use super::{entry, mask};
use crate::camera::Camera;
use crate::normal::{BITS, FACES, OCTANT};

/// Bits of a class.
const CLASS_BITS: u32 = 9;
/// Number of classes.
pub(super) const CLASSES: usize = 1 << CLASS_BITS;
/// Bits of a normal that its class does not tell.
pub(super) const FINER: u32 = BITS - CLASS_BITS;

/// A class of normals in eye space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Class {
    /// x to the right and y down, 32 to the unit: x + 65536 y.
    pub(super) across: u32,
    /// z towards the eye, 2^30 to the unit, but for its lower half: the direction of (x, y).
    pub(super) towards: u32,
}

/// All classes, 4 kB.
#[derive(Clone, Debug)]
pub(in crate::render) struct Classes([Class; CLASSES]);

impl Classes {
    /// Not yet filled.
    pub(in crate::render) const fn empty() -> Self {
        let none = Class {
            across: 0,
            towards: 0,
        };
        Self([none; CLASSES])
    }

    /// Turns all classes into the camera's eye space.
    ///
    /// The octants mirror each other: the nine products of a face serve eight classes.
    pub(in crate::render) fn turn(&mut self, camera: &Camera) {
        // Q14.
        let rotation = camera.rotation.map(|row| row.map(|v| v.to_bits() >> 16));
        let [right, up, back] = rotation;
        let down = up.map(|v| -v);
        for (face, [x, y, z]) in FACES.iter().step_by(1 << FINER).enumerate() {
            let [x, y, z] = [*x, *y, *z].map(i32::from);
            // Q28.
            let times = |[a, b, c]: [i32; 3]| [a * x, b * y, c * z];
            let (xs, ys, zs) = (times(right), times(down), times(back));
            let octants = self.0.iter_mut().skip(face).step_by(OCTANT >> FINER);
            for (octant, class) in octants.enumerate() {
                let sum = |[a, b, c]: [i32; 3]| {
                    let sign = |bit: usize, v: i32| if octant & bit == 0 { v } else { -v };
                    sign(4, a) + sign(2, b) + sign(1, c)
                };
                let (x, y, z) = (sum(xs), sum(ys), sum(zs));
                let across = |v: i32| (v + (1 << 22)) >> 23;
                let direction = mask::direction(x >> 14, y >> 14);
                *class = Class {
                    across: (across(x) as u32).wrapping_add((across(y) as u32) << 16),
                    towards: ((z << 2) as u32 & 0xFFFF_0000) | direction,
                };
            }
        }
    }

    /// The class of the normal `index`.
    #[inline(always)]
    pub(super) fn of(&self, index: u32) -> Class {
        entry(&self.0, index >> FINER)
    }
}
