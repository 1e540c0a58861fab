//! The walk through the grid.
//!
//! ```text
//! stack: the open cells from the root down, each with its non-empty subcells in order
//! take the next subcell of the innermost open cell; none left: close it
//!   bounds on the screen; beyond the frame, or all that it reaches is covered: leave it
//!   a leaf, or small enough: draw its sample
//!   else open it
//! a cell whose grandchildren are all drawn is a block: they are drawn in one loop
//! ```
//!
//! It is the paper's recursive Render (sections 5.1, 5.2) with a stack of its own, bounded by the
//! number of subdivisions, in the order of [`super::order`]. Departures: the extent is bounded a
//! parent, not a cell, and exactly ([`View::half`]); within a block the leaves stand at affine
//! steps from their parents, with a bound on the error ([`View::steps`]); near the eye,
//! where neither holds well, each cell is bounded alone, also by interval arithmetic, which needs
//! no projection (a division by next to nothing), so that nothing overflows, nothing in view is
//! lost and nothing small looks large.

mod bounds;
mod stamped;

use super::disc::Discs;
use super::footprint::{Footprint, Pixels};
use super::order::{self, List, Listed, Order};
use super::project::{Bounds, Homogeneous};
use super::shadow::ShadowView;
use super::stamp::{self, Kind, Stamps};
use super::view::{Half, LevelView, Slabs, Step, Steps, View};
use super::visibility::{Rect, Visibility};
use crate::blob::format::MAX_SUBDIVISIONS;
use crate::blob::{Grid, Level};
use crate::reciprocal::Reciprocal;
use crate::shading::Shade;

/// A cell whose subcells are being visited.
#[derive(Clone, Copy, Debug)]
struct Open {
    centre: Homogeneous,
    /// Place among the cells of its level.
    place: [i32; 3],
    /// Number of its first child within the next level.
    first_child: u32,
    /// Half extents of its children, or `None` when they may be too near to be projected.
    half: Option<Half>,
    list: List,
    count: u8,
    next: u8,
}

impl Open {
    const NONE: Self = Self {
        centre: Homogeneous::ZERO,
        place: [0; 3],
        first_child: 0,
        half: None,
        list: [Listed::ZERO; size_of::<List>() / size_of::<Listed>()],
        count: 0,
        next: 0,
    };

    /// Lists the children of `node` in order; returns their mask.
    #[inline(never)]
    fn order(&mut self, nodes: &Level<'_>, node: u32, eye: [i32; 3]) -> [u32; 4] {
        let mask = nodes.mask_any(node);
        self.count = Order::list(nodes.rho, eye, &mask, &mut self.list) as u8;
        mask
    }
}

/// A cell to be opened or drawn.
#[derive(Clone, Copy)]
struct Cell {
    /// Number within its level.
    node: u32,
    centre: Homogeneous,
    place: [i32; 3],
    bounds: Bounds,
}

/// What the cells of a level within one cell share.
struct Group {
    steps: Steps,
    discs: Discs,
}

impl Group {
    #[inline(always)]
    fn stencil<F: Footprint>(&self, rho: u8, inside: bool) -> Stencil<F> {
        // Of discs, what any of them may reach.
        let half = if F::DISCS {
            self.discs.reach()
        } else {
            self.steps.half
        };
        Stencil {
            slabs: self.steps.slabs(rho),
            footprint: F::of::<16>(half.x, half.y),
            discs: self.discs,
            inside,
        }
    }
}

/// How the children of a group's parents are drawn.
struct Stencil<F> {
    slabs: Slabs,
    footprint: F,
    discs: Discs,
    /// No sample reaches the frame's edge.
    inside: bool,
}

/// A cell whose children are all drawn.
struct Parent {
    /// On the screen, Q16.
    centre: Step,
    /// Among the cells of its level.
    place: [i32; 3],
    w: i32,
    /// Number of the first child over all levels.
    first: u32,
    mask: [u32; 4],
}

struct Walk<'g, 'v, V, S> {
    grid: &'g Grid<'g>,
    view: &'v View,
    shading: &'v S,
    target: &'v mut V,
    /// How samples are stamped, if their layout can be.
    kind: Option<Kind>,
    stamps: Stamps<'v>,
    parents: stamp::ParentList,
}

