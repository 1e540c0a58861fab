//! One triangle and three questions: which boxes does it meet, which crosses, and what is
//! its point nearest a centre?
//!
//! Boxes by separating axes (Akenine-Moller 2001, *Fast 3D triangle-box overlap testing*):
//! the three axes of the box, the triangle's normal, and the nine products of an axis of the
//! box with an edge. Each product lies in a coordinate plane, so its test is the same for a
//! whole row of boxes (Schwarz & Seidel 2010 use the same split). Nearest points by the
//! regions of Ericson 2004, *Real-Time Collision Detection*, section 5.1.5. Crosses as in
//! Huang, Yagel, Filippov & Kurzion 1998.
//!
//! All three hold for triangles of no area, which are segments or points: for the boxes every
//! axis is tested with the extent of the *whole* triangle along it, so that an axis that
//! rounding turned, or that vanished, separates nothing that it should not.

use glam::DVec3;

use super::cells::{MAX_RHO, Subcells};

/// More than the rounding of a projection onto an axis of length 1, for points of the cube.
const ROUNDING: f64 = 1e-15;

const RHO: usize = MAX_RHO as usize;

/// The three corners, in cube units.
pub type Corners = [DVec3; 3];

/// The lowest and the highest corner of the triangle's bounding box.
#[must_use]
pub fn bounds([a, b, c]: &Corners) -> (DVec3, DVec3) {
    (a.min(*b).min(*c), a.max(*b).max(*c))
}

/// Twice the area times the unit normal, counter-clockwise from outside.
#[must_use]
pub fn area_normal([a, b, c]: &Corners) -> DVec3 {
    (b - a).cross(c - a)
}

/// The subcells that the triangle meets, faces included; see [`super::Geometry::meets`].
#[must_use]
pub fn meets(corners: &Corners, subcells: &Subcells) -> u128 {
    let (low, high) = bounds(corners);
    let Some([x, y, z]) = subcells.range(low, high) else {
        return 0;
    };
    if x.1 - x.0 == 1 && y.1 - y.0 == 1 && z.1 - z.0 == 1 {
        // Most triangles of a scan end here: wholly inside one subcell.
        let from = [x.0, y.0, z.0];
        let inside = (0..3).all(|axis| {
            let planes = subcells.planes(axis);
            planes[from[axis]] <= low[axis] && high[axis] <= planes[from[axis] + 1]
        });
        if inside {
            return 1 << subcells.bit(x.0, y.0, z.0);
        }
    }

    let xy = shadow::<0, 1>(corners, subcells, [x, y]);
    let yz = shadow::<1, 2>(corners, subcells, [y, z]);
    let zx = shadow::<2, 0>(corners, subcells, [z, x]);

    // The triangle's plane, as an axis.
    let normal = area_normal(corners);
    let along = corners.map(|corner| normal.dot(corner));
    let size = normal.x.abs() + normal.y.abs() + normal.z.abs();
    let reach = size * (subcells.half() + ROUNDING);
    let low = along[0].min(along[1]).min(along[2]) - reach;
    let high = along[0].max(along[1]).max(along[2]) + reach;

    let mut mask = 0;
    for k in z.0..z.1 {
        for j in y.0..y.1 {
            if !yz[j][k] {
                continue;
            }
            let base = normal.y * subcells.centres(1)[j] + normal.z * subcells.centres(2)[k];
            for i in x.0..x.1 {
                let at = base + normal.x * subcells.centres(0)[i];
                if xy[i][j] && zx[k][i] && low <= at && at <= high {
                    mask |= 1 << subcells.bit(i, j, k);
                }
            }
        }
    }
    mask
}

