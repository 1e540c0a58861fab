//! A triangle mesh in cube units.

use glam::DVec3;

/// Triangles with normals and perhaps colours.
///
/// Positions are in *cube units*: the bounding cube of all vertices (also of those in no
/// face) is centred at the origin and its side is 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// One a vertex.
    pub positions: Vec<DVec3>,
    /// One a vertex, of length 1: the file's, else area-weighted over the faces round it.
    pub normals: Vec<DVec3>,
    /// One a vertex, sRGB as in the file, or empty.
    pub colours: Vec<[u8; 3]>,
    /// Three vertices each, counter-clockwise from outside; every index is valid.
    pub triangles: Vec<[u32; 3]>,
}
