//! What of a tree faces away from where (SPEC.md of rho-grid, "Facing").
//!
//! A renderer may leave what faces away where no back shows. Cones of normals come from the samples
//! below each node. A back is seen past an edge of the surface only, so backs may show from where an edge
//! can be seen: rays from the edges tell, that other cells do not stop. A cell of which the back is in
//! the open, or that holds both sides of a sheet, has two sides from everywhere.

use std::sync::LazyLock;

use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;
use rho_grid::blob::facing::{
    BACKS_BYTES, DISTANCES, FACE, PLACES, TWO_SIDED, WIDTH_BITS, WIDTH_STEP, classes_apart, place,
};
use rho_grid::normal::{CLASS_SHIFT, normal};

use crate::geometry::Rim;
use crate::quantise::normal_index;
use crate::sampling::{Tree, TreeSample};

/// Rays from all edges together, about.
const RAYS: usize = 1 << 19;
/// Most rays from a place of an edge.
const MOST: usize = 2 * PLACES;
/// Rays from the back of a sample, and how many must escape for it to be in the open.
const FROM_BACK: (usize, usize) = (4, 3);
/// Of an opening seen at less than this, as a part of its area, no back shows.
const SLANT: f64 = 0.15;
/// Cells an axis of the finest tree that is looked at.
const FINEST: u32 = 512;
/// Cells round where a ray begins in which its own sheet does not stop it.
const OWN: f64 = 3.0;

/// From where backs of a tree's samples show: a bit a place at each distance.
#[derive(Clone, Debug)]
pub struct Backs([[bool; PLACES]; DISTANCES.len()]);

impl Backs {
    /// No back shows from anywhere: a closed surface.
    pub const NONE: Self = Self([[false; PLACES]; DISTANCES.len()]);

    /// Those of the finest of `trees`, which are the same thing; `None` when its edges are not known.
    #[must_use]
    pub fn of(trees: &[Tree]) -> Option<Self> {
        let cells = |tree: &&Tree| tree.sequence.iter().map(|r| u32::from(*r)).product::<u32>();
        let fine = trees.iter().filter(|tree| cells(tree) <= FINEST);
        let tree = fine.max_by_key(cells)?;
        let rims = tree.rims.as_ref()?;
        Some(if rims.is_empty() {
            Self::NONE
        } else {
            Occupied::new(tree).backs(rims)
        })
    }

    /// Somebody on the ray from `from` (within the cube, whose centre is the origin) along `along`, a
    /// unit vector, sees an edge.
    fn mark(&mut self, from: DVec3, along: DVec3) {
        for (places, distance) in self.0.iter_mut().zip(DISTANCES) {
            let distance = f64::from(distance) / 256.0;
            let b = from.dot(along);
            let t = -b + (b * b - from.length_squared() + distance * distance).sqrt();
            if let Some(place) = place_of((from + t * along) / distance) {
                places[place] = true;
            }
        }
    }

    /// Also from places with more such neighbours than others: rays are few.
    fn closed(&self) -> Self {
        /// More than a place beside a straight border has.
        const BESIDE: usize = 5;
        let mut closed = self.clone();
        for (places, marked) in closed.0.iter_mut().zip(&self.0) {
            for (at, shows) in places.iter_mut().enumerate() {
                *shows |= BESIDES[at].iter().filter(|beside| marked[**beside]).count() >= BESIDE;
            }
        }
        closed
    }

    fn with(mut self, other: &Self) -> Self {
        let others = other.0.as_flattened();
        for (shows, other) in self.0.as_flattened_mut().iter_mut().zip(others) {
            *shows |= other;
        }
        self
    }

    fn bytes(&self) -> Vec<u8> {
        let bits = self.0.as_flattened().chunks(8);
        let byte = |bits: &[bool]| {
            bits.iter()
                .rev()
                .fold(0, |byte, bit| byte << 1 | u8::from(*bit))
        };
        let bytes: Vec<u8> = bits.map(byte).collect();
        debug_assert_eq!(bytes.len(), BACKS_BYTES);
        bytes
    }
}

