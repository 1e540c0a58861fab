//! Trees grown from a grammar: a broad one and a weeping willow, such as Duguet & Drettakis
//! 2003 have in their Arbre and Saule.
//!
//! A stem grows in segments, each turned a little by chance and drawn up or down; along it
//! stand the stems of the next order, at an angle to it and turned by the golden angle from
//! one to the next, as long as the crown's shape lets them be; the last order bears leaves.
//! This is the model of Weber & Penn 1995, *Creation and rendering of realistic trees*, with
//! few of its parameters:
//!
//! | Weber & Penn | here |
//! | --- | --- |
//! | nBranches, nBaseSize | `Order::stems`, `Order::bare` |
//! | nDownAngle | `Order::angle`, at the parent's foot and at its tip |
//! | nLength, ShapeRatio | `Order::length`, `Species::crown` |
//! | nCurve, nCurveV, AttractionUp | `Order::lift`, `Order::wiggle` |
//!
//! A leaf is a rhomb of two triangles. Its normal is bent away from the middle of the crown,
//! so that the crown is lit as a body and not as noise, and its shade tells how deep in the
//! crown it hangs.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Geometry;
use super::dice::{Dice, turned};
use super::procedural::{BadParameter, Parameters, within};
use super::triangles::Triangles;
use super::tube::{Joint, tube};
use crate::colour::Colour;
use crate::mesh::Mesh;

/// What is left of a full turn after the golden section: no stem stands above another.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// What a tree is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tree {
    /// Which of the trees.
    pub seed: u32,
    /// Orders of stems after the trunk.
    pub levels: u32,
    /// Branches at the trunk.
    pub branches: u32,
    /// Leaves on a stem of the last order.
    pub leaves: u32,
    /// Length of a leaf, in heights of the tree.
    pub leaf_size: f64,
    /// Radius of the trunk above its foot, in heights of the tree.
    pub trunk: f64,
    /// Of trunk and branches.
    pub bark: Colour,
    /// Of leaves in the light.
    pub leaf: Colour,
}

impl Tree {
    fn check(&self, species: &Species) -> Result<(), BadParameter> {
        /// Half a gigabyte of mesh.
        const MOST: u32 = 2_000_000;

        within("levels", self.levels, 1..=3)?;
        within("branches", self.branches, 1..=80)?;
        within("leaves", self.leaves, 0..=500)?;
        within("leaf_size", self.leaf_size, 0.001..=0.2)?;
        within("trunk", self.trunk, 0.005..=0.1)?;
        // Of the ranges above, no product overflows.
        let orders = &species.orders[1..self.levels as usize];
        let twigs = self.branches * orders.iter().map(|order| order.stems).product::<u32>();
        let leaves = twigs * self.leaves;
        if leaves > MOST {
            return Err(BadParameter {
                name: "leaves".to_owned(),
                what: format!(
                    "is {}, on {twigs} twigs {leaves} in all, and may be {MOST} in all",
                    self.leaves
                ),
            });
        }
        Ok(())
    }
}

/// A broad tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Broad(pub Tree);

/// A weeping willow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Willow(pub Tree);

impl Default for Broad {
    fn default() -> Self {
        Self(Tree {
            seed: 1,
            levels: 3,
            branches: 34,
            leaves: 34,
            leaf_size: 0.014,
            trunk: 0.026,
            bark: Colour([104, 84, 66]),
            leaf: Colour([116, 160, 58]),
        })
    }
}

impl Default for Willow {
    fn default() -> Self {
        Self(Tree {
            seed: 1,
            levels: 3,
            branches: 14,
            leaves: 110,
            leaf_size: 0.02,
            trunk: 0.036,
            bark: Colour([112, 98, 80]),
            leaf: Colour([160, 182, 86]),
        })
    }
}

impl Parameters for Broad {
    fn check(&self) -> Result<(), BadParameter> {
        self.0.check(&BROAD)
    }

    fn make(&self) -> Box<dyn Geometry> {
        Box::new(Triangles::owning(Growth::new(&self.0, &BROAD).mesh()))
    }
}

impl Parameters for Willow {
    fn check(&self) -> Result<(), BadParameter> {
        self.0.check(&WILLOW)
    }

    fn make(&self) -> Box<dyn Geometry> {
        Box::new(Triangles::owning(Growth::new(&self.0, &WILLOW).mesh()))
    }
}

/// How stems of one order grow.
struct Order {
    /// How many stand on a stem of the order before; of the first order the tree says.
    stems: u32,
    /// What share of the parent has none, from its foot.
    bare: f64,
    /// In lengths of the parent, where the crown is widest.
    length: f64,
    /// Degrees between parent and stem, at the parent's foot and at its tip.
    angle: (f64, f64),
    /// How strongly it is drawn up, or down if negative, over its length.
    lift: f64,
    /// Degrees by which a segment may turn by chance.
    wiggle: f64,
    segments: u32,
    sides: u32,
}

