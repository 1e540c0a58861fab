//! The tree that sampling makes, and what it is made to.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::Vec3;

use crate::failure::{Failure, Outcome};
use crate::geometry::Rim;
use crate::geometry::cells::MAX_RHO;

/// The most cells an axis that a tree may have.
pub const MAX_CELLS: u32 = 4096;

/// Which cells count as leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Separation {
    /// Every cell that the surface meets, faces included (26-separating; the paper's).
    #[default]
    TwentySix,
    /// Cells whose central cross, three segments from face to face, the surface meets
    /// (6-separating, "thin"; Huang, Yagel, Filippov & Kurzion 1998): some 40 % fewer.
    Six,
}

/// How often each level cuts its cells, from the root down.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequence(Vec<u8>);

impl Sequence {
    /// From the root's subdivision to that of the leaves' parents.
    ///
    /// # Errors
    /// When it is empty, when a subdivision is not 2 to 5, or when there would be more than
    /// [`MAX_CELLS`] cells an axis.
    pub fn new(subdivisions: &[u8]) -> Outcome<Self> {
        let fail = |message: String| {
            Err(Failure::input(message).help(format!(
                "give one subdivision a level, each 2 to {MAX_RHO}, with a product of at most \
                 {MAX_CELLS}, such as 3,3,3,3,3 or 2,3,3,3,3"
            )))
        };
        if subdivisions.is_empty() {
            return fail("no subdivision is given".to_owned());
        }
        let mut cells = 1_u32;
        for &rho in subdivisions {
            if !(2..=MAX_RHO).contains(&rho) {
                return fail(format!("a cell cannot be subdivided by {rho}"));
            }
            cells *= u32::from(rho);
            if cells > MAX_CELLS {
                return fail(format!(
                    "the subdivisions make more than {MAX_CELLS} cells an axis"
                ));
            }
        }
        Ok(Self(subdivisions.to_vec()))
    }

    /// One a level, each 2 to 5.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        &self.0
    }

    /// Leaf cells along an axis: the product.
    #[must_use]
    pub fn cells(&self) -> u32 {
        self.0.iter().copied().map(u32::from).product()
    }
}

impl fmt::Display for Sequence {
    /// `2,3,3,3,3`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (level, rho) in self.0.iter().enumerate() {
            let comma = if level == 0 { "" } else { "," };
            write!(f, "{comma}{rho}")?;
        }
        Ok(())
    }
}

impl FromStr for Sequence {
    type Err = Failure;
    /// `2,3,3,3,3`
    fn from_str(text: &str) -> Outcome<Self> {
        let numbers: Result<Vec<u8>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        let numbers = numbers.map_err(|_| {
            Failure::input(format!("\"{text}\" is not a list of subdivisions"))
                .help("write numbers from 2 to 5 with commas between them, such as 2,3,3,3,3")
        })?;
        Self::new(&numbers)
    }
}

/// What a grid keeps of the surface in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeSample {
    /// Of length 1: the mean of the surface round the cell.
    pub normal: Vec3,
    /// From the cell's centre along `normal` to the plane through that surface's centre of
    /// gravity, in sides of the cell; not clamped (a leaf's is within 0.87 where the surface is
    /// flat).
    pub offset: f32,
    /// sRGB, that of the largest piece in the cell.
    pub colour: [u8; 3],
    /// sRGB, the mean of the surface round the cell.
    pub mean: [u8; 3],
    /// Some of the surface in the cell faces the other way: both sides of it may be seen.
    pub two_sided: bool,
    /// Baked shadows: something lies between it and the light.
    pub shaded: bool,
}

/// One level of a [`Tree`], breadth first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TreeLevel {
    /// One a node; none at all above [`Tree::first_sampled`].
    pub samples: Vec<TreeSample>,
    /// One a node: bit i + rho j + rho^2 k says that subcell (x = i, y = j, z = k) exists.
    /// Empty at the leaves.
    pub masks: Vec<u128>,
}

impl TreeLevel {
    /// How many nodes there are.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.samples.len().max(self.masks.len())
    }
}

/// A hierarchy of samples. A level holds the children of the first node of the level above
/// in the order of their bits, then those of the second: the place of a node's first child
/// is the number of bits set in the masks before its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// How often each level's cells are cut, from the root down.
    pub sequence: Vec<u8>,
    /// Which cells are leaves.
    pub separation: Separation,
    /// Places along the surface's edges; `None` when they are not known, as after sampling.
    pub rims: Option<Arc<[Rim]>>,
    /// One more than `sequence` has: first the root alone, last the leaves.
    pub levels: Vec<TreeLevel>,
}

impl Tree {
    /// Cells of the finest level.
    #[must_use]
    pub fn leaves(&self) -> usize {
        self.levels.last().map_or(0, |level| level.samples.len())
    }

    /// Cells of all levels, the root and the leaves among them.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.levels.iter().map(TreeLevel::nodes).sum()
    }

    /// The level from which on nodes have samples.
    #[must_use]
    pub fn first_sampled(&self) -> usize {
        let sampled = |level: &TreeLevel| !level.samples.is_empty();
        self.levels.iter().position(sampled).unwrap_or(0)
    }

    /// Leaves the samples of the leaves alone.
    pub fn drop_intermediate_samples(&mut self) {
        if let [inner @ .., _] = &mut self.levels[..] {
            for level in inner {
                level.samples.clear();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_counts_its_cells_and_reads_as_it_is_written() {
        let sequence: Sequence = "2, 3,3,3,3".parse().unwrap();
        assert_eq!(sequence.cells(), 162);
        assert_eq!(sequence.to_string(), "2,3,3,3,3");
        assert_eq!(Sequence::new(&[2; 12]).unwrap().cells(), MAX_CELLS);
    }

    #[test]
    fn a_sequence_out_of_range_says_what_is_wrong() {
        let message = |text: &str| text.parse::<Sequence>().unwrap_err().message;
        assert!(message("").contains("not a list"));
        assert!(message("3,,3").contains("not a list"));
        assert!(message("3,x").contains("3,x"));
        assert!(message("3,1").contains("subdivided by 1"));
        assert!(message("6").contains("subdivided by 6"));
        assert!(message("4,4,4,4,4,4,2").contains("4096"));
        assert!(Sequence::new(&[]).unwrap_err().help.is_some());
        assert!(Sequence::new(&[5; 255]).is_err(), "without overflow");
    }
}
