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
    /// Along the optical axis.
    pub(super) const AHEAD: Self = Self {
        tangents: 0,
        step: (WIDTH_STEP as i32) << 19,
    };

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
        // In units of 2^30 the widths are at most 1.31 and the turn five eighths.
        let towards = self.towards(classes.get(cone >> WIDTH_BITS));
        towards < -(self.step * width) - (turn << 21)
    }
}

#[cfg(test)]
mod tests {
    use super::super::classes::CLASSES;
    use super::super::classes::tests::eye_turned;
    use super::*;
    use crate::normal::{CLASS_SHIFT, normal};
    use proptest::prelude::*;

    fn direction(class: u32) -> [f64; 3] {
        normal(class << CLASS_SHIFT).map(|v| f64::from(v.to_bits()) / 16384.0)
    }

    proptest! {
        #[test]
        fn of_a_cone_that_is_hidden_every_normal_faces_away(
            yaw in -3.2..3.2f64, pitch in -1.5..1.5f64, tangents in prop::array::uniform2(-180..180i32),
            turned in prop::array::uniform2(-32..32i32),
            width in 5..60u32
        ) {
            let (_, classes) = eye_turned(yaw, pitch);
            let [dx, dy] = turned.map(i32::abs);
            let [tx, ty] = tangents;
            let wide = Sight::new([tx.abs() + dx, ty.abs() + dy]).unwrap();
            let there = wide.along([tx + turned[0], ty + turned[1]]);
            // The 0.04 that SPEC.md leaves for rounding is part of the width.
            let sine = f64::from(width * WIDTH_STEP) / 2048.0 - 0.04;
            let mut hidden = 0;
            for axis in 0..CLASSES as u32 {
                let cone = (axis << WIDTH_BITS | width) as u16;
                if !wide.along([tx, ty]).is_hidden(cone, &classes, dx + dy) {
                    continue;
                }
                hidden += 1;
                let a = direction(axis);
                for class in 0..CLASSES as u32 {
                    let n = direction(class);
                    let cosine = a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
                    if cosine > 0.0 && (1.0 - cosine * cosine).max(0.0).sqrt() <= sine {
                        prop_assert!(there.towards(classes.get(class)) < 0, "{class}");
                    }
                }
            }
            prop_assert!(hidden > 0, "the one that looks away is");
        }
    }

    #[test]
    fn what_is_two_sided_or_too_wide_is_never_hidden() {
        let sight = Sight::new([200, -100]).unwrap();
        let mut classes = Classes::empty();
        for towards in [i32::MIN / 2, -(1 << 30)] {
            classes.0.fill(Class {
                across: 0,
                towards: towards as u32,
            });
            for width in [TWO_SIDED - 1, TWO_SIDED] {
                assert!(!sight.is_hidden(width as u16, &classes, 0));
            }
            assert!(sight.is_hidden(40, &classes, 0));
        }
    }
}