/// How long the first order is along the trunk: from the lowest branch, at 0, to the tip.
type Crown = fn(f64) -> f64;

struct Species {
    crown: Crown,
    /// Degrees by which a segment of the trunk may turn by chance.
    trunk_wiggle: f64,
    orders: [Order; 3],
    /// Width of a leaf in its lengths.
    leaf_width: f64,
    /// How far the leaves turn from the stem, in degrees.
    leaf_angle: f64,
    /// How strongly leaves hang.
    leaf_hang: f64,
}

const BROAD: Species = Species {
    crown: |t| {
        // Fullest at a third of the crown, round above.
        let low = (t / 0.3).min(1.0);
        let high = ((t - 0.3) / 0.7).max(0.0);
        (0.62 + 0.38 * low) * (1.0 - 0.72 * high * high)
    },
    trunk_wiggle: 5.0,
    orders: [
        Order {
            stems: 0,
            bare: 0.24,
            length: 0.62,
            angle: (78.0, 24.0),
            lift: 0.5,
            wiggle: 11.0,
            segments: 10,
            sides: 8,
        },
        Order {
            stems: 16,
            bare: 0.22,
            length: 0.42,
            angle: (58.0, 36.0),
            lift: 0.25,
            wiggle: 14.0,
            segments: 6,
            sides: 5,
        },
        Order {
            stems: 12,
            bare: 0.12,
            length: 0.42,
            angle: (56.0, 38.0),
            lift: -0.1,
            wiggle: 16.0,
            segments: 3,
            sides: 3,
        },
    ],
    leaf_width: 0.62,
    leaf_angle: 52.0,
    leaf_hang: 0.25,
};

const WILLOW: Species = Species {
    crown: |t| 0.85 + 0.15 * t,
    trunk_wiggle: 7.0,
    orders: [
        Order {
            stems: 0,
            bare: 0.5,
            length: 0.75,
            angle: (50.0, 22.0),
            lift: -0.35,
            wiggle: 9.0,
            segments: 10,
            sides: 8,
        },
        Order {
            stems: 12,
            bare: 0.3,
            length: 0.5,
            angle: (52.0, 34.0),
            lift: -0.9,
            wiggle: 9.0,
            segments: 8,
            sides: 5,
        },
        Order {
            stems: 12,
            bare: 0.1,
            length: 2.0,
            angle: (48.0, 40.0),
            lift: -9.0,
            wiggle: 3.5,
            segments: 12,
            sides: 3,
        },
    ],
    leaf_width: 0.2,
    leaf_angle: 28.0,
    leaf_hang: 0.8,
};

/// A leaf before it has a shade.
struct Leaf {
    foot: DVec3,
    /// From foot to tip.
    along: DVec3,
    /// From the middle to the right rim.
    across: DVec3,
}

/// A tree as it grows, in heights of the trunk; its foot is at the origin.
struct Growth<'a> {
    tree: &'a Tree,
    species: &'a Species,
    dice: Dice,
    mesh: Mesh,
    leaves: Vec<Leaf>,
}

impl<'a> Growth<'a> {
    fn new(tree: &'a Tree, species: &'a Species) -> Self {
        Self {
            tree,
            species,
            dice: Dice::new(tree.seed),
            mesh: Mesh::default(),
            leaves: Vec::new(),
        }
    }

    fn mesh(mut self) -> Mesh {
        self.trunk();
        self.unfold();
        centre(&mut self.mesh);
        self.mesh
    }

    fn trunk(&mut self) {
        const SEGMENTS: u32 = 14;
        let joints = self.line(
            DVec3::ZERO,
            DVec3::Y,
            1.0,
            SEGMENTS,
            self.species.trunk_wiggle,
            0.5,
        );
        let radius = self.tree.trunk;
        let joints: Vec<Joint> = joints
            .into_iter()
            .enumerate()
            .map(|(i, place)| {
                let t = i as f64 / f64::from(SEGMENTS);
                // Roots spread in the lowest tenth.
                let foot = (1.0 - 9.0 * t).max(0.0);
                Joint {
                    place,
                    radius: radius * ((1.0 - 0.93 * t) + 0.75 * foot * foot),
                }
            })
            .collect();
        tube(&mut self.mesh, &joints, 18, self.tree.bark.0);
        self.stems(0, &joints, 1.0);
    }

