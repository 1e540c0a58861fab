//! What of a grid faces away: left unseen where no back shows.
//!
//! A cone of normals for each node above the leaves says from where all samples below it face
//! away. That alone hides nothing, since the back of an open surface shows; so the blob also tells
//! from where backs can be seen at all: a bit for each of [`PLACES`] directions of the eye from the
//! cube's centre, at each of five distances. (Botsch, Wiratanaya, Kobbelt 2002, section 4.2, cull by
//! cones where an object is known to be closed.)

use super::u32_at;

/// Distances of the eye from the cube's centre, 256 to a side of the cube.
pub const DISTANCES: [u32; 5] = [256, 384, 640, 1536, 8192];
/// Places along each side of the six faces of a cube of directions.
pub const FACE: u32 = 16;
/// Directions that are told apart.
pub const PLACES: usize = 6 * (FACE * FACE) as usize;
/// Words of 32 bits for one distance.
const WORDS: usize = PLACES / 32;
/// Bytes of all distances.
pub const BACKS_BYTES: usize = 4 * WORDS * DISTANCES.len();
const _: () = assert!(PLACES.is_multiple_of(32));

/// The lower bits of a cone: its width. Above them stands the class of its axis.
pub const WIDTH_BITS: u32 = 7;
/// Some samples are a sheet with two sides: they are drawn whichever is seen.
pub const TWO_SIDED: u32 = (1 << WIDTH_BITS) - 1;
/// A cone's width is the sine of its half angle in such steps, 2048 to the unit, rounded up; one less
/// than [`TWO_SIDED`] is wider than any half space.
pub const WIDTH_STEP: u32 = 17;

/// Which of [`PLACES`] a direction, of any length, belongs to; `None` without one.
#[must_use]
pub fn place(direction: [i32; 3]) -> Option<usize> {
    let [x, y, z] = direction.map(i32::unsigned_abs);
    let (axis, largest) = if x >= y && x >= z {
        (0, x)
    } else if y >= z {
        (1, y)
    } else {
        (2, z)
    };
    // 15 bits, so that the products below fit.
    let drop = 17u32.saturating_sub(largest.leading_zeros());
    let [x, y, z] = direction.map(|v| v >> drop);
    let (along, u, v) = match axis {
        0 => (x, y, z),
        1 => (y, z, x),
        _ => (z, x, y),
    };
    let m = along.abs();
    let on_face = |w: i32| {
        let part = ((w + m) * FACE as i32).checked_div(2 * m)?;
        Some(part.clamp(0, FACE as i32 - 1) as u32)
    };
    let face = 2 * axis + u32::from(along < 0);
    Some(((face * FACE + on_face(v)?) * FACE + on_face(u)?) as usize)
}

/// Which of [`DISTANCES`] enclose the distance of `eye` (4096 to a side) from the cube's centre;
/// `None` nearer than the first.
#[must_use]
pub fn distances(eye: [i32; 3]) -> Option<core::ops::RangeInclusive<usize>> {
    let square: u64 = eye.iter().map(|v| u64::from(v.unsigned_abs()).pow(2)).sum();
    let beyond = DISTANCES
        .iter()
        .filter(|d| (u64::from(**d) << 4).pow(2) <= square)
        .count();
    let last = DISTANCES.len() - 1;
    Some(beyond.checked_sub(1)?..=beyond.min(last))
}

/// From where backs of a grid's samples can be seen.
#[derive(Clone, Copy, Debug)]
pub struct Backs<'a>(pub(super) &'a [u8]);

impl Backs<'_> {
    /// Whether some may be seen from `eye` (4096 to a side of the cube, from its centre).
    #[must_use]
    pub fn show(&self, eye: [i32; 3]) -> bool {
        let (Some(distances), Some(place)) = (distances(eye), place(eye)) else {
            return true;
        };
        let word = |distance: usize| u32_at(self.0, 4 * (WORDS * distance + place / 32));
        distances
            .into_iter()
            .any(|distance| word(distance) >> (place % 32) & 1 == 1)
    }
}

/// How far apart the classes of normals are by which a grid of so many cells is drawn: in a coarse
/// grid neighbouring discs differ more than neighbouring normals.
#[must_use]
pub const fn classes_apart(cells: u32) -> usize {
    if cells <= 40 { 4 } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use proptest::prelude::*;
    use std::vec::Vec;

    #[test]
    fn every_place_has_its_direction() {
        let mut found = Vec::new();
        for axis in 0..3 {
            for sign in [1, -1] {
                for (i, j) in (0..FACE as i32).flat_map(|i| (0..FACE as i32).map(move |j| (i, j))) {
                    let mut d = [0; 3];
                    d[axis] = sign * 1000 * FACE as i32;
                    d[(axis + 1) % 3] = 1000 * (2 * i + 1 - FACE as i32);
                    d[(axis + 2) % 3] = 1000 * (2 * j + 1 - FACE as i32);
                    found.push(place(d).unwrap());
                }
            }
        }
        found.sort_unstable();
        assert!(found.into_iter().eq(0..PLACES));
        assert_eq!(place([0; 3]), None);
    }

    #[test]
    fn a_distance_lies_between_two_or_beyond_the_last() {
        let at = |d: f64| distances([0, (d * 4096.0) as i32, 0]);
        assert_eq!(at(0.99), None);
        assert_eq!(at(1.0), Some(0..=1));
        assert_eq!(at(2.4), Some(1..=2));
        assert_eq!(at(31.9), Some(3..=4));
        assert_eq!(at(400.0), Some(4..=4));
    }

    proptest! {
        #[test]
        fn any_eye_has_a_place(eye in prop::array::uniform3(any::<i32>())) {
            prop_assume!(eye != [0; 3]);
            prop_assert!(place(eye).unwrap() < PLACES);
            let _ = distances(eye);
        }
    }
}
