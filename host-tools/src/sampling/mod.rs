//! Geometry becomes a tree of samples.
//!
//! Duguet & Drettakis 2003, section 4.1: the cube is cut into rho x rho x rho cells, each of
//! them that the object meets is cut again, and every cell, intermediate or leaf, is sampled
//! "at the point of the object closest to the center of the cell". Where the paper has one
//! rho, here each level has its own:
//!
//! | paper | here |
//! | --- | --- |
//! | rho | `sequence[level]`, 2 to 5 |
//! | m, the depth | `sequence.len()` |
//! | N_i, the cells at depth i | `levels[i].samples.len()` |
//! | n, the leaves | the last level's samples |
//!
//! A cell exists if it has a leaf below it. Which cells are leaves is the question of
//! [`Separation`]. The tree is the same to the bit whatever the number of threads: a cell
//! depends on nothing but its own primitives, which keep their order, and subtrees are
//! strung together in the order of their roots.
//!
//! Here the paper is left: a sample is not the point nearest the cell's centre, but the mean of the
//! surface round it (`blend`), for leaves and (as Botsch et al. 2002 do) for all above them.

mod blend;
mod tree;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::failure::{Failure, Outcome};
use crate::geometry::Geometry;
use crate::geometry::cells::{Cell, Subcells, bits};
use crate::geometry::portion::Portion;

pub use tree::{MAX_CELLS, Separation, Sequence, Tree, TreeLevel, TreeSample};

/// Cells an axis from which on subtrees are not divided among threads any more.
const TASKS: u32 = 9;

/// Primitives that are dealt out to subcells by one thread at a time.
const CHUNK: usize = 16_384;

/// By how much more than it takes a tree must be expected to take before it is refused
/// unseen: sheets that share cells are expected once each.
const OVERESTIMATE: u64 = 16;

/// Memory while sampling, in bytes a node: its portion and its share of masks, twice, since
/// subtrees are copied together at the end; a sample is smaller than a portion.
const NODE_BYTES: u64 = 2 * (size_of::<Portion>() + size_of::<u128>() / 8) as u64;

/// How to sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// How often each level cuts its cells.
    pub sequence: Sequence,
    /// Which cells are leaves.
    pub separation: Separation,
    /// The most bytes that the tree may take while it grows (the geometry's own not among
    /// them); [`Sampling::sample`] fails rather than take more.
    pub memory: u64,
}

impl Sampling {
    /// About how many leaves there will be, from the surface's area: within some 5 % for the
    /// surface of a body; too many where sheets share cells (a tree's leaves: sevenfold), too
    /// few for what is small against a cell.
    #[must_use]
    pub fn expected_leaves<G: Geometry + ?Sized>(&self, geometry: &G) -> u64 {
        let cells = f64::from(self.sequence.cells());
        let area = geometry.weighted_area(match self.separation {
            Separation::TwentySix => DVec3::element_sum,
            Separation::Six => DVec3::max_element,
        });
        (area * cells * cells).min(cells.powi(3)).ceil() as u64
    }

    /// About how many bytes [`Sampling::sample`] will take.
    #[must_use]
    pub fn expected_memory<G: Geometry + ?Sized>(&self, geometry: &G) -> u64 {
        // A level has about rho^2 times the nodes of the one above.
        let mut level = self.expected_leaves(geometry);
        let mut nodes = level;
        for &rho in self.sequence.as_slice().iter().rev() {
            level = level.div_ceil(u64::from(rho).pow(2));
            nodes += level;
        }
        nodes * NODE_BYTES + list_bytes(geometry)
    }

    /// Samples `geometry`. `leaves` counts the leaves as they are made, for a progress bar
    /// whose length is [`Sampling::expected_leaves`].
    ///
    /// # Errors
    /// When the tree would not fit into `memory`, as far as can be foreseen or when it comes
    /// to it, and when there is no leaf at all.
    pub fn sample<G: Geometry + ?Sized>(&self, geometry: &G, leaves: &AtomicU64) -> Outcome<Tree> {
        let expected = self.expected_memory(geometry);
        if expected / OVERESTIMATE > self.memory {
            return Err(self.too_large(&format!("about {}", megabytes(expected))));
        }
        let grower = Grower {
            geometry,
            sequence: self.sequence.as_slice(),
            separation: self.separation,
            bytes: AtomicU64::new(list_bytes(geometry)),
            limit: self.memory,
            leaves,
        };
        let all: Vec<u32> = (0..geometry.primitives()).collect();
        let root = Subcells::of(&Cell::ROOT, 1);
        let (mut inside, _) = grower.deal(&all, &root, false);
        drop(all);
        let inside = inside.swap_remove(0);
        let Branch { masks, leaves } = grower
            .branch(&Cell::ROOT, 0, &inside)
            .map_err(|TooLarge| self.too_large(&format!("more than {}", megabytes(self.memory))))?;
        if leaves.is_empty() {
            let failure = Failure::input("the object has no surface in any cell of the grid");
            return Err(match self.separation {
                Separation::TwentySix => failure.help("give a model that has triangles"),
                Separation::Six => {
                    failure.help("use more subdivisions, or cells that are not thin")
                }
            });
        }
        Ok(Tree {
            sequence: self.sequence.as_slice().to_vec(),
            separation: self.separation,
            rims: None,
            levels: blend::levels(self.sequence.as_slice(), masks, leaves),
        })
    }