/// The place of a direction of length 1.
fn place_of(direction: DVec3) -> Option<usize> {
    place((direction * f64::from(1 << 20)).as_ivec3().to_array())
}

/// The neighbours of each place.
static BESIDES: LazyLock<Vec<Vec<usize>>> = LazyLock::new(|| {
    let mut middles = vec![DVec3::ZERO; PLACES];
    let sides: Vec<f64> = (0..FACE)
        .map(|i| f64::from(2 * i + 1) / f64::from(FACE) - 1.0)
        .collect();
    for along in [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ] {
        let (u, v) = (
            DVec3::new(along.y, along.z, along.x),
            DVec3::new(along.z, along.x, along.y),
        );
        for middle in sides
            .iter()
            .flat_map(|i| sides.iter().map(move |j| along + *i * u + *j * v))
        {
            if let Some(place) = place_of(middle.normalize()) {
                middles[place] = middle.normalize();
            }
        }
    }
    let step = 2.0 / f64::from(FACE);
    let beside = |(at, middle): (usize, &DVec3)| {
        // A place in the middle of a face is the largest; diagonals count.
        let near =
            |other: &DVec3| (*middle - *other).length() < 1.45 * step * middle.abs().max_element();
        let all = middles.iter().enumerate();
        all.filter(|(other, direction)| *other != at && near(direction))
            .map(|(other, _)| other)
            .collect()
    };
    middles.iter().enumerate().map(beside).collect()
});

/// The section of a tree's grid.
#[must_use]
pub fn section(tree: &Tree, backs: &Backs) -> Vec<u8> {
    let mut out = backs.bytes();
    for word in cones(tree) {
        out.extend(word.to_le_bytes());
    }
    out
}

/// The class of normals by which a normal is drawn, as its direction.
fn class(normal_13: u32, apart: usize) -> DVec3 {
    let class = (normal_13 >> CLASS_SHIFT) / apart as u32 * apart as u32;
    let [x, y, z] = normal(class << CLASS_SHIFT).map(|v| f64::from(v.to_bits()) / 16384.0);
    DVec3::new(x, y, z)
}

/// The axis of the narrowest cone round `normals` among the classes near their mean, as the index of
/// a normal, and the cosine of its half angle.
fn axis(normals: &[DVec3], apart: usize) -> (u32, f64) {
    /// As far as a class's neighbours are.
    const NEAR: f64 = 0.12;
    let mean = normals.iter().sum::<DVec3>();
    let mean = mean.try_normalize().unwrap_or(DVec3::Y);
    let (right, up) = mean.any_orthonormal_pair();
    (-1..2)
        .flat_map(|i| (-1..2).map(move |j| (f64::from(i), f64::from(j))))
        .map(|(i, j)| normal_index((mean + NEAR * (i * right + j * up)).normalize()))
        .map(|index| {
            let axis = class(index, apart);
            let least = normals.iter().map(|n| n.dot(axis)).fold(1.0, f64::min);
            (index, least)
        })
        .max_by(|(_, a), (_, b)| a.total_cmp(b))
        .unwrap_or((0, 0.0))
}

