//! A line with a thickness as triangles: trunks, branches, twigs.

use glam::DVec3;

use super::dice::turned;
use crate::mesh::Mesh;

/// A place on the line and the thickness there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    pub(super) place: DVec3,
    pub(super) radius: f64,
}

/// Adds a tube round the joints with so many sides, closed at both ends: by a lid at the first
/// joint and a point at the last.
pub(super) fn tube(mesh: &mut Mesh, joints: &[Joint], sides: u32, colour: [u8; 3]) {
    let [first, .., last] = joints else {
        return;
    };
    let along = |i: usize| {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(joints.len() - 1));
        (joints[after].place - joints[before].place).normalize_or(DVec3::Y)
    };
    let mut vertex = |place: DVec3, normal: DVec3| {
        mesh.positions.push(place);
        mesh.normals.push(normal);
        mesh.colours.push(colour);
        mesh.positions.len() as u32 - 1
    };
    // Carried along from ring to ring, so that the sides do not wind.
    let mut across = along(0).any_orthonormal_vector();
    let mut rings = Vec::with_capacity(joints.len());
    for (i, joint) in joints.iter().enumerate().take(joints.len() - 1) {
        let tangent = along(i);
        across = across
            .reject_from_normalized(tangent)
            .try_normalize()
            .unwrap_or_else(|| tangent.any_orthonormal_vector());
        let ring: Vec<u32> = (0..sides)
            .map(|side| {
                let angle = f64::from(side) / f64::from(sides) * std::f64::consts::TAU;
                let normal = turned(across, tangent, angle);
                vertex(joint.place + joint.radius * normal, normal)
            })
            .collect();
        rings.push(ring);
    }
    let lid = vertex(first.place, -along(0));
    let tip = vertex(last.place, along(joints.len() - 1));
    let next = |side: u32| ((side + 1) % sides) as usize;
    for pair in rings.windows(2) {
        for side in 0..sides {
            let (s, t) = (side as usize, next(side));
            let (a, b, c, d) = (pair[0][s], pair[0][t], pair[1][s], pair[1][t]);
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    for side in 0..sides {
        let (s, t) = (side as usize, next(side));
        let (bottom, top) = (&rings[0], &rings[rings.len() - 1]);
        mesh.triangles.push([lid, bottom[t], bottom[s]]);
        mesh.triangles.push([top[s], top[t], tip]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::triangle;
    use super::*;

    #[test]
    fn a_tube_is_closed_and_holds_what_it_should() {
        let joint = |x: f64, y: f64, radius: f64| Joint {
            place: DVec3::new(x, y, 0.0),
            radius,
        };
        let mut mesh = Mesh::default();
        let joints = [
            joint(0.0, 0.0, 0.1),
            joint(0.0, 1.0, 0.1),
            joint(0.0, 2.0, 0.1),
            joint(0.0, 2.3, 0.0),
        ];
        tube(&mut mesh, &joints, 48, [7; 3]);
        let mut volume = 0.0;
        let mut edges = std::collections::BTreeMap::new();
        for triangle in &mesh.triangles {
            let corners = triangle.map(|v| mesh.positions[v as usize]);
            volume += triangle::area_normal(&corners).dot(corners[0]) / 6.0;
            for i in 0..3 {
                let edge = (triangle[i], triangle[(i + 1) % 3]);
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        assert!(edges.keys().all(|(a, b)| edges.get(&(*b, *a)) == Some(&1)));
        let expected = std::f64::consts::PI * 0.01 * (2.0 + 0.1);
        assert!((volume / expected - 1.0).abs() < 0.01, "{volume}");
        assert_eq!(mesh.colours.len(), mesh.positions.len());
    }

    #[test]
    fn fewer_than_two_joints_are_nothing() {
        let mut mesh = Mesh::default();
        tube(&mut mesh, &[], 3, [0; 3]);
        assert_eq!(mesh, Mesh::default());
    }
}