    /// The places of a line that starts at `place` in direction `along`.
    fn line(
        &mut self,
        mut place: DVec3,
        mut along: DVec3,
        length: f64,
        segments: u32,
        wiggle: f64,
        lift: f64,
    ) -> Vec<DVec3> {
        let step = 1.0 / f64::from(segments);
        let mut places = vec![place];
        for _ in 0..segments {
            place += along * length * step;
            places.push(place);
            let chance = self.dice.ball() * wiggle.to_radians();
            along = (along + chance + DVec3::Y * lift * step).normalize_or(along);
        }
        places
    }

    /// The stems of `order` on a parent of this length.
    fn stems(&mut self, order: usize, parent: &[Joint], length: f64) {
        let species = self.species;
        let rule = &species.orders[order];
        let count = if order == 0 {
            self.tree.branches
        } else {
            rule.stems
        };
        let mut turn = self.dice.between(0.0, std::f64::consts::TAU);
        for i in 0..count {
            let t = (f64::from(i) + self.dice.between(0.1, 0.9)) / f64::from(count);
            let at = rule.bare + (1.0 - rule.bare) * t;
            let (foot, along) = point(parent, at);
            turn += GOLDEN_ANGLE + self.dice.about(0.5);
            let angle = rule.angle.0 + (rule.angle.1 - rule.angle.0) * t + self.dice.about(10.0);
            let side = turned(along.any_orthonormal_vector(), along, turn);
            let direction = turned(along, side, angle.to_radians());
            let shape = if order == 0 {
                (species.crown)(t)
            } else {
                1.0 - 0.55 * t
            };
            let own = length * rule.length * shape * self.dice.between(0.8, 1.2);
            let radius = (0.62 * foot.radius).min(0.045 * own);
            self.stem(order, foot.place, direction, own, radius);
        }
    }

    fn stem(&mut self, order: usize, foot: DVec3, along: DVec3, length: f64, radius: f64) {
        let rule = &self.species.orders[order];
        // What hangs ends above the ground.
        let length = if rule.lift < -2.0 {
            length.min(0.9 * foot.y * self.dice.between(0.75, 1.0))
        } else {
            length
        };
        let places = self.line(foot, along, length, rule.segments, rule.wiggle, rule.lift);
        let joints: Vec<Joint> = places
            .into_iter()
            .enumerate()
            .map(|(i, place)| Joint {
                place,
                radius: radius * (1.0 - 0.8 * i as f64 / f64::from(rule.segments)),
            })
            .collect();
        // Twigs are darker than the trunk.
        let bark = self.tree.bark.times(if order == 0 { 1.0 } else { 0.8 });
        tube(&mut self.mesh, &joints, rule.sides, bark.0);
        if order + 1 < self.tree.levels as usize {
            self.stems(order + 1, &joints, length);
        } else {
            self.leaves(&joints);
        }
    }

    fn leaves(&mut self, stem: &[Joint]) {
        let species = self.species;
        let size = self.tree.leaf_size;
        let mut turn = self.dice.between(0.0, std::f64::consts::TAU);
        for i in 0..self.tree.leaves {
            let t = (f64::from(i) + self.dice.unit()) / f64::from(self.tree.leaves);
            let (foot, along) = point(stem, 0.08 + 0.92 * t);
            turn += GOLDEN_ANGLE + self.dice.about(0.6);
            let side = turned(along.any_orthonormal_vector(), along, turn);
            let angle = (species.leaf_angle + self.dice.about(18.0)).to_radians();
            let out = turned(along, side, angle) - DVec3::Y * species.leaf_hang;
            let out = out.normalize_or(along);
            let across = turned(
                out.any_orthonormal_vector(),
                out,
                turn + self.dice.about(1.0),
            );
            let length = size * self.dice.between(0.75, 1.25);
            self.leaves.push(Leaf {
                foot: foot.place,
                along: out * length,
                across: across * 0.5 * length * species.leaf_width,
            });
        }
    }