/// Which squares of the coordinate plane (U, V) no edge of the triangle's projection
/// separates from it, among those of `range`.
fn shadow<const U: usize, const V: usize>(
    corners: &Corners,
    subcells: &Subcells,
    range: [(usize, usize); 2],
) -> [[bool; RHO]; RHO] {
    let mut meets = [[false; RHO]; RHO];
    let mut axes = [(0.0, 0.0, 0.0, 0.0); 3];
    for (edge, axis) in axes.iter_mut().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|i| corners[(edge + i) % 3]);
        // Across the edge from a to b, on which both lie at the same place.
        let (u, v) = (a[V] - b[V], b[U] - a[U]);
        let [pa, pb, pc] = [a, b, c].map(|p| u * p[U] + v * p[V]);
        let reach = (u.abs() + v.abs()) * (subcells.half() + ROUNDING);
        *axis = (u, v, pa.min(pb).min(pc) - reach, pa.max(pb).max(pc) + reach);
    }
    let centres = |axis, (from, to): (usize, usize)| {
        subcells
            .centres(axis)
            .iter()
            .enumerate()
            .take(to)
            .skip(from)
    };
    for (s, &cu) in centres(U, range[0]) {
        for (t, &cv) in centres(V, range[1]) {
            meets[s][t] = axes.iter().all(|&(u, v, low, high)| {
                let at = u * cu + v * cv;
                low <= at && at <= high
            });
        }
    }
    meets
}

/// The subcells whose central cross the triangle meets; see [`super::Geometry::crosses`].
///
/// Along a row of cells the same line is cut at the same faces, and the plane's sign at a
/// face is the same value for both its cells: where a surface crosses the line, some cell of
/// the row counts.
#[must_use]
pub fn crosses(corners: &Corners, subcells: &Subcells) -> u128 {
    let (low, high) = bounds(corners);
    let Some(range) = subcells.range(low - ROUNDING, high + ROUNDING) else {
        return 0;
    };
    let normal = area_normal(corners);
    crossed_along::<0, 1, 2>(corners, normal, subcells, range)
        | crossed_along::<1, 2, 0>(corners, normal, subcells, range)
        | crossed_along::<2, 0, 1>(corners, normal, subcells, range)
}

/// The subcells whose segment along axis W the triangle meets. (U, V, W) is a rotation of
/// the axes.
fn crossed_along<const U: usize, const V: usize, const W: usize>(
    corners: &Corners,
    normal: DVec3,
    subcells: &Subcells,
    range: [(usize, usize); 3],
) -> u128 {
    let (low, high) = bounds(corners);
    let near = |at: f64, axis: usize| low[axis] - ROUNDING <= at && at <= high[axis] + ROUNDING;
    let on_edge = normal[W].abs() <= ROUNDING;
    let mut mask = 0;
    for s in range[U].0..range[U].1 {
        let u = subcells.centres(U)[s];
        if !near(u, U) {
            continue;
        }
        for t in range[V].0..range[V].1 {
            let v = subcells.centres(V)[t];
            if !near(v, V) {
                continue;
            }
            let mut mark = |w: usize| {
                let mut index = [0; 3];
                (index[U], index[V], index[W]) = (s, t, w);
                mask |= 1 << subcells.bit(index[0], index[1], index[2]);
            };
            let planes = subcells.planes(W);
            if on_edge {
                let Some((from, to)) = cut_edge_on::<U, V, W>(corners, u, v) else {
                    continue;
                };
                for w in range[W].0..range[W].1 {
                    if planes[w] <= to + ROUNDING && from - ROUNDING <= planes[w + 1] {
                        mark(w);
                    }
                }
            } else if holds::<U, V>(corners, normal[W].signum(), u, v) {
                let a = corners[0];
                let base = normal[U] * (u - a[U]) + normal[V] * (v - a[V]);
                let slack = ROUNDING * (normal[U].abs() + normal[V].abs() + normal[W].abs());
                for w in range[W].0..range[W].1 {
                    let from = base + normal[W] * (planes[w] - a[W]);
                    let to = base + normal[W] * (planes[w + 1] - a[W]);
                    if from.min(to) <= slack && from.max(to) >= -slack {
                        mark(w);
                    }
                }
            }
        }
    }
    mask
}