/// A word for each node above the leaves, level by level.
fn cones(tree: &Tree) -> Vec<u16> {
    /// By how much the renderer may be off: its classes have 32 steps to the unit.
    const ROUNDING: f64 = 0.04;
    let cells: u32 = tree.sequence.iter().map(|r| u32::from(*r)).product();
    let apart = classes_apart(cells);
    let Some((leaves, inner)) = tree.levels.split_last() else {
        return Vec::new();
    };
    let classes: Vec<DVec3> = leaves
        .samples
        .iter()
        .map(|sample| class(normal_index(DVec3::from(sample.normal)), apart))
        .collect();
    let of_samples = leaves.samples.iter().map(|sample| sample.two_sided);
    let two_sided: Vec<bool> = if cells <= FINEST {
        let open = Occupied::new(tree).open();
        of_samples
            .zip(open)
            .map(|(two, open)| two || open)
            .collect()
    } else {
        vec![true; leaves.samples.len()]
    };
    // The leaves below each node, level by level from the lowest.
    let mut ranges: Vec<(usize, usize)> = (0..classes.len()).map(|leaf| (leaf, leaf + 1)).collect();
    let mut levels = Vec::new();
    for level in inner.iter().rev() {
        let mut next = 0;
        ranges = level
            .masks
            .iter()
            .map(|mask| {
                let first = next;
                next += mask.count_ones() as usize;
                (ranges[first].0, ranges[next - 1].1)
            })
            .collect();
        let words: Vec<u16> = ranges
            .par_iter()
            .map(|&(first, end)| {
                let classes = &classes[first..end];
                let (index, least) = axis(classes, apart);
                let two_sided = two_sided[first..end].contains(&true);
                let width = if two_sided {
                    TWO_SIDED
                } else if least <= 0.0 {
                    TWO_SIDED - 1
                } else {
                    let sine = (1.0 - least * least).max(0.0).sqrt() + ROUNDING;
                    let steps = (sine * 2048.0 / f64::from(WIDTH_STEP)).ceil() as u32;
                    steps.min(TWO_SIDED - 1)
                };
                (index >> CLASS_SHIFT << WIDTH_BITS | width) as u16
            })
            .collect();
        levels.push(words);
    }
    levels.into_iter().rev().flatten().collect()
}

/// The leaves of a tree by place.
struct Occupied<'a> {
    tree: &'a Tree,
    cells: i32,
    /// A bit a cell.
    bits: Vec<u64>,
    /// Place and number of each leaf.
    leaves: Vec<IVec3>,
    /// The number of the first child of each node, level by level.
    firsts: Vec<Vec<u32>>,
}

impl<'a> Occupied<'a> {
    fn new(tree: &'a Tree) -> Self {
        let mut places = vec![IVec3::ZERO];
        let mut firsts = Vec::new();
        for (rho, level) in tree.sequence.iter().zip(&tree.levels) {
            let rho = u32::from(*rho);
            let mut children = Vec::new();
            let mut first = Vec::with_capacity(level.masks.len());
            for (place, mask) in places.iter().zip(&level.masks) {
                first.push(children.len() as u32);
                let mut mask = *mask;
                while mask != 0 {
                    let bit = mask.trailing_zeros();
                    mask &= mask - 1;
                    let [x, y, z] = [bit % rho, bit / rho % rho, bit / (rho * rho)];
                    let within = IVec3::new(x as i32, y as i32, z as i32);
                    children.push(*place * rho as i32 + within);
                }
            }
            firsts.push(first);
            places = children;
        }
        let cells: i32 = tree.sequence.iter().map(|rho| i32::from(*rho)).product();
        let mut bits = vec![0; (cells.pow(3) as usize).div_ceil(64)];
        for place in &places {
            let at = number(*place, cells);
            bits[at / 64] |= 1 << (at % 64);
        }
        Self {
            tree,
            cells,
            bits,
            leaves: places,
            firsts,
        }
    }

    fn is_leaf(&self, place: IVec3) -> bool {
        let at = number(place, self.cells);
        self.bits[at / 64] >> (at % 64) & 1 == 1
    }

    /// The number of the leaf at `place`, which is one.
    fn leaf(&self, place: IVec3) -> usize {
        let mut side = self.cells;
        let mut node = 0;
        let mut rest = place;
        for ((rho, level), first) in self
            .tree
            .sequence
            .iter()
            .zip(&self.tree.levels)
            .zip(&self.firsts)
        {
            let rho = i32::from(*rho);
            side /= rho;
            let within = rest / side;
            rest -= within * side;
            let bit = within.x + rho * (within.y + rho * within.z);
            let below = level.masks[node] & !(u128::MAX << bit);
            node = (first[node] + below.count_ones()) as usize;
        }
        node
    }

