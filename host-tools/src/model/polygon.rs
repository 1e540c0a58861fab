//! Faces of any number of corners, cut into triangles.

use glam::{DVec2, DVec3};

/// Faces as the file has them: the corners of all, one after the other.
#[derive(Debug, Default)]
pub(super) struct Faces {
    corners: Vec<u32>,
    ends: Vec<u32>,
}

/// What cutting gave.
#[derive(Debug, Default)]
pub(super) struct Cut {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Faces that cross themselves or fold: cut as a fan, which may not be what was meant.
    pub(super) odd: usize,
}

impl Faces {
    pub(super) fn with_capacity(faces: usize) -> Self {
        Self {
            corners: Vec::with_capacity(3 * faces),
            ends: Vec::with_capacity(faces),
        }
    }

    /// Adds a corner to the face that is being read.
    pub(super) fn corner(&mut self, vertex: u32) {
        self.corners.push(vertex);
    }

    /// Ends a face; `None` when it has fewer than three corners or there are 2^32 in all.
    pub(super) fn end(&mut self) -> Option<()> {
        let start = self.ends.last().copied().unwrap_or(0);
        let end = u32::try_from(self.corners.len()).ok()?;
        (end - start >= 3).then(|| self.ends.push(end))
    }

    /// Faces so far.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Corners of the face that is being read.
    pub(super) fn open_corners(&self) -> usize {
        self.corners.len() - self.ends.last().map_or(0, |&end| end as usize)
    }

    /// The corners of all faces that ended, one after the other.
    pub(super) fn corners_mut(&mut self) -> &mut [u32] {
        &mut self.corners
    }

    /// Cuts all faces. Convex ones become fans; concave ones that do not cross themselves are
    /// cut by clipping ears.
    ///
    /// Every corner must be an index into `positions`.
    pub(super) fn cut(&self, positions: &[DVec3]) -> Cut {
        let mut cut = Cut {
            triangles: Vec::with_capacity(self.corners.len() - 2 * self.ends.len()),
            odd: 0,
        };
        let mut start = 0;
        for &end in &self.ends {
            let face = &self.corners[start..end as usize];
            start = end as usize;
            if let &[a, b, c] = face {
                cut.triangles.push([a, b, c]);
            } else {
                polygon(face, positions, &mut cut);
            }
        }
        cut
    }
}

/// Beyond this many corners, a concave face is cut as a fan: clipping takes cubic time.
const MAX_CLIPPED: usize = 1024;

fn polygon(face: &[u32], positions: &[DVec3], cut: &mut Cut) {
    let flat = flatten(face, positions);
    if !convex(&flat) {
        if face.len() <= MAX_CLIPPED
            && !crosses_itself(&flat)
            && let Some(ears) = clip(&flat)
        {
            cut.triangles.extend(ears.map(|ear| ear.map(|i| face[i])));
            return;
        }
        cut.odd += 1;
    }
    let fan = face.windows(2).skip(1).map(|w| [face[0], w[0], w[1]]);
    cut.triangles.extend(fan);
}

/// The face seen along the axis nearest its normal, counter-clockwise.
fn flatten(face: &[u32], positions: &[DVec3]) -> Vec<DVec2> {
    let corner = |i: usize| positions[face[i % face.len()] as usize];
    // Twice the area vector (Newell): right for concave and slightly bent faces too. Taken
    // about the first corner so that a face far from the origin loses nothing.
    let origin = corner(0);
    let normal: DVec3 = (0..face.len())
        .map(|i| (corner(i) - origin).cross(corner(i + 1) - origin))
        .sum();
    let size = normal.abs();
    let project = |p: DVec3| {
        if size.z >= size.x && size.z >= size.y {
            DVec2::new(p.x * normal.z.signum(), p.y)
        } else if size.x >= size.y {
            DVec2::new(p.y * normal.x.signum(), p.z)
        } else {
            DVec2::new(p.z * normal.y.signum(), p.x)
        }
    };
    (0..face.len())
        .map(|i| project(corner(i) - origin))
        .collect()
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - b)
}

/// No corner turns right, and the outline goes round once.
fn convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let at = |i: usize| flat[i % n];
    // An outline that goes round once changes between leftward and rightward twice.
    let mut changes = 0;
    let directions = (0..n).map(|i| at(i + 1).x - at(i).x).filter(|&d| d != 0.0);
    let mut last = None;
    let mut first = None;
    for right in directions.map(|d| d > 0.0) {
        changes += u32::from(last.is_some_and(|last| last != right));
        first = first.or(Some(right));
        last = Some(right);
    }
    changes += u32::from(first != last);
    changes <= 2 && (0..n).all(|i| turn(at(i), at(i + 1), at(i + 2)) >= 0.0)
}