    fn too_large(&self, needs: &str) -> Failure {
        Failure::input(format!(
            "a grid of {} cells an axis needs {needs} of memory for this object, and the limit \
             leaves {}",
            self.sequence.cells(),
            megabytes(self.memory)
        ))
        .help("use fewer subdivisions or thin cells, or raise the limit with --memory")
    }
}

/// The lists of primitives: all of them at the root, and again, with those that meet several
/// subcells, in the level below it.
fn list_bytes<G: Geometry + ?Sized>(geometry: &G) -> u64 {
    u64::from(geometry.primitives()) * 4 * 4
}

fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes.div_ceil(1_000_000))
}

/// The memory limit was passed.
struct TooLarge;

/// What all subtrees share.
struct Grower<'a, G: ?Sized> {
    geometry: &'a G,
    sequence: &'a [u8],
    separation: Separation,
    bytes: AtomicU64,
    limit: u64,
    leaves: &'a AtomicU64,
}

/// A subtree.
struct Branch {
    /// The masks of its inner nodes, level by level from its root down.
    masks: Vec<Vec<u128>>,
    /// None when the surface crosses no cell of it; its masks are then empty, too.
    leaves: Vec<Portion>,
}

impl Branch {
    /// With `levels` of inner nodes, none of them yet.
    fn new(levels: usize) -> Self {
        Self {
            masks: vec![Vec::new(); levels],
            leaves: Vec::new(),
        }
    }
}

/// The primitives of each subcell, by bit.
type Lists = Vec<Vec<u32>>;

impl<G: Geometry + ?Sized> Grower<'_, G> {
    /// Whether the children of a node at `depth` are leaves that must be crossed.
    fn must_cross(&self, depth: usize) -> bool {
        self.separation == Separation::Six && depth + 1 == self.sequence.len()
    }

    /// The subtree of `cell`, at `depth`. Subtrees are divided among threads.
    fn branch(&self, cell: &Cell, depth: usize, primitives: &[u32]) -> Result<Branch, TooLarge> {
        if cell.per_axis >= TASKS || depth == self.sequence.len() {
            let mut task = Task::new(self, depth);
            task.grow(cell, depth, primitives)?;
            task.account(0)?;
            return Ok(task.branch);
        }
        let rho = self.sequence[depth];
        let subcells = Subcells::of(cell, rho);
        let (lists, crossed) = self.deal(primitives, &subcells, self.must_cross(depth));
        let children: Vec<Branch> = lists
            .into_par_iter()
            .enumerate()
            .map(|(bit, list)| {
                if list.is_empty() || crossed >> bit & 1 == 0 {
                    return Ok(Branch::new(0));
                }
                self.branch(&cell.child(rho, bit as u32), depth + 1, &list)
            })
            .collect::<Result<_, _>>()?;

        let mut whole = Branch::new(self.sequence.len() - depth);
        let mut mask = 0;
        for (bit, child) in children.into_iter().enumerate() {
            if !child.leaves.is_empty() {
                mask |= 1 << bit;
            }
            whole.leaves.extend_from_slice(&child.leaves);
            for (level, part) in whole.masks[1..].iter_mut().zip(child.masks) {
                level.extend_from_slice(&part);
            }
        }
        if mask != 0 {
            whole.masks[0].push(mask);
        }
        Ok(whole)
    }

    /// Deals the primitives of a cell out to its subcells, each list in ascending order; and
    /// the subcells that are crossed, if that is asked, else all.
    fn deal(&self, primitives: &[u32], subcells: &Subcells, cross: bool) -> (Lists, u128) {
        let cells = subcells.rho().pow(3);
        let parts: Vec<(Lists, u128)> = primitives
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut lists = vec![Vec::new(); cells];
                let crossed = self.deal_chunk(chunk, subcells, cross, &mut lists);
                (lists, crossed)
            })
            .collect();
        let mut parts = parts.into_iter();
        let (mut lists, mut crossed) = parts.next().unwrap_or_else(|| (vec![Vec::new(); cells], 0));
        for (part, more) in parts {
            crossed |= more;
            for (list, more) in lists.iter_mut().zip(part) {
                list.extend_from_slice(&more);
            }
        }
        (lists, crossed)
    }

    fn deal_chunk(
        &self,
        primitives: &[u32],
        subcells: &Subcells,
        cross: bool,
        lists: &mut Lists,
    ) -> u128 {
        let mut crossed = if cross { 0 } else { u128::MAX };
        for &primitive in primitives {
            let mask = self.geometry.meets(primitive, subcells);
            for bit in bits(mask) {
                lists[bit as usize].push(primitive);
            }
            if mask & !crossed != 0 {
                crossed |= mask & self.geometry.crosses(primitive, subcells);
            }
        }
        crossed
    }
}