/// Draws `grid` as `view` (prepared for it) sees it.
///
/// Every loop is bounded by the number of nodes; the stack is bounded by the subdivisions. Returns
/// the pixels that the cube may reach.
// Not joined into its callers: the frames of several ways to draw would stand on the stack together.
#[inline(never)]
pub fn draw<V: Visibility, F: Footprint, R: Reciprocal>(
    grid: &Grid<'_>,
    view: &View,
    shading: &impl Shade,
    target: &mut V,
) -> Option<Rect> {
    Walk {
        grid,
        view,
        shading,
        target,
        kind: Kind::of(grid.layout()).filter(|_| !meets(shading)),
        stamps: Stamps::new(view, grid.layout()),
        parents: stamp::ParentList::EMPTY,
    }
    .run::<F, R>()
}

/// Whether samples must come one by one in the order of a light.
fn meets<S: Shade>(_: &S) -> bool {
    S::MEETS
}

impl<'g, 'v, V: Visibility, S: Shade> Walk<'g, 'v, V, S> {
    fn run<F: Footprint, R: Reciprocal>(&mut self) -> Option<Rect> {
        let mut stack = [Open::NONE; MAX_SUBDIVISIONS];
        let root = self.root::<R>()?;
        let overhang = self.level(0).overhang;
        let reach = self.clip(F::reach(root.bounds, overhang))?;
        // How many cells are open; the innermost is stack[open - 1], a cell of level open - 1.
        let mut open = usize::from(self.enter::<F, R>(root, 0, &mut stack));
        while let Some(level) = open.checked_sub(1) {
            let parent = stack.get_mut(level)?;
            if parent.next == parent.count {
                open = level;
                continue;
            }
            let listed = parent.list.get(usize::from(parent.next));
            let listed = listed.copied().unwrap_or_default();
            parent.next += 1;
            let Some((cell, pixels)) = self.subcell::<F, R>(parent, level, listed) else {
                if S::MEETS {
                    let parent = *parent;
                    self.meet_below(&parent, level, listed);
                }
                continue;
            };
            let child_level = level + 1;
            if F::DISCS && !S::MEETS && self.faces_away(&cell, child_level) {
                continue;
            }
            let leaf = child_level == self.grid.subdivisions();
            if leaf || self.level(child_level).stop_w <= cell.centre.w {
                let first = self.first(child_level);
                self.sample::<F>(&cell, child_level, first + cell.node);
            } else if S::MEETS || !self.is_behind(pixels, cell.centre, child_level) {
                open += usize::from(self.enter::<F, R>(cell, child_level, &mut stack));
            }
        }
        Some(reach)
    }

    /// Meets the samples of a subcell of a cell of `level` that is out of sight.
    #[cold]
    fn meet_below(&self, parent: &Open, level: usize, listed: Listed) {
        let rho = self.grid.levels().get(level).map_or(2, |nodes| nodes.rho);
        let [i, j, k] = order::place(rho, listed.subcell());
        let [x, y, z] = parent.place.map(|p| p * i32::from(rho));
        let node = parent.first_child + listed.rank();
        let place = [x + i, y + j, z + k];
        self.shading.meet_below(self.grid, level + 1, node, place);
    }

    /// Whether all samples of a cell of `level` face away, and no back shows.
    #[inline(always)]
    fn faces_away(&self, cell: &Cell, level: usize) -> bool {
        if !self.view.no_backs {
            return false;
        }
        let nodes = self.grid.levels().get(level);
        let cone = nodes.and_then(|nodes| nodes.cones.get(cell.node as usize));
        cone.is_some_and(|cone| self.view.faces_away(*cone, &cell.bounds))
    }

    /// Whether a cell of `level` that reaches these pixels is behind what is drawn.
    #[inline(always)]
    fn is_behind(&self, pixels: Rect, centre: Homogeneous, level: usize) -> bool {
        let nearest = centre.w - self.level(level).half.w;
        self.target.is_behind(pixels, nearest)
    }

    /// The whole cube; `None` when it is behind the eye.
    fn root<R: Reciprocal>(&self) -> Option<Cell> {
        let centre = self.view.root;
        let level = self.level(0);
        let bounds = if centre.w - level.half.w >= self.view.near {
            let (x, y) = self.on_screen::<R>(centre);
            let nearest = centre.w - level.half.w;
            let half = self.view.half::<R>(level, [x, y], Half::default(), nearest);
            self.bounds(x, y, half)
        } else {
            self.near_bounds::<R>(centre, level)?
        };
        Some(Cell {
            node: 0,
            centre,
            place: [0; 3],
            bounds,
        })
    }

