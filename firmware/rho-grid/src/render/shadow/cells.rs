//! A walk through the cells of a grid, by their places alone.

use crate::blob::Grid;
use crate::blob::format::MAX_SUBDIVISIONS;
use crate::render::order;

/// A cell on the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) level: usize,
    /// Number within its level.
    pub(super) node: u32,
    /// Place among the cells of its level.
    pub(super) place: [i32; 3],
}

/// Subcells that a mask names, from the lowest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subcells {
    words: [u32; 4],
    /// The first subcell of the first word.
    first: u32,
}

impl Subcells {
    pub(super) fn of(words: [u32; 4]) -> Self {
        Self { words, first: 0 }
    }
}

impl Iterator for Subcells {
    type Item = u32;

    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        loop {
            let [word, b, c, d] = self.words;
            if word != 0 {
                self.words = [word & (word - 1), b, c, d];
                return Some(self.first + word.trailing_zeros());
            }
            if b | c | d == 0 {
                return None;
            }
            self.words = [b, c, d, 0];
            self.first += 32;
        }
    }
}

/// An open cell.
#[derive(Clone, Copy)]
struct Open {
    /// Subcells still to come.
    subcells: Subcells,
    /// The next one's number within its level.
    child: u32,
    /// The place of the cell's first subcell.
    place: [i32; 3],
    rho: u8,
}

impl Open {
    const NONE: Self = Self {
        subcells: Subcells {
            words: [0; 4],
            first: 0,
        },
        child: 0,
        place: [0; 3],
        rho: 2,
    };
}

/// Visits the cells of `grid`: a cell, and when `enter` says so its subcells.
pub(super) fn walk(grid: &Grid<'_>, enter: impl FnMut(Cell) -> bool) {
    let root = Cell {
        level: 0,
        node: 0,
        place: [0; 3],
    };
    walk_from(root, grid, enter);
}

/// The same from a cell on.
pub(super) fn walk_from(from: Cell, grid: &Grid<'_>, mut enter: impl FnMut(Cell) -> bool) {
    let mut stack = [Open::NONE; MAX_SUBDIVISIONS];
    let mut cell = from;
    // The cells that are open, those of each level at its number less the first one's.
    let mut open = 0;
    loop {
        if enter(cell)
            && let (Some(nodes), Some(slot)) =
                (grid.levels().get(from.level + open), stack.get_mut(open))
        {
            *slot = Open {
                subcells: Subcells::of(nodes.mask_any(cell.node)),
                child: nodes.first_child(cell.node),
                place: cell.place.map(|p| p * i32::from(nodes.rho)),
                rho: nodes.rho,
            };
            open += 1;
        }
        cell = loop {
            let Some(slot) = open.checked_sub(1).and_then(|at| stack.get_mut(at)) else {
                return;
            };
            let Some(subcell) = slot.subcells.next() else {
                open -= 1;
                continue;
            };
            let node = slot.child;
            slot.child += 1;
            let [i, j, k] = order::place(slot.rho, subcell as u8);
            let [x, y, z] = slot.place;
            break Cell {
                level: from.level + open,
                node,
                place: [x + i, y + j, z + k],
            };
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec::Vec;

    #[test]
    fn subcells_are_those_of_the_mask_from_the_lowest() {
        let words = [1 << 31, 0, 0b101, 1 << 28];
        let found: Vec<u32> = Subcells::of(words).collect();
        assert_eq!(found, [31, 64, 66, 124]);
        assert_eq!(Subcells::of([0; 4]).next(), None);
    }
}
