//! A bicubic Bezier patch, and the flat pieces that answer for it.
//!
//! A patch is halved (de Casteljau), along u or v as it bends more, until two triangles on a
//! piece's corners are as near the surface as is asked. The pieces answer where the surface
//! is (which cells, the nearest point); for the sample itself the patch is evaluated at the
//! (u, v) that was found, so that point and normal are the true surface's.

use glam::DVec3;

use super::triangle::{self, Corners};

/// Four by four control points: `points[row][column]`, u along a row and v down the columns,
/// both from 0 to 1. The normal is that of Su x Sv.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// In cube units.
    pub points: [[DVec3; 4]; 4],
}

/// The four cubic Bernstein polynomials.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// Their derivatives.
fn slopes(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        -3.0 * s * s,
        3.0 * s * (s - 2.0 * t),
        3.0 * t * (2.0 * s - t),
        3.0 * t * t,
    ]
}

/// Both halves of a cubic.
fn halve([a, b, c, d]: [DVec3; 4]) -> [[DVec3; 4]; 2] {
    let (ab, bc, cd) = (a.midpoint(b), b.midpoint(c), c.midpoint(d));
    let (abc, bcd) = (ab.midpoint(bc), bc.midpoint(cd));
    let middle = abc.midpoint(bcd);
    [[a, ab, abc, middle], [middle, bcd, cd, d]]
}

impl Patch {
    fn blend(&self, u: [f64; 4], v: [f64; 4]) -> DVec3 {
        let row = |r: &[DVec3; 4]| r[0] * u[0] + r[1] * u[1] + r[2] * u[2] + r[3] * u[3];
        let [a, b, c, d] = &self.points;
        row(a) * v[0] + row(b) * v[1] + row(c) * v[2] + row(d) * v[3]
    }

    /// The point at (u, v).
    #[must_use]
    pub fn at(&self, u: f64, v: f64) -> DVec3 {
        self.blend(bernstein(u), bernstein(v))
    }