    /// Opens a cell, or draws all that is below it at once; whether there is now one more open.
    #[inline(always)]
    fn enter<F: Footprint, R: Reciprocal>(
        &mut self,
        cell: Cell,
        level: usize,
        stack: &mut [Open; MAX_SUBDIVISIONS],
    ) -> bool {
        let (Some(nodes), Some(open)) = (self.grid.levels().get(level), stack.get_mut(level))
        else {
            return false;
        };
        let children = self.level(level + 1);
        open.centre = cell.centre;
        open.place = cell.place;
        open.first_child = nodes.first_child(cell.node);
        open.next = 0;
        if F::DISCS && self.stamps_all::<R>(open, &cell, level) {
            return false;
        }
        let eye = self.eye_slab(children, cell.place, i32::from(nodes.rho));
        let mask = open.order(nodes, cell.node, eye);

        let own = Half {
            x: cell.bounds.half_x,
            y: cell.bounds.half_y,
        };
        let (mx, my) = self.middle();
        let axis = [cell.bounds.x - mx, cell.bounds.y - my];
        let dw = self.level(level).half.w;
        let nearest = cell.centre.w - dw;
        // What the children share is taken at the smallest W of all: at most twice too wide here,
        // and without bound nearer to the eye, where each child has its own.
        open.half = (nearest >= self.view.near.max(3 * dw))
            .then(|| self.view.half::<R>(children, axis, own, nearest));

        let (Some(half), subdivisions) = (open.half, self.grid.subdivisions()) else {
            return true;
        };
        let drawn = |level: usize| level == subdivisions || self.level(level).stop_w <= nearest;
        let w = cell.centre.w;
        if drawn(level + 1) {
            // A leaf parent that no block has drawn: on coarse grids, or near the eye.
            // 2 stands for a parent alone, however divided: see View::steps.
            let Some(group) = self.group::<F, R>(level, level + 1, axis, own, w, 2) else {
                return true;
            };
            self.alone::<F>(open.first_child, mask, nodes.rho, &cell, level, &group);
            return false;
        }
        // A block: every child is opened, every grandchild is drawn.
        if !drawn(level + 2) || children.stop_w <= w + dw {
            return true;
        }
        let rho = i32::from(nodes.rho);
        let bounds = &cell.bounds;
        let Some(group) = self.group::<F, R>(level, level + 2, axis, own, w, rho) else {
            return true;
        };
        self.block::<F, R>(open, half, level, &group, bounds);
        false
    }

    /// What cells of level `cells` within a cell of `level` share; `None` when that is too near, or
    /// its discs are too large for their numbers.
    #[inline(always)]
    fn group<F: Footprint, R: Reciprocal>(
        &self,
        level: usize,
        cells: usize,
        axis: [i32; 2],
        own: Half,
        w: i32,
        rho: i32,
    ) -> Option<Group> {
        let (outer, inner) = (self.level(level), self.level(cells));
        let steps = self.view.steps::<R>(outer, inner, axis, own, w, rho)?;
        let discs = if F::DISCS {
            Discs::new(&steps.steps, self.grid.layout())?
        } else {
            Discs::NONE
        };
        Some(Group { steps, discs })
    }

    /// Draws the children in `mask` of a cell of `level`, divided by `rho`.
    #[inline(never)]
    fn alone<F: Footprint>(
        &mut self,
        first_child: u32,
        mask: [u32; 4],
        rho: u8,
        cell: &Cell,
        level: usize,
        group: &Group,
    ) {
        let children = self.level(level + 1);
        let from = Parent {
            centre: Step {
                x: cell.bounds.x << 8,
                y: cell.bounds.y << 8,
            },
            place: cell.place,
            w: cell.centre.w,
            first: self.first(level + 1) + first_child,
            mask,
        };
        let eye = self.eye_slab(children, cell.place, rho.into());
        let inside = self.is_inside(&cell.bounds, group.steps.half, self.view.rows);
        let stencil = group.stencil::<F>(rho, inside);
        self.samples::<F>(&from, level, Order::new(rho, eye), &stencil);
    }

