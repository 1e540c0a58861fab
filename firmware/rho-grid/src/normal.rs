//! Normals as faces of a recursively refined octahedron.
//!
//! Botsch, Wiratanaya, Kobbelt 2002, section 4.1: three bits name the octant, every further pair
//! one of the four triangles into which the bisected edges, projected to the sphere, divide a
//! triangle: `T(i+1, 4j)` is the middle one. SPEC.md has the order of the corner triangles.
//! The octants mirror each other, so one table of 1,024 faces serves 13-bit indices.

use crate::q::Unit;

/// Bits of a normal's index.
pub const BITS: u32 = 13;
/// Number of normals.
pub const COUNT: usize = 1 << BITS;
/// Classes by which normals are drawn have so many bits less: a face two refinements above.
pub const CLASS_SHIFT: u32 = 4;
/// Normals of an octant.
pub const OCTANT: usize = COUNT / 8;

/// The faces of the octant where x, y, z are positive: unit normals, 16384 = 1, each component
/// rounded to nearest.
pub static FACES: [[i16; 3]; OCTANT] = faces();

/// The unit normal of `index` (its low 13 bits count).
#[must_use]
pub fn normal(index: u32) -> [Unit; 3] {
    let face = FACES
        .get(index as usize % OCTANT)
        .copied()
        .unwrap_or_default();
    let sign = |bit: u32, v: i16| Unit::from_bits(if index >> bit & 1 == 0 { v } else { -v });
    let [x, y, z] = face;
    [sign(12, x), sign(11, y), sign(10, z)]
}

/// One of the four triangles into which (a, b, c) is divided.
///
/// `mid` gives the point of the sphere halfway between two others; the host refines in f64 with
/// the same steps.
pub const fn child<T: Copy>(which: usize, [a, b, c]: [T; 3], [ab, bc, ca]: [T; 3]) -> [T; 3] {
    match which & 3 {
        0 => [bc, ca, ab],
        1 => [a, ab, ca],
        2 => [ab, b, bc],
        _ => [ca, bc, c],
    }
}

/// A point of the sphere, 2^30 = 1.
type Point = [i64; 3];

#[allow(
    long_running_const_eval,
    reason = "about fifteen thousand square roots, once, at compile time"
)]
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const fn faces() -> [[i16; 3]; OCTANT] {
    let one = 1 << 30;
    let mut faces = [[0; 3]; OCTANT];
    let mut index = 0;
    while index < OCTANT {
        let mut t: [Point; 3] = [[one, 0, 0], [0, one, 0], [0, 0, one]];
        let mut shift = BITS - 3;
        while shift > 0 {
            shift -= 2;
            let mids = [mid(t[0], t[1]), mid(t[1], t[2]), mid(t[2], t[0])];
            t = child(index >> shift, t, mids);
        }
        let n = unit(cross(sub(t[1], t[0]), sub(t[2], t[0])));
        // 2^30 to 2^14, rounded to nearest; the octant's normals are not negative.
        let mut axis = 0;
        while axis < 3 {
            let v = if n[axis] < 0 { -n[axis] } else { n[axis] };
            faces[index][axis] = ((v + (1 << 15)) >> 16) as i16;
            axis += 1;
        }
        index += 1;
    }
    faces
}

const fn mid(a: Point, b: Point) -> Point {
    unit([a[0] + b[0], a[1] + b[1], a[2] + b[2]])
}

const fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

const fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Scales to length 2^30, through a length of at most 2^31 so that squares fit.
const fn unit(v: Point) -> Point {
    let mut v = v;
    while max_abs(v) >= 1 << 30 {
        v = [v[0] / 2, v[1] / 2, v[2] / 2];
    }
    while max_abs(v) < 1 << 29 {
        v = [v[0] * 2, v[1] * 2, v[2] * 2];
    }
    let square = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) as u64;
    let length = square.isqrt() as i64;
    [
        (v[0] << 30) / length,
        (v[1] << 30) / length,
        (v[2] << 30) / length,
    ]
}

#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const fn max_abs(v: Point) -> i64 {
    let mut most = 0;
    let mut axis = 0;
    while axis < 3 {
        let a = v[axis].abs();
        if a > most {
            most = a;
        }
        axis += 1;
    }
    most
}

/// A face's normal, Q14, in one of the eight octants.
#[inline(always)]
pub(crate) fn signed([x, y, z]: &[i16; 3], octant: usize) -> [i32; 3] {
    let sign = |bit: usize, v: i16| {
        let v = i32::from(v);
        if octant & bit == 0 { v } else { -v }
    };
    [sign(4, *x), sign(2, *y), sign(1, *z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_normal_is_of_length_one_to_a_part_in_ten_thousand() {
        for index in 0..COUNT as u32 {
            let [x, y, z] = normal(index).map(|c| f64::from(c.to_bits()) / 16384.0);
            assert!(
                ((x * x + y * y + z * z).sqrt() - 1.0).abs() < 1e-4,
                "{index}"
            );
        }
    }

    #[test]
    fn the_octants_mirror_each_other() {
        let [x, y, z] = normal(77);
        assert_eq!(normal(77 | 1 << 12), [-x, y, z]);
        assert_eq!(normal(77 | 1 << 10), [x, y, -z]);
    }

    #[test]
    fn the_first_face_is_the_octants_diagonal_and_the_corners_lie_at_the_axes() {
        let third = (16384.0 / 3f64.sqrt()).round() as i16;
        assert_eq!(FACES[0], [third; 3]);
        // 1 at every refinement: the corner at x.
        let near_x = FACES[0b01_01_01_01_01];
        assert!(near_x[0] > 16300, "{near_x:?}");
        let near_z = FACES[0b11_11_11_11_11];
        assert!(near_z[2] > 16300, "{near_z:?}");
    }

    #[test]
    fn no_direction_is_farther_than_the_papers_error_from_its_face() {
        // Table 3, level 5: 1 - n.q is about 0.001 at worst. Over a grid of directions the
        // nearest of the octant's faces is at least that near.
        for i in 0..=20 {
            for j in 0..=20 {
                let (a, b) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let d = [a * b, (1.0 - a) * b, 1.0 - b];
                let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
                let best = FACES
                    .iter()
                    .map(|f| (0..3).map(|k| f64::from(f[k]) * d[k]).sum::<f64>() / 16384.0 / length)
                    .fold(0.0, f64::max);
                assert!(1.0 - best < 0.0012, "{d:?}: {best}");
            }
        }
    }
}