/// Whether two edges cross between their ends.
fn crosses_itself(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let edge = |i: usize| (flat[i], flat[(i + 1) % n]);
    let apart =
        |(a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)| turn(a, b, c) * turn(a, b, d) < 0.0;
    (0..n).any(|i| (0..i).any(|j| apart(edge(i), edge(j)) && apart(edge(j), edge(i))))
}

/// Clips ears until a triangle is left; `None` when there is no ear, so the outline crosses
/// itself.
fn clip(flat: &[DVec2]) -> Option<impl Iterator<Item = [usize; 3]> + use<>> {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut ears = Vec::with_capacity(flat.len() - 2);
    while left.len() > 3 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let turn_at = |i: usize| {
            let [a, b, c] = corner(i);
            turn(flat[a], flat[b], flat[c])
        };
        let ear = (0..n).find(|&i| {
            let [a, b, c] = corner(i);
            turn_at(i) > 0.0
                && left
                    .iter()
                    .filter(|&&p| p != a && p != b && p != c)
                    .all(|&p| !inside(flat[p], [flat[a], flat[b], flat[c]]))
        });
        // A corner on a straight edge gives a triangle without area, dropped later.
        let ear = ear.or_else(|| (0..n).find(|&i| turn_at(i) == 0.0))?;
        ears.push([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
    }
    ears.push([left[0], left[1], left[2]]);
    Some(ears.into_iter())
}

/// Inside or on the border, but not on a corner: an outline may touch itself there.
fn inside(p: DVec2, [a, b, c]: [DVec2; 3]) -> bool {
    p != a
        && p != b
        && p != c
        && [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(from, to)| (to - from).perp_dot(p - from) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(outline: &[[f64; 3]]) -> (Cut, Vec<DVec3>) {
        let positions: Vec<DVec3> = outline.iter().copied().map(DVec3::from).collect();
        let mut faces = Faces::default();
        for i in 0..positions.len() {
            faces.corner(u32::try_from(i).unwrap());
        }
        faces.end().unwrap();
        (faces.cut(&positions), positions)
    }

    /// The areas along +z: all positive, and their sum that of the outline.
    fn areas(cut: &Cut, positions: &[DVec3]) -> Vec<f64> {
        cut.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| positions[i as usize]);
                (b - a).cross(c - a).z / 2.0
            })
            .collect()
    }

    #[test]
    fn a_square_becomes_a_fan() {
        let (cut, _) = cut(&[[0., 0., 5.], [1., 0., 5.], [1., 1., 5.], [0., 1., 5.]]);
        assert_eq!(cut.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut.odd, 0);
    }

    #[test]
    fn a_concave_face_is_covered_once_whichever_corner_comes_first() {
        let arrow = [[0., 0., 0.], [4., 0., 0.], [4., 4., 0.], [3., 1., 0.]];
        let comb = [
            [0., 0., 0.],
            [5., 0., 0.],
            [5., 3., 0.],
            [4., 1., 0.],
            [3., 3., 0.],
            [2., 1., 0.],
            [1., 3., 0.],
        ];
        for outline in [&arrow[..], &comb] {
            let whole: f64 = (0..outline.len())
                .map(|i| {
                    let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
                    (a[0] * b[1] - a[1] * b[0]) / 2.0
                })
                .sum();
            for start in 0..outline.len() {
                let mut turned = outline.to_vec();
                turned.rotate_left(start);
                let (cut, positions) = cut(&turned);
                let areas = areas(&cut, &positions);
                assert_eq!(cut.odd, 0);
                assert_eq!(areas.len(), outline.len() - 2);
                assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
                assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_side_that_a_concave_face_shows_is_kept() {
        // Clockwise from +z, so it faces -z.
        let (cut, positions) = cut(&[[3., 1., 0.], [4., 4., 0.], [4., 0., 0.], [0., 0., 0.]]);
        assert!(areas(&cut, &positions).iter().all(|&a| a < 0.0));
    }

    #[test]
    fn a_face_that_crosses_itself_is_counted() {
        let star: Vec<[f64; 3]> = (0..5)
            .map(|i| {
                let angle = f64::from(i) * 0.8 * std::f64::consts::PI;
                [angle.cos(), angle.sin(), 0.0]
            })
            .collect();
        let (cut, _) = cut(&star);
        assert_eq!((cut.odd, cut.triangles.len()), (1, 3));
    }

    #[test]
    fn a_face_of_two_corners_does_not_end() {
        let mut faces = Faces::default();
        faces.corner(0);
        faces.corner(1);
        assert_eq!(faces.end(), None);
    }
}