    /// The unit normal at (u, v).
    ///
    /// At a pole, where one whole edge v = 0 or v = 1 is a single point, Su vanishes, and the
    /// limit from inside is taken: Suv x Sv, turned where v grows towards the pole.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        let down = self.blend(bernstein(u), slopes(v));
        let normal = self.blend(slopes(u), bernstein(v)).cross(down);
        if let Some(normal) = normal.try_normalize()
            && !self.is_pole(v)
        {
            return normal;
        }
        let side = if v < 0.5 { 1.0 } else { -1.0 };
        let limit = self.blend(slopes(u), slopes(v)).cross(down) * side;
        limit.try_normalize().unwrap_or(DVec3::Y)
    }

    /// Whether v lies so near a pole that Su is rounding.
    fn is_pole(&self, v: f64) -> bool {
        let single = |row: &[DVec3; 4]| row.iter().all(|p| *p == row[0]);
        (v < 1e-9 && single(&self.points[0])) || (v > 1.0 - 1e-9 && single(&self.points[3]))
    }

    /// The lowest and the highest corner of the control points' box, which holds the surface.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let all = self.points.as_flattened();
        all.iter().fold((all[0], all[0]), |(low, high), &p| {
            (low.min(p), high.max(p))
        })
    }

    /// From (u, v) towards the point of the patch nearest `p`: a few Gauss-Newton steps, as long
    /// as they come nearer.
    #[must_use]
    pub fn approach(&self, p: DVec3, mut u: f64, mut v: f64) -> (f64, f64) {
        let mut distance = p.distance_squared(self.at(u, v));
        for _ in 0..4 {
            let (bu, bv) = (bernstein(u), bernstein(v));
            let to = p - self.blend(bu, bv);
            let (su, sv) = (self.blend(slopes(u), bv), self.blend(bu, slopes(v)));
            let (uu, uv, vv) = (su.dot(su), su.dot(sv), sv.dot(sv));
            let det = uu * vv - uv * uv;
            if det <= 1e-9 * uu * vv {
                break;
            }
            let (du, dv) = (su.dot(to), sv.dot(to));
            let next = (
                (u + (vv * du - uv * dv) / det).clamp(0.0, 1.0),
                (v + (uu * dv - uv * du) / det).clamp(0.0, 1.0),
            );
            let nearer = p.distance_squared(self.at(next.0, next.1));
            if nearer >= distance {
                break;
            }
            (u, v, distance) = (next.0, next.1, nearer);
        }
        (u, v)
    }

    /// About how far the surface and its two triangles are from each other, as sets of points:
    /// across the patch, how far control points are from those of the bilinear patch with the
    /// same corners, and what that has of twist; along its edges, how far from the chord. How
    /// fast (u, v) runs within the surface does not matter.
    #[must_use]
    pub fn bend(&self) -> f64 {
        let [[a, .., b], .., [c, .., d]] = self.points;
        let normal = (d - a).cross(c - b).normalize_or_zero();
        let mut across = 0.0_f64;
        for (v, row) in [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]
            .into_iter()
            .zip(&self.points)
        {
            let (left, right) = (a.lerp(c, v), b.lerp(d, v));
            for (u, point) in [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].into_iter().zip(row) {
                across = across.max((point - left.lerp(right, u)).dot(normal).abs());
            }
        }
        let twist = 0.25 * (a - b - c + d).dot(normal).abs();
        let edges = [
            self.points[0],
            self.points[3],
            self.column(0),
            self.column(3),
        ];
        edges.into_iter().map(sag).fold(across + twist, f64::max)
    }

    fn column(&self, column: usize) -> [DVec3; 4] {
        self.points.map(|row| row[column])
    }

    /// Both halves along whichever parameter bends more.
    fn halves(&self) -> ([Self; 2], Axis) {
        let along_u = self.points.into_iter().map(sag).fold(0.0, f64::max);
        let along_v = (0..4).map(|i| sag(self.column(i))).fold(0.0, f64::max);
        let mut halves = [*self; 2];
        if along_u > along_v {
            for (row, points) in self.points.into_iter().enumerate() {
                let [first, second] = halve(points);
                halves[0].points[row] = first;
                halves[1].points[row] = second;
            }
            return (halves, Axis::U);
        }
        for column in 0..4 {
            for (half, points) in halves.iter_mut().zip(halve(self.column(column))) {
                for (row, point) in points.into_iter().enumerate() {
                    half.points[row][column] = point;
                }
            }
        }
        (halves, Axis::V)
    }

    /// Cuts the patch until every piece bends by no more than `most` (cube units).
    pub fn pieces(&self, most: f64, pieces: &mut Vec<Piece>) {
        self.cut(most, [0.0, 1.0], [0.0, 1.0], pieces);
    }

    fn cut(&self, most: f64, u: [f64; 2], v: [f64; 2], pieces: &mut Vec<Piece>) {
        if self.bend() <= most {
            let [[a, .., b], .., [c, .., d]] = self.points;
            pieces.push(Piece {
                triangles: [[a, b, d], [a, d, c]],
                u,
                v,
            });
            return;
        }
        let ([first, second], axis) = self.halves();
        let parts = |[from, to]: [f64; 2]| {
            let middle = f64::midpoint(from, to);
            ([from, middle], [middle, to])
        };
        match axis {
            Axis::U => {
                let (low, high) = parts(u);
                first.cut(most, low, v, pieces);
                second.cut(most, high, v, pieces);
            }
            Axis::V => {
                let (low, high) = parts(v);
                first.cut(most, u, low, pieces);
                second.cut(most, u, high, pieces);
            }
        }
    }
}

/// Which parameter is halved.
#[derive(Clone, Copy)]
enum Axis {
    U,
    V,
}

/// At most how far a cubic runs from its chord.
fn sag([a, b, c, d]: [DVec3; 4]) -> f64 {
    let along = (d - a).normalize_or_zero();
    let off = |p: DVec3| (p - a).reject_from_normalized(along).length();
    0.75 * off(b).max(off(c))
}

/// A flat part of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// On its corners (u0, v0), (u1, v0), (u1, v1) and (u0, v0), (u1, v1), (u0, v1).
    pub triangles: [Corners; 2],
    /// From where to where it reaches along u.
    pub u: [f64; 2],
    /// And along v.
    pub v: [f64; 2],
}

impl Piece {
    /// The point of the triangles nearest `p`, and its (u, v) in the patch.
    #[must_use]
    pub fn nearest(&self, p: DVec3) -> (DVec3, f64, f64) {
        let [first, second] = [0, 1].map(|half| {
            let weights = triangle::nearest(&self.triangles[half], p);
            let point = triangle::point(&self.triangles[half], weights);
            let (u, v) = self.at(half, weights);
            (point, u, v)
        });
        if p.distance_squared(second.0) < p.distance_squared(first.0) {
            second
        } else {
            first
        }
    }