    /// The eye's slab among the subcells of a cell at `place`, if the order matters.
    #[inline(always)]
    fn eye_slab(&self, children: &LevelView, place: [i32; 3], rho: i32) -> [i32; 3] {
        if S::MEETS {
            return self
                .shading
                .higher()
                .map(|higher| if higher { rho } else { -1 });
        }
        if !V::FRONT_TO_BACK {
            return [0; 3];
        }
        let [ex, ey, ez] = children.eye;
        let [px, py, pz] = place;
        [ex - px * rho, ey - py * rho, ez - pz * rho]
    }

    /// Draws the grandchildren of an open cell of `level`.
    ///
    /// Each child is projected exactly; within it, the block's steps lead to its subcells.
    fn block<F: Footprint, R: Reciprocal>(
        &mut self,
        open: &Open,
        half: Half,
        level: usize,
        group: &Group,
        bounds: &Bounds,
    ) {
        let Some([nodes, below]) = self.two_levels(level) else {
            return;
        };
        let view = self.view;
        let displacements = view.displacements(self.level(level));
        let grandchildren = self.level(level + 2);
        let first = self.first(level + 2);
        let (mx, my) = self.middle();
        let rho = i32::from(nodes.rho);
        let [ox, oy, oz] = open.place.map(|p| p * rho);

        let overhang = self.level(level + 1).overhang;
        let inside = self.is_inside(bounds, group.steps.half, self.view.rows);
        let stencil = group.stencil::<F>(below.rho, inside);
        for &listed in open.list.iter().take(usize::from(open.count)) {
            let subcell = listed.subcell();
            let Some(d) = displacements.get(usize::from(subcell)) else {
                continue;
            };
            let centre = open.centre.plus(*d);
            let (x, y) = self.on_screen::<R>(centre);
            let (x, y) = (x + mx, y + my);
            let bounds = Bounds {
                x,
                y,
                half_x: half.x,
                half_y: half.y,
            };
            let Some(rect) = self.clip(F::reach(bounds, overhang)) else {
                if S::MEETS {
                    self.meet_below(open, level, listed);
                }
                continue;
            };
            if !S::MEETS && self.is_behind(rect, centre, level + 1) {
                continue;
            }
            let node = open.first_child + listed.rank();
            let [i, j, k] = order::place(nodes.rho, subcell);
            let place = [ox + i, oy + j, oz + k];
            let eye = self.eye_slab(grandchildren, place, below.rho.into());
            let from = Parent {
                centre: Step {
                    x: x << 8,
                    y: y << 8,
                },
                place,
                w: centre.w,
                first: first + below.first_child(node),
                mask: below.mask_any(node),
            };
            self.samples::<F>(&from, level + 1, Order::new(below.rho, eye), &stencil);
        }
    }

    /// Draws all children of a cell of `level`.
    #[inline(always)]
    fn samples<F: Footprint>(
        &mut self,
        parent: &Parent,
        level: usize,
        order: Order,
        stencil: &Stencil<F>,
    ) {
        let view = self.view;
        let displacements = view.displacements(self.level(level));
        let (grid, shading) = (self.grid, self.shading);
        let slabs = &stencil.slabs;
        let light = shading.light();
        let light =
            light.map(|light| (light.place(level, parent.place), light.displacements(level)));
        for (k, plane) in order.planes(&parent.mask) {
            let from = parent.centre.plus(slabs.along::<2>(k));
            for (j, row) in order.rows(plane) {
                let from = from.plus(slabs.along::<1>(j));
                let subcells = order.row(j, k);
                let first = parent.first + order::rank(&parent.mask, subcells as u8);
                for (i, rank) in order.cells(row) {
                    let at = from.plus(slabs.along::<0>(i));
                    let subcell = (subcells + i) as u8;
                    let word = || grid.attribute(first + rank);
                    let place = |(place, displacements): (u32, &[u32])| {
                        let d = displacements.get(usize::from(subcell)).copied();
                        place.wrapping_add(d.unwrap_or(0))
                    };
                    let met = light.filter(|_| S::MEETS).map(place);
                    let met = met.map(|place| shading.meet(word(), place));
                    let colour = |word: u32| match (met, light) {
                        (Some(met), _) => met,
                        (None, None) => shading.colour(word),
                        (None, Some(light)) => shading.colour_at(word, place(light)),
                    };
                    if F::DISCS {
                        self.disc(stencil, at, parent.w, word, colour);
                        continue;
                    }
                    let pixels = stencil.footprint.cover::<16>(at.x, at.y);
                    let rect = if stencil.inside {
                        pixels.rect()
                    } else {
                        self.clip(pixels)
                    };
                    let Some(rect) = rect else {
                        continue;
                    };
                    let d = displacements.get(usize::from(subcell));
                    let w = parent.w + d.map_or(0, |d| d.w);
                    self.target.draw(rect, w, || colour(word()));
                }
            }
        }
    }

