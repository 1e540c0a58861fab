//! A grid as a light sees it: the tables that follow from light and grid.
//!
//! A *place* is a point in the light's space as one word, so that one addition moves all three of its
//! coordinates, and the projected displacement of a subcell (paper, section 5.3) is one word too:
//!
//! ```text
//! bits 0 to 10    u, 2048 to the map's width
//! bits 11 to 21   v, 2048 to its height
//! bits 22 to 31   depth, away from the light, 1024 to all that there is
//! ```

use super::light::LightSpace;
use super::moved::{Bias, Lengths, Moved};
use crate::blob::format::MAX_SUBDIVISIONS;
use crate::blob::{Grid, Instance};
use crate::mode::MapSize;

/// Bits of u and of v.
pub(super) const ACROSS: u32 = 11;
/// Where the depth begins.
pub(super) const DEPTH: u32 = 2 * ACROSS;
/// Depths that there are.
const DEPTHS: i32 = 1 << (32 - DEPTH);
/// Texels left free at each edge of the map, for splats and for what look-ups are moved by.
const MARGIN: i32 = 4;
/// Displacements of all levels together, as in [`View`](crate::render::View).
const DISPLACEMENTS: usize = 5 * 125;

/// The tables of a grid in a light, about 7 kB.
#[derive(Clone, Debug)]
pub struct ShadowView {
    /// The cube's centre; u, v, depth in their units, Q16.
    centre: [i32; 3],
    levels: [LevelView; MAX_SUBDIVISIONS + 1],
    /// From a cell's centre to its subcells'.
    displacements: [u32; DISPLACEMENTS],
    moved: Moved,
}

/// What the tables have of a level.
#[derive(Clone, Copy, Debug)]
struct LevelView {
    /// Cells along an axis.
    cells: i32,
    /// Half an edge of a cell along the grid's x, y, z, in the centre's units.
    half_edges: [[i32; 3]; 3],
    /// Where the displacements of its cells' subcells begin.
    first: usize,
}

impl LevelView {
    const NONE: Self = Self {
        cells: 0,
        half_edges: [[0; 3]; 3],
        first: 0,
    };

    /// So many half edges.
    #[inline(always)]
    fn along(&self, [i, j, k]: [i32; 3]) -> [i32; 3] {
        let [x, y, z] = &self.half_edges;
        let ([xu, xv, xd], [yu, yv, yd], [zu, zv, zd]) = (x, y, z);
        [
            xu * i + yu * j + zu * k,
            xv * i + yv * j + zv * k,
            xd * i + yd * j + zd * k,
        ]
    }
}

/// Rounds from `Q` bits after the point, and packs.
#[inline(always)]
pub(super) fn pack<const Q: u32>(place: [i32; 3]) -> u32 {
    let [u, v, d] = place.map(|c| ((c + (1 << (Q - 1))) >> Q) as u32);
    u.wrapping_add(v << ACROSS).wrapping_add(d << DEPTH)
}

/// Units to a side of the scene's cube, Q16: across and in depth.
fn scale(light: &LightSpace, size: MapSize) -> [i64; 2] {
    let (across, depth) = light.extents();
    let texel = 1 << (ACROSS - size.bits());
    let room = (1 << ACROSS) - 2 * MARGIN * texel;
    [
        (i64::from(room) << 32) / i64::from(across),
        (i64::from(DEPTHS - DEPTHS / 16) << 32) / i64::from(depth),
    ]
}

/// The same to a side of an instance's cube.
fn of_instance(scale: i64, instance: &Instance) -> i64 {
    (scale * i64::from(instance.scale.to_bits())) >> 30
}

/// Texels to a cell's side, Q8, of an instance's grid of so many cells an axis.
pub(super) fn texels(light: &LightSpace, size: MapSize, instance: &Instance, cells: u32) -> u32 {
    let [across, _] = scale(light, size).map(|scale| of_instance(scale, instance));
    ((across >> (8 + ACROSS - size.bits())) / i64::from(cells)) as u32
}

