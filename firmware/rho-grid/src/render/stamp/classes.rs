//! Normals as the eye sees them, once a frame.
//!
//! The 8,192 normals of attribute words are drawn as 512 classes, the faces two refinements above
//! them: a normal's class is the upper nine bits of its index. (Colours take all of a normal.)

use super::{entry, mask};
use crate::camera::Camera;
use crate::normal::{BITS, CLASS_SHIFT, FACES};

/// Number of classes.
pub(super) const CLASSES: usize = 1 << (BITS - CLASS_SHIFT);
/// Classes of an octant.
const FACES_A_OCTANT: usize = CLASSES / 8;

/// `[65 (y + 32) + x + 32]`: the direction nearest to (x, y), 32 to the unit.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static DIRECTIONS: [u8; 65 * 65] = {
    let mut directions = [0; 65 * 65];
    let mut at = 0;
    while at < 65 * 65 {
        directions[at as usize] = mask::direction(at % 65 - 32, at / 65 - 32) as u8;
        at += 1;
    }
    directions
};

/// A class of normals in eye space.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Class {
    /// x to the right and y down, 32 to the unit: x + 65536 y.
    pub(super) across: u32,
    /// z towards the eye, 2^30 to the unit, but for its lower half: the direction of (x, y).
    pub(super) towards: u32,
}

/// All classes, 4 kB.
#[derive(Clone, Debug)]
pub(in crate::render) struct Classes(pub(super) [Class; CLASSES]);

impl Classes {
    /// Not yet filled.
    pub(in crate::render) const fn empty() -> Self {
        let none = Class {
            across: 0,
            towards: 0,
        };
        Self([none; CLASSES])
    }

    /// Turns each `every`th class into the camera's eye space; it serves those up to the next, too.
    ///
    /// The octants mirror each other: the nine products of a face serve eight classes, and of
    /// opposite normals one follows from the other.
    pub(in crate::render) fn turn(&mut self, camera: &Camera, every: usize) {
        // Q14.
        let rotation = camera.rotation.map(|row| row.map(|v| v.to_bits() >> 16));
        let [right, up, back] = rotation;
        let down = up.map(|v| -v);
        let faces = FACES.iter().step_by(every << CLASS_SHIFT);
        for (face, [x, y, z]) in (0..).step_by(every).zip(faces) {
            let [x, y, z] = [*x, *y, *z].map(i32::from);
            // Q28; the four sums of positive x, by the octant's two lower bits.
            let sums = |[a, b, c]: [i32; 3]| {
                let (a, b, c) = (a * x, b * y, c * z);
                let (plus, minus) = (a + b, a - b);
                [plus + c, plus - c, minus + c, minus - c]
            };
            let ([a, b, c, d], [e, f, g, h]) = (sums(right), sums(down));
            let [i, j, k, l] = sums(back);
            for (octant, eye) in [[a, e, i], [b, f, j], [c, g, k], [d, h, l]]
                .into_iter()
                .enumerate()
            {
                self.pair(face + octant * FACES_A_OCTANT, every, eye);
            }
        }
    }

    /// Sets `count` classes of positive x, and their opposites: in the last octant if they are in the
    /// first.
    #[inline(always)]
    fn pair(&mut self, index: usize, count: usize, [x, y, z]: [i32; 3]) {
        let (x, y) = ((x + (1 << 22)) >> 23, (y + (1 << 22)) >> 23);
        let direction = DIRECTIONS.get((65 * y + x + 65 * 32 + 32) as usize);
        let direction = u32::from(direction.copied().unwrap_or(0));
        let across = (x as u32).wrapping_add((y as u32) << 16);
        let towards = |z: i32| ((z << 2) as u32 & 0xFFFF_0000) | direction;
        let class = Class {
            across,
            towards: towards(z),
        };
        let facing_away = Class {
            across: 0u32.wrapping_sub(across),
            towards: towards(-z),
        };
        let opposite = index ^ (CLASSES - FACES_A_OCTANT);
        for (first, class) in [(index, class), (opposite, facing_away)] {
            if count == 1 {
                // A loop would cost more than all else.
                if let Some(slot) = self.0.get_mut(first) {
                    *slot = class;
                }
                continue;
            }
            let classes = self.0.get_mut(first..first + count);
            classes.unwrap_or_default().fill(class);
        }
    }

    /// Class `index`, nine bits.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> Class {
        entry(&self.0, index)
    }

    /// The class of the normal `index`.
    #[inline(always)]
    pub(super) fn of(&self, index: u32) -> Class {
        self.get(index >> CLASS_SHIFT)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::normal::normal;
    use crate::q::{Focal, Length, Rotation};
    extern crate std;
    use proptest::prelude::*;

    /// The axes of an eye that is turned so, and all classes in them.
    pub(in super::super) fn eye_turned(yaw: f64, pitch: f64) -> ([[f64; 3]; 3], Classes) {
        let ((sy, cy), (sp, cp)) = (yaw.sin_cos(), pitch.sin_cos());
        let rows = [
            [cy, 0.0, -sy],
            [-sy * sp, cp, -cy * sp],
            [sy * cp, sp, cy * cp],
        ];
        let bits = |v: f64| Rotation::from_bits((v * 1_073_741_823.0) as i32);
        let camera = Camera {
            rotation: rows.map(|row| row.map(bits)),
            translation: [Length::ZERO; 3],
            focal: Focal::ONE,
            width: 1,
            height: 1,
        };
        let mut classes = Classes::empty();
        classes.turn(&camera, 1);
        (rows, classes)
    }

    proptest! {
        #[test]
        fn a_class_is_its_normal_in_eye_space(
            yaw in -3.2..3.2f64, pitch in -1.5..1.5f64, index in 0..8192u32
        ) {
            let (rows, classes) = eye_turned(yaw, pitch);
            let class = classes.of(index);
            let n = normal(index >> CLASS_SHIFT << CLASS_SHIFT).map(|c| f64::from(c.to_bits()) / 16384.0);
            let eye = rows.map(|r| r[0] * n[0] + r[1] * n[1] + r[2] * n[2]);
            let x = f64::from(class.across as i16);
            let y = (f64::from(class.across as i32) - x) / 65536.0;
            prop_assert!((x / 32.0 - eye[0]).abs() < 0.017);
            prop_assert!((y / 32.0 + eye[1]).abs() < 0.017);
            let z = f64::from(class.towards as i32) / f64::from(1 << 30);
            prop_assert!((z - eye[2]).abs() < 3e-4);
        }
    }
}