/// One subtree, grown depth first by one thread.
struct Task<'a, 'b, G: ?Sized> {
    shared: &'a Grower<'b, G>,
    /// The depth of the subtree's root.
    top: usize,
    branch: Branch,
    /// The subcells' lists in use at each depth below the root, kept for their memory.
    lists: Vec<Lists>,
    /// Nodes and leaves not yet accounted for.
    nodes: u64,
    leaves: u64,
}

impl<'a, 'b, G: Geometry + ?Sized> Task<'a, 'b, G> {
    fn new(shared: &'a Grower<'b, G>, top: usize) -> Self {
        let below = &shared.sequence[top..];
        Self {
            shared,
            top,
            branch: Branch::new(below.len()),
            lists: below
                .iter()
                .map(|&rho| vec![Vec::new(); usize::from(rho).pow(3)])
                .collect(),
            nodes: 0,
            leaves: 0,
        }
    }

    /// Adds the subtree of `cell` to the levels; says whether it has a leaf.
    fn grow(&mut self, cell: &Cell, depth: usize, primitives: &[u32]) -> Result<bool, TooLarge> {
        let Some(&rho) = self.shared.sequence.get(depth) else {
            let Some(leaf) = self.shared.geometry.portion(primitives, cell) else {
                return Ok(false);
            };
            self.branch.leaves.push(leaf);
            self.leaves += 1;
            self.nodes += 1;
            self.account(1024)?;
            return Ok(true);
        };
        let level = depth - self.top;
        let subcells = Subcells::of(cell, rho);
        let mut lists = std::mem::take(&mut self.lists[level]);
        for list in &mut lists {
            list.clear();
        }
        let cross = self.shared.must_cross(depth);
        let crossed = self
            .shared
            .deal_chunk(primitives, &subcells, cross, &mut lists);
        let mut mask = 0;
        for (bit, list) in (0..).zip(&lists) {
            if !list.is_empty()
                && crossed >> bit & 1 == 1
                && self.grow(&cell.child(rho, bit), depth + 1, list)?
            {
                mask |= 1 << bit;
            }
        }
        self.lists[level] = lists;
        if mask != 0 {
            self.branch.masks[level].push(mask);
            self.nodes += 1;
        }
        Ok(mask != 0)
    }