    /// From where one of these places on the surface's edges can be seen.
    fn backs(&self, rims: &[Rim]) -> Backs {
        let cells = f64::from(self.cells);
        let each = (RAYS / rims.len().max(1)).clamp(1, MOST);
        // Not more places than rays.
        let every = rims.len().div_ceil(RAYS).max(1);
        let rims: Vec<Rim> = rims.iter().copied().step_by(every).collect();
        rims.par_chunks(16)
            .enumerate()
            .map(|(chunk, rims)| {
                let mut backs = Backs::NONE;
                for (n, rim) in (16 * chunk..).zip(rims) {
                    let from = (rim.at + 0.5).clamp(DVec3::ZERO, DVec3::ONE) * cells;
                    for ray in 0..each {
                        let along = direction(n * each + ray);
                        if along.dot(rim.opens) > SLANT * rim.opens.length()
                            && self.escapes(from, along, |_, _| false)
                        {
                            backs.mark(rim.at, along);
                        }
                    }
                }
                backs
            })
            .reduce(|| Backs::NONE, |all, more| all.with(&more))
            .closed()
    }

    /// Whether the back of each leaf is in the open.
    fn open(&self) -> Vec<bool> {
        let (rays, enough) = FROM_BACK;
        let samples = self.samples();
        let is_open = |(n, place): (usize, &IVec3)| {
            let sample = &samples[n];
            let offset = sample.offset.clamp(-0.9, 0.9) * sample.normal;
            let from = (place.as_vec3() + Vec3::splat(0.5) + offset).as_dvec3();
            let normal = DVec3::from(sample.normal);
            // Within that many cells what is met from behind only: the other side.
            let is_other = |leaf: usize, along: DVec3| {
                samples[leaf].two_sided || DVec3::from(samples[leaf].normal).dot(along) > 0.05
            };
            let escapes = |ray: usize| {
                let along = direction(n * rays + ray);
                let along = (along - 1.5 * normal).normalize();
                self.escapes(from, along, is_other)
            };
            (0..rays).filter(|ray| escapes(*ray)).count() >= enough
        };
        self.leaves.par_iter().enumerate().map(is_open).collect()
    }

    fn samples(&self) -> &[TreeSample] {
        self.tree
            .levels
            .last()
            .map_or(&[], |leaves| &leaves.samples)
    }

    /// Whether a ray, in cells, leaves the cube. Near its beginning only those cells stop it that
    /// `is_other` names.
    fn escapes(&self, from: DVec3, along: DVec3, is_other: impl Fn(usize, DVec3) -> bool) -> bool {
        let start = from.floor().as_ivec3();
        let mut place = start;
        let step = along.signum().as_ivec3();
        let inverse = along.recip();
        let ahead = DVec3::select(along.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
        let mut next = (place.as_dvec3() + ahead - from) * inverse;
        let mut t = 0.0;
        let end = IVec3::splat(self.cells);
        while place.cmpge(IVec3::ZERO).all() && place.cmplt(end).all() {
            let stops = place != start
                && self.is_leaf(place)
                && (t > OWN || is_other(self.leaf(place), along));
            if stops {
                return false;
            }
            let axis = next.min_position();
            t = next[axis];
            place[axis] += step[axis];
            next[axis] += inverse[axis].abs();
        }
        true
    }
}

fn number(place: IVec3, cells: i32) -> usize {
    (place.x + cells * (place.y + cells * place.z)) as usize
}

/// The `n`th of directions that lie evenly on the sphere however many are taken (Roberts' sequence
/// of two numbers).
fn direction(n: usize) -> DVec3 {
    let part = |factor: f64| (0.5 + n as f64 * factor).fract();
    let (z, turn) = (
        2.0 * part(0.754_877_666_246_692_7) - 1.0,
        part(0.569_840_290_998_053_2),
    );
    let (sine, cosine) = (turn * std::f64::consts::TAU).sin_cos();
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * cosine, across * sine, z)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use super::*;
    use crate::geometry::Geometry;
    use crate::geometry::triangles::Triangles;
    use crate::mesh::Mesh;
    use crate::sampling::{Sampling, Separation};