    /// Gives the leaves their normals and shades.
    fn unfold(&mut self) {
        /// Of a leaf deep in the crown, and so on to one at its rim.
        const SHADES: [f64; 5] = [0.5, 0.66, 0.82, 1.0, 1.18];
        let feet = || self.leaves.iter().map(|leaf| leaf.foot);
        let (Some(low), Some(high)) = (feet().reduce(DVec3::min), feet().reduce(DVec3::max)) else {
            return;
        };
        let (middle, half) = (
            0.5 * (low + high),
            (0.5 * (high - low)).max(DVec3::splat(1e-6)),
        );
        for leaf in &self.leaves {
            // Over the crown's lower part, so that what hangs below is lit from the side.
            let outward = (leaf.foot - middle.with_y(low.y.midpoint(middle.y))) / half;
            let flat = leaf.along.cross(leaf.across).normalize_or(DVec3::Y);
            let flat = if flat.dot(outward) < 0.0 { -flat } else { flat };
            let normal = (outward.normalize_or(DVec3::Y) + 0.55 * flat).normalize_or(DVec3::Y);
            let depth = ((leaf.foot - middle) / half).length() + self.dice.about(0.3);
            let light = depth + 0.25 * (leaf.foot.y - middle.y) / half.y;
            let shade = ((light - 0.3) * SHADES.len() as f64).clamp(0.0, 4.0) as usize;
            let Colour(colour) = self.tree.leaf.times(SHADES[shade]);
            let belly = leaf.foot + 0.45 * leaf.along;
            let first = self.mesh.positions.len() as u32;
            self.mesh.positions.extend([
                leaf.foot,
                belly + leaf.across,
                leaf.foot + leaf.along,
                belly - leaf.across,
            ]);
            self.mesh.normals.extend([normal; 4]);
            self.mesh.colours.extend([colour; 4]);
            let rhomb = [[0, 1, 2], [0, 2, 3]];
            self.mesh
                .triangles
                .extend(rhomb.map(|t| t.map(|corner| first + corner)));
        }
    }
}

/// The joint at a share of a stem's length, and its direction there.
fn point(stem: &[Joint], share: f64) -> (Joint, DVec3) {
    let segments = stem.len() - 1;
    let at = share.clamp(0.0, 1.0) * segments as f64;
    let i = (at as usize).min(segments - 1);
    let (a, b) = (stem[i], stem[i + 1]);
    let within = at - i as f64;
    let joint = Joint {
        place: a.place.lerp(b.place, within),
        radius: a.radius + (b.radius - a.radius) * within,
    };
    (joint, (b.place - a.place).normalize_or(DVec3::Y))
}

/// Into cube units.
fn centre(mesh: &mut Mesh) {
    let places = || mesh.positions.iter().copied();
    let (Some(low), Some(high)) = (places().reduce(DVec3::min), places().reduce(DVec3::max)) else {
        return;
    };
    let (middle, side) = (0.5 * (low + high), (high - low).max_element());
    for place in &mut mesh.positions {
        *place = (*place - middle) / side;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Tree {
        Tree {
            branches: 6,
            leaves: 4,
            ..Broad::default().0
        }
    }

    #[test]
    fn the_same_seed_grows_the_same_tree_and_another_another() {
        let grown = |seed| {
            let tree = Tree { seed, ..small() };
            Growth::new(&tree, &BROAD).mesh()
        };
        assert_eq!(grown(1), grown(1));
        assert_ne!(grown(1), grown(2));
    }

    #[test]
    fn leaves_and_twigs_are_as_many_as_the_orders_say() {
        for (levels, twigs) in [(1, 6), (2, 6 * 16), (3, 6 * 16 * 12)] {
            let tree = Tree { levels, ..small() };
            let mut growth = Growth::new(&tree, &BROAD);
            growth.trunk();
            assert_eq!(growth.leaves.len(), 4 * twigs);
        }
    }

    #[test]
    fn more_leaves_than_memory_has_room_for_are_refused() {
        let tree = |branches, leaves| {
            Broad(Tree {
                branches,
                leaves,
                ..small()
            })
        };
        assert!(tree(80, 130).check().is_ok());
        let bad = tree(80, 500).check().unwrap_err();
        assert!(bad.to_string().contains("7680000 in all"), "{bad}");
    }

    #[test]
    fn a_willows_twigs_hang_and_none_reaches_below_the_trunk() {
        let tree = Tree {
            leaves: 10,
            ..Willow::default().0
        };
        let mut growth = Growth::new(&tree, &WILLOW);
        growth.trunk();
        let hanging = growth.leaves.iter().filter(|leaf| leaf.along.y < 0.0);
        assert!(hanging.count() * 10 > growth.leaves.len() * 9);
        let low = growth.leaves.iter().map(|leaf| leaf.foot.y);
        assert!(low.fold(f64::INFINITY, f64::min) > 0.0);
    }

    #[test]
    fn every_tree_fills_the_cube_and_has_normals_of_length_1() {
        for (tree, species) in [(small(), &BROAD), (small(), &WILLOW)] {
            let mesh = Growth::new(&tree, species).mesh();
            let low = mesh.positions.iter().copied().reduce(DVec3::min).unwrap();
            let high = mesh.positions.iter().copied().reduce(DVec3::max).unwrap();
            assert!((low + high).length() < 1e-12);
            assert!(((high - low).max_element() - 1.0).abs() < 1e-12);
            assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-9));
            let colours: std::collections::BTreeSet<_> = mesh.colours.iter().collect();
            assert!((4..=8).contains(&colours.len()), "{}", colours.len());
        }
    }
}
