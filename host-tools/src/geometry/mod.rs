//! The two questions that sampling asks of an object, and the objects that answer them.
//!
//! Duguet & Drettakis 2003, section 4.1, sample whatever can answer *IntersectAxisAlignedBox*
//! and *GetSampleAt*. Here an object is a list of primitives (triangles, pieces of Bezier
//! patches), and the first question is asked of one primitive and all subcells of a cell at
//! once, since what the primitive needs to answer (edges, normal) is the same for all:
//!
//! | paper | here |
//! | --- | --- |
//! | IntersectAxisAlignedBox(box) | [`Geometry::meets`], a bit for each of rho^3 boxes |
//! | GetSampleAt(centre, primitive) | [`Geometry::portion`], over the primitives that meet the cell |
//!
//! The paper's sample is one point of the surface; a [`Portion`] sums up all of it in the cell.
//!
//! [`Geometry::crosses`] asks for 6-separating cells (Huang, Yagel, Filippov & Kurzion 1998),
//! which the paper has not.

pub mod cells;
mod contour;
mod dice;
mod field;
mod implicit;
pub mod patch;
pub mod portion;
pub mod procedural;
mod rim;
pub mod shapes;
pub mod sponge;
pub mod teapot;
pub mod terrain;
pub mod tree;
pub mod triangle;
pub mod triangles;
mod tube;

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;

use crate::mesh::Mesh;
use cells::{Cell, Subcells};
use portion::Portion;

/// The colour of a surface that has none of its own.
pub const WHITE: [u8; 3] = [255; 3];

/// A point of a surface and what a grid keeps of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// In cube units.
    pub position: DVec3,
    /// Of length 1, outward; never turned towards anything.
    pub normal: DVec3,
    /// sRGB; [`WHITE`] where the object has no colours.
    pub colour: [u8; 3],
}

/// A place on an edge where a surface ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// In the cube.
    pub at: DVec3,
    /// The area of the opening round which the edge goes, as a vector: towards where backs are seen from.
    pub opens: DVec3,
}

/// An object made of primitives, in cube units: all of it lies in the cube of side 1 centred
/// at the origin (what does not is left out).
pub trait Geometry: Sync {
    /// How many primitives there are; they are numbered from 0.
    fn primitives(&self) -> u32;

    /// The subcells that `primitive` meets, faces included: bit i + rho j + rho^2 k for
    /// subcell (i, j, k).
    ///
    /// A primitive within rounding (some 1e-15) of a subcell may count as meeting it, so that
    /// no part of a surface falls between two cells; one that meets it always counts.
    fn meets(&self, primitive: u32, subcells: &Subcells) -> u128;

    /// The subcells whose *central cross* `primitive` meets: the three segments through the
    /// subcell's centre, parallel to the axes, from face to face, ends included: the
    /// 6-separating voxels of the surface. But for rounding a subset of what
    /// [`Geometry::meets`] answers.
    fn crosses(&self, primitive: u32, subcells: &Subcells) -> u128;

    /// Of the listed primitives, the point nearest `centre`; the first of equals.
    /// `None` when the list is empty.
    fn sample_at(&self, primitives: &[u32], centre: DVec3) -> Option<Sample>;

    /// What of the listed primitives lies in `cell`, which all of them meet; it has an area.
    /// `None` when the list is empty.
    ///
    /// What is not told otherwise is a face's area at the point nearest the cell's centre.
    fn portion(&self, primitives: &[u32], cell: &Cell) -> Option<Portion> {
        let nearest = self.sample_at(primitives, cell.centre())?;
        Some(Portion::at(&nearest, cell, 1.0))
    }

    /// The surface's area in squares of the cube's side, every piece of it times `weight` of
    /// its unit normal (|nx|, |ny|, |nz|). `weight` is of the first degree: of twice the vector
    /// it is twice as much.
    ///
    /// A plane meets |nx| + |ny| + |nz| cells an area of one cell's face, and crosses
    /// max(|nx|, |ny|, |nz|) of them: so the number of leaves is foreseen.
    fn weighted_area(&self, weight: fn(DVec3) -> f64) -> f64;

    /// Places along the edges where the surface ends; `None` when they are not known. Cracks are left
    /// out.
    ///
    /// Of a surface without any no back is seen, and of another none from where no edge is.
    fn rims(&self) -> Option<Arc<[Rim]>> {
        None
    }

    /// The object as triangles, fine enough to serve as the truth that pictures are held
    /// against.
    fn mesh(&self) -> Cow<'_, Mesh>;
}