    /// Tells of the nodes made since it was last called, if there are at least `from`.
    fn account(&mut self, from: u64) -> Result<(), TooLarge> {
        if self.nodes < from {
            return Ok(());
        }
        self.shared.leaves.fetch_add(self.leaves, Ordering::Relaxed);
        let bytes = self.nodes * NODE_BYTES;
        let before = self.shared.bytes.fetch_add(bytes, Ordering::Relaxed);
        (self.nodes, self.leaves) = (0, 0);
        if before + bytes > self.shared.limit {
            return Err(TooLarge);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle;
    use crate::geometry::triangles::Triangles;
    use crate::mesh::Mesh;

    /// A sphere of radius 0.5, finer than the cells of the tests.
    fn sphere() -> Mesh {
        const STEPS: u32 = 48;
        let turn = |i: u32, n: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        let mut mesh = Mesh::default();
        for i in 0..=STEPS {
            for j in 0..=2 * STEPS {
                let (polar, round) = (0.5 * turn(i, STEPS), turn(j, 2 * STEPS));
                let normal = DVec3::new(
                    polar.sin() * round.sin(),
                    polar.cos(),
                    polar.sin() * round.cos(),
                );
                mesh.positions.push(0.5 * normal);
                mesh.normals.push(normal);
                mesh.colours.push([i as u8, j as u8, 7]);
                if i > 0 && j > 0 {
                    let [a, b, c, d] = [0, 1, 2 * STEPS + 1, 2 * STEPS + 2]
                        .map(|back| mesh.positions.len() as u32 - 1 - back);
                    mesh.triangles.extend([[d, b, a], [d, a, c]]);
                }
            }
        }
        mesh
    }

    fn sampling(sequence: &str, separation: Separation) -> Sampling {
        Sampling {
            sequence: sequence.parse().unwrap(),
            separation,
            memory: 1 << 30,
        }
    }

    fn grow(mesh: &Mesh, sequence: &str, separation: Separation) -> Tree {
        sampling(sequence, separation)
            .sample(&Triangles::new(mesh), &AtomicU64::new(0))
            .unwrap()
    }

    /// Every node of a tree, level by level, found by descending it.
    fn cells(tree: &Tree) -> Vec<Vec<Cell>> {
        let mut levels = vec![vec![Cell::ROOT]];
        for (level, &rho) in tree.levels.iter().zip(&tree.sequence) {
            let parents = &levels[levels.len() - 1];
            assert_eq!(level.masks.len(), parents.len());
            let children = parents
                .iter()
                .zip(&level.masks)
                .flat_map(|(cell, &mask)| bits(mask).map(move |bit| cell.child(rho, bit)))
                .collect();
            levels.push(children);
        }
        levels
    }

    #[test]
    fn every_cell_that_a_triangle_meets_is_a_leaf_and_no_other() {
        let mesh = sphere();
        let geometry = Triangles::new(&mesh);
        for (sequence, separation) in [
            ("3,3", Separation::TwentySix),
            ("2,5", Separation::TwentySix),
            ("4,3,2", Separation::Six),
            ("5", Separation::Six),
        ] {
            let tree = grow(&mesh, sequence, separation);
            let leaves = cells(&tree).pop().unwrap();
            let n = sampling(sequence, separation).sequence.cells();
            let mut expected = 0;
            for index in 0..n.pow(3) {
                let cell = Cell {
                    per_axis: n,
                    index: [index % n, index / n % n, index / n / n],
                };
                let cell_itself = Subcells::of(&cell, 1);
                let exists = (0..geometry.primitives()).any(|primitive| {
                    (match separation {
                        Separation::TwentySix => geometry.meets(primitive, &cell_itself),
                        Separation::Six => geometry.crosses(primitive, &cell_itself),
                    }) == 1
                });
                expected += usize::from(exists);
                assert_eq!(leaves.contains(&cell), exists, "{cell:?}");
            }
            assert_eq!(tree.leaves(), expected);
        }
    }

    /// The mean of the sphere's surface in cells of which each counts `weight(cell)`, in f64: its
    /// normal and centre of gravity.
    fn mean(mesh: &Mesh, cells: impl Iterator<Item = (Cell, f64)>) -> (DVec3, DVec3) {
        let (mut area, mut moment, mut normal) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for (cell, weight) in cells {
            let (low, high) = cell.corners();
            for triangle in &mesh.triangles {
                let corners = triangle.map(|v| mesh.positions[v as usize]);
                let Some((part, centre)) = triangle::within(&corners, low, high) else {
                    continue;
                };
                area += weight * part;
                moment += weight * part * centre;
                // On a sphere the interpolated normal is that of the place.
                normal += weight * part * centre.normalize();
            }
        }
        (normal.normalize(), moment / area)
    }

    #[test]
    fn a_sample_is_the_mean_of_the_leaves_in_its_cell_and_less_of_those_round_it() {
        let mesh = sphere();
        for separation in [Separation::TwentySix, Separation::Six] {
            let tree = grow(&mesh, "2,3,4", separation);
            let all = cells(&tree);
            let leaves = all.last().unwrap();
            let within = |leaf: &Cell, cell: &Cell| {
                let times = leaf.per_axis / cell.per_axis;
                leaf.index.map(|i| (i / times) as i32)
            };
            for (level, cells) in tree.levels.iter().zip(&all).skip(2) {
                assert_eq!(level.samples.len(), cells.len());
                for (sample, cell) in level.samples.iter().zip(cells).step_by(29) {
                    let at = cell.index.map(|i| i as i32);
                    let near = leaves.iter().filter_map(|leaf| {
                        let other = within(leaf, cell);
                        let steps = [0, 1, 2].map(|axis| (other[axis] - at[axis]).abs());
                        let aside = steps.iter().filter(|step| **step == 1).count();
                        let weight = f64::from(blend::ASIDE).powi(aside as i32);
                        (steps.iter().all(|step| *step < 2)).then_some((*leaf, weight))
                    });
                    let (normal, centre) = mean(&mesh, near);
                    let off = sample.normal.as_dvec3().distance(normal);
                    assert!(off < 2e-3, "{cell:?}: {} for {normal}", sample.normal);
                    let offset = (centre - cell.centre()).dot(normal) / cell.side();
                    assert!((f64::from(sample.offset) - offset).abs() < 2e-3, "{cell:?}");
                }
            }
        }
    }

    #[test]
    fn of_two_sheets_in_a_cell_the_one_nearer_its_centre_is_kept() {
        // Two squares across the cube, face to face, 0.02 above and 0.01 below the middle of the
        // cells of a third of the cube.
        let mut mesh = Mesh::default();
        for (y, normal) in [(0.02, DVec3::Y), (-0.01, -DVec3::Y)] {
            let first = mesh.positions.len() as u32;
            for (x, z) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)] {
                mesh.positions.push(DVec3::new(x, y, z));
                mesh.normals.push(normal);
            }
            mesh.triangles
                .extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| v + first)));
        }
        let tree = grow(&mesh, "3", Separation::Six);
        assert_eq!(tree.leaves(), 9);
        for sample in &tree.levels[1].samples {
            assert_eq!(sample.normal, glam::Vec3::NEG_Y);
            assert!((sample.offset - 0.03).abs() < 1e-6, "{}", sample.offset);
        }
    }

    #[test]
    fn an_inner_node_exists_only_above_a_leaf() {
        let tree = grow(&sphere(), "2,2,2,2,2", Separation::Six);
        for level in &tree.levels[..5] {
            assert!(level.masks.iter().all(|&mask| mask != 0));
        }
        assert!(tree.levels[5].masks.is_empty());
    }

    #[test]
    fn the_leaves_do_not_depend_on_how_the_cells_are_cut() {
        let mesh = sphere();
        for separation in [Separation::TwentySix, Separation::Six] {
            let mut all: Vec<Vec<[u32; 3]>> = Vec::new();
            for sequence in ["2,3,4", "4,3,2", "3,2,2,2"] {
                let leaves = cells(&grow(&mesh, sequence, separation)).pop().unwrap();
                let mut leaves: Vec<_> = leaves.iter().map(|cell| cell.index).collect();
                leaves.sort_unstable();
                all.push(leaves);
            }
            assert_eq!(all[0], all[1]);
            assert_eq!(all[0], all[2]);
        }
    }

    #[test]
    fn the_tree_is_the_same_whatever_the_number_of_threads() {
        let mesh = sphere();
        let geometry = Triangles::new(&mesh);
        for separation in [Separation::TwentySix, Separation::Six] {
            let trees = [1, 2, 5].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                let sampling = sampling("3,2,3,3", separation);
                pool.install(|| sampling.sample(&geometry, &AtomicU64::new(0)).unwrap())
            });
            assert_eq!(trees[0], trees[1]);
            assert_eq!(trees[0], trees[2]);
        }
    }

    #[test]
    fn progress_ends_at_the_number_of_leaves_which_was_about_foreseen() {
        let mesh = sphere();
        let geometry = Triangles::new(&mesh);
        for separation in [Separation::TwentySix, Separation::Six] {
            let sampling = sampling("3,3,5", separation);
            let leaves = AtomicU64::new(0);
            let tree = sampling.sample(&geometry, &leaves).unwrap();
            assert_eq!(leaves.into_inner(), tree.leaves() as u64);
            let ratio = sampling.expected_leaves(&geometry) as f64 / tree.leaves() as f64;
            assert!((0.95..1.05).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn a_tree_over_the_memory_limit_is_refused_with_a_way_out() {
        let mesh = sphere();
        let geometry = Triangles::new(&mesh);
        let mut sampling = sampling("4,4,4,4", Separation::TwentySix);
        let expected = sampling.expected_memory(&geometry);
        // Foreseen, and found out on the way.
        for memory in [expected / 20, expected * 6 / 10] {
            sampling.memory = memory;
            let failure = sampling.sample(&geometry, &AtomicU64::new(0)).unwrap_err();
            assert!(failure.message.contains("MB"), "{failure}");
            assert!(failure.help.unwrap().contains("--memory"));
        }
        sampling.memory = expected * 3 / 2;
        assert!(sampling.sample(&geometry, &AtomicU64::new(0)).is_ok());
    }

    #[test]
    fn what_has_no_surface_is_refused() {
        let mesh = Mesh::default();
        for separation in [Separation::TwentySix, Separation::Six] {
            let failure = sampling("3,3", separation)
                .sample(&Triangles::new(&mesh), &AtomicU64::new(0))
                .unwrap_err();
            assert!(failure.help.is_some());
        }
    }
}