    /// Draws a sample as a disc.
    #[inline(always)]
    fn disc<F: Footprint>(
        &mut self,
        stencil: &Stencil<F>,
        at: Step,
        w: i32,
        word: impl FnOnce() -> u32,
        colour: impl Fn(u32) -> u16,
    ) {
        let pixels = stencil.footprint.cover::<16>(at.x, at.y);
        let rect = if stencil.inside {
            pixels.rect()
        } else {
            self.clip(pixels)
        };
        match rect {
            Some(rect) if !self.target.is_behind(rect, w) => {}
            _ => return,
        }
        let word = word();
        let ellipse = stencil.discs.ellipse(at, word);
        let half = ellipse.half();
        let c = ellipse.centre;
        // The pixels whose centres lie within the half extents.
        let first = |c: i32, half: i32| (c - half + 32767) >> 16;
        let last = |c: i32, half: i32| (c + half - 32768) >> 16;
        let pixels = Pixels {
            x: (first(c.x, half.x), last(c.x, half.x)),
            y: (first(c.y, half.y), last(c.y, half.y)),
        };
        let Some(rect) = self.clip(pixels) else {
            return;
        };
        self.target.draw_shape(rect, w, &ellipse, || colour(word));
    }

    /// One subcell of an open cell, and the pixels that it may reach; `None` when there are none.
    #[inline(always)]
    fn subcell<F: Footprint, R: Reciprocal>(
        &self,
        parent: &Open,
        level: usize,
        listed: Listed,
    ) -> Option<(Cell, Rect)> {
        let subcell = listed.subcell();
        let displacements = self.view.displacements(self.level(level));
        let centre = parent
            .centre
            .plus(displacements.get(usize::from(subcell)).copied()?);
        let bounds = match parent.half {
            Some(half) => {
                let (x, y) = self.on_screen::<R>(centre);
                self.bounds(x, y, half)
            }
            None => self.near_bounds::<R>(centre, self.level(level + 1))?,
        };
        let overhang = self.level(level + 1).overhang;
        let reach = self.clip(F::reach(bounds, overhang))?;
        let rho = self.grid.levels().get(level)?.rho;
        let [i, j, k] = order::place(rho, subcell);
        let [px, py, pz] = parent.place.map(|p| p * i32::from(rho));
        let cell = Cell {
            node: parent.first_child + listed.rank(),
            centre,
            place: [px + i, py + j, pz + k],
            bounds,
        };
        Some((cell, reach))
    }

    /// Draws a cell from its own sample.
    #[inline(always)]
    fn sample<F: Footprint>(&mut self, cell: &Cell, level: usize, node: u32) {
        let (grid, shading) = (self.grid, self.shading);
        let Bounds {
            x,
            y,
            half_x,
            half_y,
        } = cell.bounds;
        let light = shading.light();
        let place = |light: &ShadowView| light.place(level, cell.place);
        let met = light.filter(|_| S::MEETS);
        let met = met.map(|light| shading.meet(grid.attribute(node), place(light)));
        if let Some(rect) = self.clip(F::of::<8>(half_x, half_y).cover::<8>(x, y)) {
            self.target
                .draw(rect, cell.centre.w, || match (met, light) {
                    (Some(met), _) => met,
                    (None, None) => shading.colour(grid.attribute(node)),
                    (None, Some(light)) => shading.colour_at(grid.attribute(node), place(light)),
                });
        }
    }

    #[inline(always)]
    fn level(&self, level: usize) -> &'v LevelView {
        static NONE: LevelView = LevelView::NONE;
        let view = self.view;
        view.levels.get(level).unwrap_or(&NONE)
    }

    /// The nodes of `level` and of the one below it, if both have children.
    #[inline(always)]
    fn two_levels(&self, level: usize) -> Option<&'g [Level<'g>; 2]> {
        self.grid.levels().get(level..level + 2)?.first_chunk()
    }

    /// Number over all levels of the first node of `level`.
    #[inline(always)]
    fn first(&self, level: usize) -> u32 {
        match self.grid.levels().get(level) {
            Some(nodes) => nodes.first,
            None => self.grid.first_leaf(),
        }
    }
}