    /// A sphere of radius 0.45, its normals outwards; without what lies above `lid`.
    fn sphere(lid: f64, inside_out: bool) -> Mesh {
        const STEPS: u32 = 40;
        let turn = |i: u32, n: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        let mut mesh = Mesh::default();
        let at = |i: u32, j: u32| {
            // The same place to the bit at either end of a round, and at the poles.
            let (polar, round) = (0.5 * turn(i, STEPS), turn(j % (2 * STEPS), 2 * STEPS));
            let across = if i.is_multiple_of(STEPS) {
                0.0
            } else {
                polar.sin()
            };
            DVec3::new(across * round.sin(), polar.cos(), across * round.cos())
        };
        for (i, j) in (0..STEPS).flat_map(|i| (0..2 * STEPS).map(move |j| (i, j))) {
            if at(i, j).y > lid {
                continue;
            }
            let first = mesh.positions.len() as u32;
            for n in [at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)] {
                mesh.positions.push(0.45 * n);
                mesh.normals.push(if inside_out { -n } else { n });
            }
            for [a, b, c] in [[0, 2, 1], [1, 2, 3]] {
                let (b, c) = if inside_out { (c, b) } else { (b, c) };
                mesh.triangles.push([first + a, first + b, first + c]);
            }
        }
        mesh
    }

    fn tree(mesh: &Mesh) -> Tree {
        let sampling = Sampling {
            sequence: "3,3,3".parse().unwrap(),
            separation: Separation::Six,
            memory: 1 << 30,
        };
        let leaves = AtomicU64::new(0);
        let geometry = Triangles::new(mesh);
        let tree = sampling.sample(&geometry, &leaves).unwrap();
        Tree {
            rims: geometry.rims(),
            ..tree
        }
    }

    #[test]
    fn no_back_of_a_sphere_shows_and_one_without_a_lid_shows_them_from_above() {
        let closed = Backs::of(&[tree(&sphere(2.0, false))]).unwrap();
        assert_eq!(closed.0.as_flattened().iter().filter(|b| **b).count(), 0);
        let open = Backs::of(&[tree(&sphere(0.7, false))]).unwrap();
        let shows = |y: f64, distance: usize| {
            let eye = DVec3::new(0.3, y, 0.1).normalize();
            open.0[distance][place_of(eye).unwrap()]
        };
        for distance in 0..DISTANCES.len() {
            assert!(shows(2.0, distance) && shows(0.8, distance));
            assert!(!shows(-0.3, distance) && !shows(-2.0, distance));
        }
    }

    #[test]
    fn what_is_inside_out_has_two_sides() {
        let right = Occupied::new(&tree(&sphere(2.0, false))).open();
        assert!(right.iter().all(|open| !open));
        let wrong = Occupied::new(&tree(&sphere(2.0, true))).open();
        assert!(wrong.iter().all(|open| *open));
    }

    #[test]
    fn a_cone_holds_the_normals_of_all_samples_below() {
        let tree = tree(&sphere(0.7, false));
        let words = cones(&tree);
        let inner: usize = tree.levels.iter().map(|level| level.masks.len()).sum();
        assert_eq!(words.len(), inner);
        let parents = &tree.levels[2].masks;
        let mut leaf = 0;
        let mut narrow = 0;
        for (mask, word) in parents.iter().zip(&words[inner - parents.len()..]) {
            let axis = class(u32::from(word >> WIDTH_BITS) << CLASS_SHIFT, 4);
            let width = u32::from(*word) & TWO_SIDED;
            for sample in &tree.levels[3].samples[leaf..leaf + mask.count_ones() as usize] {
                let normal = class(normal_index(DVec3::from(sample.normal)), 4);
                let sine = axis.cross(normal).length();
                assert!(width >= TWO_SIDED - 1 || sine * 2048.0 < f64::from(width * WIDTH_STEP));
            }
            narrow += usize::from(width < TWO_SIDED - 1);
            leaf += mask.count_ones() as usize;
        }
        assert!(narrow * 2 > parents.len(), "{narrow} of {}", parents.len());
    }

    #[test]
    fn every_place_has_about_eight_neighbours() {
        let counts: Vec<usize> = BESIDES.iter().map(Vec::len).collect();
        assert!(counts.iter().all(|n| (6..=14).contains(n)), "{counts:?}");
    }
}
