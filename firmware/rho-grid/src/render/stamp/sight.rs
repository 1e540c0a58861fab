//! Lines of sight, and what faces away from them.

use super::classes::{Class, Classes};
use crate::blob::facing::{TWO_SIDED, WIDTH_BITS, WIDTH_STEP};

/// The line of sight of what is close together on the screen.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct Sight {
    /// Minus its tangents, 512 to the unit, y and x (the upper half).
    pub(super) tangents: u32,
    /// A step of a cone's width, 2^30 to the unit, times the vector's length.
    pub(super) step: i32,
}

impl Sight {
    /// With these tangents (512 to the unit), of which the squares' sum is at most a half.
    #[inline(always)]
    pub(in crate::render) fn new([tx, ty]: [i32; 2]) -> Option<Self> {
        let square = tx * tx + ty * ty;
        // 1 + t^2 / 2 is more than the length, by a fortieth at most.
        (square <= 1 << 17).then_some(Self {
            tangents: (-ty as u32).wrapping_add((-tx as u32) << 16),
            step: WIDTH_STEP as i32 * ((1 << 19) + square),
        })
    }

    /// Along these tangents, which are not larger than its own.
    #[inline(always)]
    pub(in crate::render) fn along(self, [tx, ty]: [i32; 2]) -> Self {
        Self {
            tangents: (-ty as u32).wrapping_add((-tx as u32) << 16),
            ..self
        }
    }

    /// How much a normal faces the eye: its cosine times the vector's length, 2^30 to the unit.
    #[inline(always)]
    pub(super) fn towards(self, class: Class) -> i32 {
        class
            .towards
            .wrapping_add(class.across.wrapping_mul(self.tangents)) as i32
    }

    /// Whether all samples in `cone` face away, also where the tangents differ by `turn` together, at
    /// most 320.
    #[inline(always)]
    pub(in crate::render) fn is_hidden(self, cone: u16, classes: &Classes, turn: i32) -> bool {
        let cone = u32::from(cone);
        let width = (cone & TWO_SIDED) as i32;
        // A width is at most 1.31 times 2^30, and a turn of 320 five eighths of that.
        let towards = self.towards(classes.get(cone >> WIDTH_BITS));
        towards < -(self.step * width) - (turn << 21)
    }
}