    /// The patch's (u, v) at the point of triangle `half`, 0 or 1, with these weights.
    #[must_use]
    pub fn at(&self, half: usize, weights: [f64; 3]) -> (f64, f64) {
        let ([u0, u1], [v0, v1]) = (self.u, self.v);
        let corners = if half == 0 {
            [(u0, v0), (u1, v0), (u1, v1)]
        } else {
            [(u0, v0), (u1, v1), (u0, v1)]
        };
        let (mut u, mut v) = (0.0, 0.0);
        for (weight, at) in weights.into_iter().zip(corners) {
            u += weight * at.0;
            v += weight * at.1;
        }
        (u, v)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A lattice over the unit square whose points are moved by up to 0.2.
    fn any_patch() -> impl Strategy<Value = Patch> {
        let moved = prop::array::uniform3(-0.2..0.2_f64).prop_map(DVec3::from_array);
        prop::array::uniform4(prop::array::uniform4(moved)).prop_map(|moves| {
            let mut points = moves;
            for (row, points) in points.iter_mut().enumerate() {
                for (column, point) in points.iter_mut().enumerate() {
                    *point += DVec3::new(column as f64 / 3.0, row as f64 / 3.0, 0.0);
                }
            }
            Patch { points }
        })
    }

    proptest! {
        #[test]
        fn halves_are_the_same_surface(patch in any_patch(), u in 0.0..=1.0_f64, v in 0.0..=1.0_f64) {
            let ([first, second], axis) = patch.halves();
            let (a, b) = match axis {
                Axis::U => (patch.at(0.5 * u, v), patch.at(0.5 + 0.5 * u, v)),
                Axis::V => (patch.at(u, 0.5 * v), patch.at(u, 0.5 + 0.5 * v)),
            };
            prop_assert!(first.at(u, v).distance(a) < 1e-14);
            prop_assert!(second.at(u, v).distance(b) < 1e-14);
        }

        #[test]
        fn the_normal_is_across_both_derivatives(patch in any_patch(), u in 0.1..0.9_f64, v in 0.1..0.9_f64) {
            const STEP: f64 = 1e-6;
            let su = (patch.at(u + STEP, v) - patch.at(u - STEP, v)) / (2.0 * STEP);
            let sv = (patch.at(u, v + STEP) - patch.at(u, v - STEP)) / (2.0 * STEP);
            prop_assume!(su.cross(sv).length() > 0.1);
            prop_assert!(patch.normal(u, v).distance(su.cross(sv).normalize()) < 1e-6);
        }

        #[test]
        fn no_point_of_the_surface_is_far_from_the_pieces(patch in any_patch(), u in 0.0..=1.0_f64, v in 0.0..=1.0_f64) {
            const MOST: f64 = 1e-3;
            let mut pieces = Vec::new();
            patch.pieces(MOST, &mut pieces);
            let p = patch.at(u, v);
            let near = pieces.iter().map(|piece| piece.nearest(p).0.distance(p));
            prop_assert!(near.fold(f64::INFINITY, f64::min) <= 2.0 * MOST);
            // And they tile the square of (u, v).
            let area = |piece: &Piece| (piece.u[1] - piece.u[0]) * (piece.v[1] - piece.v[0]);
            prop_assert!((pieces.iter().map(area).sum::<f64>() - 1.0).abs() < 1e-12);
        }

        #[test]
        fn approaching_a_point_of_the_surface_finds_it(patch in any_patch(), u in 0.1..0.9_f64, v in 0.1..0.9_f64) {
            let p = patch.at(u, v);
            prop_assume!(patch.normal(u, v).z > 0.7);
            let (u, v) = patch.approach(p, u + 0.01, v - 0.01);
            prop_assert!(patch.at(u, v).distance(p) < 1e-6);
        }
    }

    #[test]
    fn at_a_pole_the_normal_is_the_limit_from_inside() {
        // A paraboloid's cap: the top edge is one point.
        let cap = |flip: bool| {
            let mut points = [(0.0, 1.0), (0.4, 1.0), (0.8, 0.8), (1.0, 0.5)].map(|(r, y)| {
                [(1.0, 0.0), (1.0, 0.55), (0.55, 1.0), (0.0, 1.0)]
                    .map(|(x, z)| DVec3::new(r * x, y, r * z))
            });
            if flip {
                points.reverse();
            }
            Patch { points }
        };
        for u in [0.0, 0.3, 1.0] {
            assert!(cap(false).normal(u, 0.0).distance(DVec3::Y) < 1e-12);
            assert!(cap(true).normal(u, 1.0).distance(DVec3::NEG_Y) < 1e-12);
            assert!(cap(false).normal(u, 1e-4).distance(DVec3::Y) < 1e-3);
        }
    }

    #[test]
    fn a_flat_patch_is_one_piece_however_its_points_are_spaced() {
        let places = [0.0, 0.7, 0.8, 1.0];
        let patch = Patch {
            points: places.map(|y| places.map(|x| DVec3::new(x, y, 0.0))),
        };
        let mut pieces = Vec::new();
        patch.pieces(1e-9, &mut pieces);
        assert_eq!(pieces.len(), 1);
    }
}