/// Whether (u, v) lies in the triangle's projection, edges included.
fn holds<const U: usize, const V: usize>(corners: &Corners, sign: f64, u: f64, v: f64) -> bool {
    (0..3).all(|edge| {
        let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
        let (du, dv) = (b[U] - a[U], b[V] - a[V]);
        let side = du * (v - a[V]) - dv * (u - a[U]);
        sign * side >= -ROUNDING * (du.abs() + dv.abs())
    })
}

/// Where the line along W through (u, v) runs inside a triangle that is seen edge-on along W.
fn cut_edge_on<const U: usize, const V: usize, const W: usize>(
    corners: &Corners,
    u: f64,
    v: f64,
) -> Option<(f64, f64)> {
    let mut span: Option<(f64, f64)> = None;
    let mut take = |w: f64| {
        let (from, to) = span.unwrap_or((w, w));
        span = Some((from.min(w), to.max(w)));
    };
    for edge in 0..3 {
        let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
        let (du, dv) = (b[U] - a[U], b[V] - a[V]);
        if du.abs().max(dv.abs()) <= ROUNDING {
            if (u - a[U]).abs().max((v - a[V]).abs()) <= 2.0 * ROUNDING {
                take(a[W]);
                take(b[W]);
            }
            continue;
        }
        let at = if du.abs() >= dv.abs() {
            (u - a[U]) / du
        } else {
            (v - a[V]) / dv
        };
        let off = (a[U] + at * du - u).abs().max((a[V] + at * dv - v).abs());
        if (0.0..=1.0).contains(&at) && off <= 2.0 * ROUNDING {
            take(a[W] + at * (b[W] - a[W]));
        }
    }
    span
}

/// The part of the triangle in the box from `low` to `high`: its area and centre of gravity;
/// `None` when it has no area.
#[must_use]
pub fn within(corners: &Corners, low: DVec3, high: DVec3) -> Option<(f64, DVec3)> {
    let (least, most) = bounds(corners);
    if low.cmple(least).all() && most.cmple(high).all() {
        let area = 0.5 * area_normal(corners).length();
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        return (area > 0.0).then_some((area, centre));
    }
    let (mut polygon, mut spare) = (&mut Polygon::new(), &mut Polygon::new());
    corners.iter().for_each(|corner| polygon.push(*corner));
    for axis in 0..3 {
        if least[axis] < low[axis] {
            polygon.cut(spare, |p| p[axis] - low[axis]);
            (polygon, spare) = (spare, polygon);
        }
        if high[axis] < most[axis] {
            polygon.cut(spare, |p| high[axis] - p[axis]);
            (polygon, spare) = (spare, polygon);
        }
    }
    let [first, rest @ ..] = polygon.corners() else {
        return None;
    };
    let normal = area_normal(corners).try_normalize()?;
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for pair in rest.windows(2) {
        let triangle = [*first, pair[0], pair[1]];
        let part = 0.5 * area_normal(&triangle).dot(normal);
        area += part;
        moment += part * (triangle[0] + triangle[1] + triangle[2]);
    }
    (area > 0.0).then(|| (area, moment / (3.0 * area)))
}

/// A convex polygon: a triangle and a corner more for each of six cuts. Rounding may cut one that
/// is next to a line more often; what is then too much is left out with no loss of area.
struct Polygon {
    corners: [DVec3; 12],
    count: usize,
}

impl Polygon {
    fn new() -> Self {
        Self {
            corners: [DVec3::ZERO; 12],
            count: 0,
        }
    }

    fn push(&mut self, corner: DVec3) {
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Puts into `kept` what of it lies where `depth`, an affine function, is not negative.
    fn cut(&self, kept: &mut Self, depth: impl Fn(DVec3) -> f64) {
        kept.count = 0;
        let Some(mut p) = self.corners().last().copied() else {
            return;
        };
        let mut there = depth(p);
        for &q in self.corners() {
            let here = depth(q);
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                kept.push(q + (p - q) * (here / (here - there)));
            }
            if here >= 0.0 {
                kept.push(q);
            }
            (p, there) = (q, here);
        }
    }
}

