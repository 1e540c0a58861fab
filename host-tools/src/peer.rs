//! Models as the programs that rho-grid is compared with take them; see the package `rho-peers`.
//!
//! Words, little-endian: a magic number, how many of each thing follow, and the things.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::quantise::normal_index;

/// The vertices that triangles use, for `flat-points`: a point is x, y and z as 16-bit numbers in
/// 2^-16 of the cube's side, then the 13-bit index of its normal.
#[must_use]
pub fn points(mesh: &Mesh) -> Vec<u8> {
    let mut used = vec![false; mesh.positions.len()];
    for vertex in mesh.triangles.iter().flatten() {
        used[*vertex as usize] = true;
    }
    let mut bytes = Vec::new();
    let vertices = mesh.positions.iter().zip(&mesh.normals);
    for ((position, normal), _) in vertices.zip(used).filter(|(_, used)| *used) {
        for coordinate in position.to_array() {
            // The cube's farther faces are one step beyond the range.
            let steps = (coordinate * 65536.0).round().min(32767.0) as i16;
            bytes.extend(steps.to_le_bytes());
        }
        bytes.extend((normal_index(*normal) as u16).to_le_bytes());
    }
    let count = (bytes.len() / 8) as u32;
    with_header(b"FLAT", &[count], &bytes)
}

/// Vertices and triangles, for `triangles`: three 32-bit floats a vertex, three indices a
/// triangle, then three floats a triangle, its unit normal.
#[must_use]
pub fn triangles(mesh: &Mesh) -> Vec<u8> {
    let corner = |index: u32| mesh.positions[index as usize];
    let with_normals: Vec<([u32; 3], DVec3)> = mesh
        .triangles
        .iter()
        .filter_map(|&triangle| {
            let [a, b, c] = triangle.map(corner);
            Some((triangle, (b - a).cross(c - a).try_normalize()?))
        })
        .collect();
    let mut bytes = Vec::new();
    let float = |bytes: &mut Vec<u8>, v: DVec3| {
        bytes.extend(v.as_vec3().to_array().iter().flat_map(|c| c.to_le_bytes()));
    };
    for position in &mesh.positions {
        float(&mut bytes, *position);
    }
    for (triangle, _) in &with_normals {
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    for (_, normal) in &with_normals {
        float(&mut bytes, *normal);
    }
    let counts = [mesh.positions.len(), with_normals.len()].map(|n| n as u32);
    with_header(b"MESH", &counts, &bytes)
}

fn with_header(magic: &[u8; 4], counts: &[u32], rest: &[u8]) -> Vec<u8> {
    let mut bytes = magic.to_vec();
    bytes.extend(counts.iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(rest);
    bytes
}

/// The mesh with at most so many triangles, or as few as its topology allows, by quadric error
/// (Garland and Heckbert 1997, as in meshoptimizer); normals of its vertices are those they had.
#[must_use]
pub fn decimated(mesh: &Mesh, triangles: usize) -> Mesh {
    let indices = mesh.triangles.as_flattened();
    let positions: Vec<[f32; 3]> = mesh
        .positions
        .iter()
        .map(|p| p.as_vec3().to_array())
        .collect();
    let mut kept = vec![0; indices.len()];
    let wanted = (3 * triangles).min(indices.len());
    let count = meshopt_rs::simplify::simplify(&mut kept, indices, &positions, wanted, 1.0);
    kept.truncate(count);
    // The vertices that are left, in the order in which triangles name them.
    let mut renamed = vec![None; positions.len()];
    let mut small = Mesh::default();
    for index in &mut kept {
        let old = *index as usize;
        *index = *renamed[old].get_or_insert_with(|| {
            small.positions.push(mesh.positions[old]);
            small.normals.push(mesh.normals[old]);
            small.positions.len() as u32 - 1
        });
    }
    small.triangles = kept.as_chunks().0.to_vec();
    small
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of 2 x 24 x 12 triangles.
    fn sphere() -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..=12 {
            for j in 0..24 {
                let (a, b) = (
                    f64::from(i).to_radians() * 15.0,
                    f64::from(j).to_radians() * 15.0,
                );
                let n = DVec3::new(a.sin() * b.cos(), a.cos(), a.sin() * b.sin());
                mesh.positions.push(n / 2.0);
                mesh.normals.push(n);
            }
        }
        for i in 0..12 {
            for j in 0..24 {
                let at = |i: u32, j: u32| 24 * i + j % 24;
                let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
                mesh.triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
        mesh
    }

    #[test]
    fn points_are_the_vertices_in_use_two_words_each() {
        let mut mesh = sphere();
        mesh.positions.push(DVec3::ZERO);
        mesh.normals.push(DVec3::X);
        let bytes = points(&mesh);
        let used = mesh.positions.len() - 1;
        assert_eq!(bytes[..4], *b"FLAT");
        assert_eq!(bytes[4..8], (used as u32).to_le_bytes());
        assert_eq!(bytes.len(), 8 + 8 * used);
        // The pole: x = 0, y = half a side, which is cut by a step, z = 0.
        assert_eq!(bytes[8..14], [0, 0, 0xFF, 0x7F, 0, 0]);
    }

    #[test]
    fn triangles_without_area_are_left_out() {
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            normals: vec![DVec3::Z; 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let bytes = triangles(&mesh);
        assert_eq!(bytes[..4], *b"MESH");
        assert_eq!(bytes[4..12], [3, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(bytes.len(), 12 + 3 * 12 + 12 + 12);
        // Its normal comes last: +z.
        assert_eq!(bytes[bytes.len() - 4..], 1.0_f32.to_le_bytes());
        mesh.triangles.push([1, 1, 2]);
        assert_eq!(triangles(&mesh), bytes);
    }

    #[test]
    fn a_decimated_mesh_keeps_its_shape() {
        let small = decimated(&sphere(), 200);
        assert!(small.triangles.len() <= 200 && small.triangles.len() > 100);
        assert_eq!(small.positions.len(), small.normals.len());
        let last = small.triangles.iter().flatten().max().unwrap();
        assert_eq!(*last as usize + 1, small.positions.len());
        assert!(
            small
                .positions
                .iter()
                .all(|p| (p.length() - 0.5).abs() < 1e-6)
        );
    }
}