impl ShadowView {
    /// Tables not yet filled.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            centre: [0; 3],
            levels: [LevelView::NONE; MAX_SUBDIVISIONS + 1],
            displacements: [0; DISPLACEMENTS],
            moved: Moved::NONE,
        }
    }

    /// Fills the tables for the samples of `level` of an instance's grid, which `light` holds, and maps of
    /// this size.
    pub fn prepare(
        &mut self,
        light: &LightSpace,
        size: MapSize,
        instance: &Instance,
        (grid, level): (&Grid<'_>, usize),
        bias: Bias,
    ) {
        let local = light.local(instance);
        let [across, depth] = scale(light, size);
        let scales = [across, across, depth];
        // The middle of what is held is the map's.
        let middles = [1 << (ACROSS + 15), 1 << (ACROSS + 15), DEPTHS << 15];
        let bounds = light.bounds.iter().zip(scales).zip(middles);
        let bounds = bounds.zip(local.centre);
        for (centre, ((((low, high), scale), middle), own)) in self.centre.iter_mut().zip(bounds) {
            *centre = middle + ((i64::from(2 * own - low - high) * scale) >> 17) as i32;
        }
        let [across, depth] = [across, depth].map(|scale| of_instance(scale, instance));
        let scales = [across, across, depth];
        let edge = |axis: usize| {
            let mut edge = [0i64; 3];
            for ((edge, row), scale) in edge.iter_mut().zip(local.axes).zip(scales) {
                *edge = (i64::from(row.get(axis).copied().unwrap_or(0)) * scale) >> 14;
            }
            edge
        };
        let edges = [edge(0), edge(1), edge(2)];
        let mut first = 0;
        let mut rho = 1;
        let mut above = LevelView {
            cells: 1,
            ..LevelView::NONE
        };
        for (level, slot) in self.levels.iter_mut().enumerate() {
            let cells = above.cells * rho;
            let half_edges = edges.map(|e| e.map(|c| (c / i64::from(2 * cells)) as i32));
            *slot = LevelView {
                cells,
                half_edges,
                first,
            };
            // Of the level above, whose cells these are the subcells of.
            let subcells = if level == 0 { 0 } else { rho * rho * rho };
            for n in 0..subcells {
                let place = [n % rho, n / rho % rho, n / (rho * rho)].map(|p| 2 * p + 1 - rho);
                let at = above.first + n as usize;
                if let Some(d) = self.displacements.get_mut(at) {
                    *d = pack::<16>(slot.along(place));
                }
            }
            first += subcells as usize;
            slot.first = first;
            above = *slot;
            let Some(nodes) = grid.levels().get(level) else {
                break;
            };
            rho = i32::from(nodes.rho);
        }
        let lengths = Lengths {
            texel: 1 << (8 + ACROSS - size.bits()),
            cell: (across >> 8) as i32 / grid.cells(level) as i32,
            scale: [across, depth],
        };
        self.moved.fill(grid.layout(), &local.axes, lengths, bias);
    }

    /// The place of a cell's centre, each coordinate rounded once.
    #[inline(never)]
    pub(in crate::render) fn place(&self, level: usize, cell: [i32; 3]) -> u32 {
        let level = self.levels.get(level).unwrap_or(&LevelView::NONE);
        let [u, v, d] = level.along(cell.map(|p| 2 * p + 1 - level.cells));
        let [cu, cv, cd] = self.centre;
        pack::<16>([cu + u, cv + v, cd + d])
    }

    /// From the centre of a cell of `level` to its subcells'; each coordinate rounded once.
    pub(in crate::render) fn displacements(&self, level: usize) -> &[u32] {
        let first = self.levels.get(level).map_or(0, |level| level.first);
        self.displacements.get(first..).unwrap_or_default()
    }

    /// From their cells' centres to where samples are.
    #[inline(always)]
    pub(super) fn moved(&self) -> &Moved {
        &self.moved
    }
}