/// The weights of the corners of a triangle with an area, for a point of its plane.
#[must_use]
pub fn weights(corners: &Corners, point: DVec3) -> [f64; 3] {
    let [a, b, c] = *corners;
    let normal = area_normal(corners);
    let square = normal.length_squared();
    let second = (point - a).cross(c - a).dot(normal) / square;
    let third = (b - a).cross(point - a).dot(normal) / square;
    [1.0 - second - third, second, third]
}

/// The point of the triangle nearest `p`, as the weights of its corners: each 0 to 1, their
/// sum 1.
#[must_use]
pub fn nearest([a, b, c]: &Corners, p: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    // Below an angle of 3e-7 the signs of the regions are noise, and the edges are nearer
    // than that to all of the triangle.
    let area = ab.cross(ac).length_squared();
    if area <= 1e-13 * ab.length_squared() * ac.length_squared() {
        return nearest_on_edges(&[*a, *b, *c], p);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let at = d1 / (d1 - d3);
        return [1.0 - at, at, 0.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let at = d2 / (d2 - d6);
        return [1.0 - at, 0.0, at];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let at = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - at, at];
    }
    let sum = va + vb + vc;
    let (v, w) = (vb / sum, vc / sum);
    [1.0 - v - w, v, w]
}

/// The nearest point of the three edges.
fn nearest_on_edges(corners: &Corners, p: DVec3) -> [f64; 3] {
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for edge in 0..3 {
        let other = (edge + 1) % 3;
        let (a, d) = (corners[edge], corners[other] - corners[edge]);
        let length = d.length_squared();
        let at = if length > 0.0 {
            (d.dot(p - a) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let distance = p.distance_squared(a + at * d);
        if distance < best.0 {
            let mut weights = [0.0; 3];
            weights[edge] = 1.0 - at;
            weights[other] = at;
            best = (distance, weights);
        }
    }
    best.1
}

/// The point with these weights.
#[must_use]
pub fn point(corners: &Corners, weights: [f64; 3]) -> DVec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

#[cfg(test)]
mod tests {
    use glam::DMat3;
    use proptest::prelude::*;

    use super::super::cells::Cell;
    use super::*;

    /// A corner on a lattice of the cube, so that edges, faces and corners of boxes are hit,
    /// or anywhere.
    fn corner() -> impl Strategy<Value = DVec3> {
        let lattice = prop::array::uniform3(0..=12_i32)
            .prop_map(|c| DVec3::from_array(c.map(|x| f64::from(x) / 12.0 - 0.5)));
        let anywhere = prop::array::uniform3(-0.5..=0.5_f64).prop_map(DVec3::from_array);
        prop_oneof![lattice, anywhere]
    }

    fn any_triangle() -> impl Strategy<Value = Corners> {
        prop_oneof![
            8 => prop::array::uniform3(corner()),
            // A segment, a point, a sliver, a small one.
            1 => (corner(), corner(), 0.0..=1.0_f64).prop_map(|(a, b, t)| [a, b, a + (b - a) * t]),
            1 => corner().prop_map(|a| [a, a, a]),
            1 => (corner(), corner()).prop_map(|(a, b)| [a, b, b]),
            2 => (corner(), corner(), corner(), 1e-9..1e-2_f64)
                .prop_map(|(a, b, c, t)| [a, b, a + (c - a) * t]),
            2 => (corner(), corner(), corner(), 1e-4..0.3_f64)
                .prop_map(|(a, b, c, t)| [a, a + (b - a) * t, a + (c - a) * t]),
        ]
    }

    fn any_cell() -> impl Strategy<Value = (Cell, u8)> {
        (prop::sample::select(vec![1_u32, 2, 3, 4, 9]), 1..=5_u8).prop_flat_map(|(n, rho)| {
            prop::array::uniform3(0..n).prop_map(move |index| (Cell { per_axis: n, index }, rho))
        })
    }

    /// The triangle cut by the six half spaces of a box that is larger by `margin`.
    fn polygon(corners: &Corners, low: DVec3, high: DVec3, margin: f64) -> Vec<DVec3> {
        let mut polygon = corners.to_vec();
        for axis in 0..3 {
            for (sign, plane) in [(1.0, low[axis] - margin), (-1.0, -high[axis] - margin)] {
                let depth = |p: DVec3| sign * p[axis] - plane;
                let mut kept = Vec::new();
                for (i, &p) in polygon.iter().enumerate() {
                    let q = polygon[(i + 1) % polygon.len()];
                    if depth(p) >= 0.0 {
                        kept.push(p);
                    }
                    if (depth(p) >= 0.0) != (depth(q) >= 0.0) {
                        kept.push(p + (q - p) * (depth(p) / (depth(p) - depth(q))));
                    }
                }
                polygon = kept;
            }
        }
        polygon
    }

    /// The naive twin of `meets`.
    fn polygon_in_box(corners: &Corners, low: DVec3, high: DVec3, margin: f64) -> bool {
        !polygon(corners, low, high, margin).is_empty()
    }

    /// The naive twin of `crosses`: whether the segment passes through the triangle's inside,
    /// by solving for both; not on an edge, nor by an end.
    fn pierces(corners: &Corners, from: DVec3, to: DVec3) -> bool {
        let [a, b, c] = *corners;
        let system = DMat3::from_cols(from - to, b - a, c - a);
        if system.determinant().abs() < 1e-9 {
            return false;
        }
        let [t, v, w] = (system.inverse() * (from - a)).to_array();
        let inside = 1e-6..=1.0 - 1e-6;
        [t, v, w, 1.0 - v - w].iter().all(|x| inside.contains(x))
    }

    fn boxes(cell: &Cell, rho: u8) -> impl Iterator<Item = (u32, Cell)> {
        let (cell, n) = (*cell, u32::from(rho).pow(3));
        (0..n).map(move |bit| (bit, cell.child(rho, bit)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn a_triangle_meets_the_boxes_in_which_clipping_leaves_something(
            corners in any_triangle(), (cell, rho) in any_cell()
        ) {
            let mask = meets(&corners, &Subcells::of(&cell, rho));
            for (bit, child) in boxes(&cell, rho) {
                let (low, high) = child.corners();
                let met = mask >> bit & 1 == 1;
                // A hair's breadth either way belongs to neither.
                prop_assert!(met || !polygon_in_box(&corners, low, high, -1e-11), "missed {child:?}");
                prop_assert!(!met || polygon_in_box(&corners, low, high, 1e-11), "beside {child:?}");
            }
        }

        #[test]
        fn a_triangle_crosses_the_segments_that_pierce_or_touch_it(
            corners in any_triangle(), (cell, rho) in any_cell()
        ) {
            let subcells = Subcells::of(&cell, rho);
            let mask = crosses(&corners, &subcells);
            for (bit, child) in boxes(&cell, rho) {
                let (low, high) = child.corners();
                let centre = child.centre();
                let segments = [0, 1, 2].map(|axis| {
                    let (mut from, mut to) = (centre, centre);
                    (from[axis], to[axis]) = (low[axis], high[axis]);
                    (from, to)
                });
                let crossed = mask >> bit & 1 == 1;
                let pierced = segments.iter().any(|&(from, to)| pierces(&corners, from, to));
                prop_assert!(crossed || !pierced, "missed {child:?}");
                let touched = segments.iter().any(|&(from, to)| polygon_in_box(&corners, from, to, 1e-9));
                prop_assert!(!crossed || touched, "beside {child:?}");
            }
        }

        #[test]
        fn the_parts_of_a_triangle_in_boxes_are_those_that_clipping_leaves(
            corners in any_triangle(), (cell, rho) in any_cell()
        ) {
            let mut sum = 0.0;
            for (_, child) in boxes(&cell, rho) {
                let (low, high) = child.corners();
                let (area, centre) = within(&corners, low, high).unwrap_or((0.0, DVec3::ZERO));
                let clipped = polygon(&corners, low, high, 0.0);
                let mut doubled = DVec3::ZERO;
                for (i, p) in clipped.iter().enumerate() {
                    doubled += p.cross(clipped[(i + 1) % clipped.len()]);
                }
                prop_assert!((area - 0.5 * doubled.length()).abs() < 1e-9);
                if area > 1e-6 {
                    prop_assert!(low.cmple(centre + 1e-9).all() && (centre - 1e-9).cmple(high).all());
                    let again = point(&corners, weights(&corners, centre));
                    prop_assert!(again.distance(centre) < 1e-9);
                }
                sum += area;
            }
            // In the whole cube nothing is lost.
            if cell.per_axis == 1 {
                // But what lies in a face between boxes belongs to both.
                let whole = 0.5 * area_normal(&corners).length();
                prop_assert!(sum >= whole - 1e-9, "{sum} {whole}");
            }
        }

        #[test]
        fn no_point_of_a_triangle_is_nearer_than_the_nearest(
            corners in any_triangle(), p in corner()
        ) {
            let weights = nearest(&corners, p);
            prop_assert!(weights.iter().all(|w| (-1e-12..=1.0 + 1e-12).contains(w)), "{weights:?}");
            prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let distance = p.distance(point(&corners, weights));
            const STEPS: u32 = 40;
            for i in 0..=STEPS {
                for j in 0..=STEPS - i {
                    let (u, v) = (f64::from(i) / f64::from(STEPS), f64::from(j) / f64::from(STEPS));
                    let other = p.distance(point(&corners, [u, v, 1.0 - u - v]));
                    prop_assert!(distance <= other + 1e-6, "{distance} {other}");
                }
            }
        }

        #[test]
        fn the_nearest_point_is_where_the_distance_stands_still(
            corners in any_triangle(), p in corner()
        ) {
            // Towards no corner does the distance fall: enough, for a triangle is convex.
            let q = point(&corners, nearest(&corners, p));
            for corner in corners {
                prop_assert!((p - q).dot(corner - q) <= 1e-6, "{q} towards {corner}");
            }
        }
    }

    #[test]
    fn a_triangle_in_a_face_belongs_to_both_cells() {
        let at = |y: f64, z: f64| DVec3::new(0.0, y, z);
        let corners = [at(-0.4, -0.4), at(-0.3, -0.4), at(-0.4, -0.3)];
        assert_eq!(meets(&corners, &Subcells::of(&Cell::ROOT, 2)), 0b11);
    }

    #[test]
    fn a_plane_through_the_cube_leaves_no_column_uncrossed() {
        // Two triangles that share a slanted edge: along each axis' columns over their
        // projection some cell must count, also where the column hits the shared edge.
        let [a, b, c, d] = [
            DVec3::new(-0.5, -0.31, -0.5),
            DVec3::new(0.5, -0.11, -0.5),
            DVec3::new(0.5, 0.33, 0.5),
            DVec3::new(-0.5, 0.13, 0.5),
        ];
        let cell = Cell::ROOT;
        let subcells = Subcells::of(&cell, 5);
        let mask = crosses(&[a, b, c], &subcells) | crosses(&[a, c, d], &subcells);
        for i in 0..5 {
            for k in 0..5 {
                let column = (0..5).filter(|&j| mask >> subcells.bit(i, j, k) & 1 == 1);
                assert!(column.count() >= 1, "column {i}, {k}");
            }
        }
    }
}
