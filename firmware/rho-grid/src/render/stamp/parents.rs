//! The parents of a block, whose subcells are stamped.

use super::lists::{FIRST, Order};
use crate::blob::{Attributes, Grid, Level};
use crate::render::order;
use crate::render::project::Homogeneous;

/// Most parents of a block: it is divided by 5.
pub(super) const MAX_PARENTS: usize = 125;

/// A block in the light ([`ShadowView`](crate::render::ShadowView)).
#[derive(Clone, Copy)]
pub(in crate::render) struct InLight<'a> {
    /// Its centre.
    pub(in crate::render) at: u32,
    /// From there to its parents.
    pub(in crate::render) parents: &'a [u32],
    /// From each of them to its subcells.
    pub(in crate::render) cells: &'a [u32; 27],
}

/// The cells of a block, or some of them: each is divided by 3, and its subcells are stamped.
#[derive(Clone, Copy)]
pub(in crate::render) struct Parents<'a, 'g> {
    /// The block's centre.
    pub(in crate::render) centre: Homogeneous,
    /// From there to its subcells.
    pub(in crate::render) displacements: &'a [Homogeneous],
    /// Exponent of the projection ([`project`](crate::render::project)).
    pub(in crate::render) k: u32,
    /// The parents' level.
    pub(in crate::render) level: &'a Level<'g>,
    /// The first of the block's parents in it.
    pub(in crate::render) first: u32,
    /// What they are cells of.
    pub(in crate::render) grid: &'g Grid<'g>,
    /// The first attribute word of the level of their subcells.
    pub(in crate::render) first_word: u32,
    /// Subcells of the block's division.
    #[cfg_attr(
        not(rho_thumb),
        allow(dead_code, reason = "part of an argument of safety")
    )]
    pub(in crate::render) subcells: usize,
    /// The block in the light, if that matters.
    pub(in crate::render) light: Option<InLight<'a>>,
    /// From front to back.
    pub(in crate::render) order: &'a ParentList,
}

impl<'g> Parents<'_, 'g> {
    /// Attribute words of the level of their subcells.
    #[inline(always)]
    pub(super) fn words(&self) -> Attributes<'g> {
        self.grid.attributes().after(self.first_word)
    }

    /// The cone of parent `node`, if the blob tells.
    #[inline(always)]
    pub(super) fn cone(&self, node: u32) -> Option<u16> {
        self.level.cones.get(node as usize).copied()
    }
}

/// The parents of a block from front to back: from the lowest bit, the parent's rank among the block's, eight bits,
/// its subcell, eight, and the [`Order`] of its own subcells.
#[derive(Clone, Copy)]
pub(in crate::render) struct ParentList {
    entries: [u32; MAX_PARENTS],
    count: usize,
}

impl ParentList {
    /// No parents.
    pub(in crate::render) const EMPTY: Self = Self {
        entries: [0; MAX_PARENTS],
        count: 0,
    };

    /// Those that are listed.
    #[inline(always)]
    pub(in crate::render) fn entries(&self) -> &[u32] {
        self.entries.get(..self.count).unwrap_or_default()
    }

    /// Lists the parents in `mask` of a block divided by `rho`; `eye` is the eye's slab among all their subcells.
    #[inline(always)]
    pub(in crate::render) fn list(&mut self, rho: u8, mask: [u32; 4], eye: [i32; 3]) {
        let last = 3 * i32::from(rho) - 1;
        if !eye.iter().all(|e| *e < 1 || *e >= last) {
            return self.round_the_eye(rho, mask, eye);
        }
        let descending = eye.map(|e| e >= last);
        match (rho, mask) {
            (3, [mask, ..]) => self.outside_of_27(mask, descending),
            _ => self.outside(rho, mask, descending),
        }
    }

    /// Of a block that the eye sees from outside: the subcells of all parents have the same order.
    #[inline(never)]
    fn outside(&mut self, rho: u8, mask: [u32; 4], descending: [bool; 3]) {
        let order = Order::new(descending).bits() << 16;
        let eye = descending.map(|d| if d { i32::from(rho) } else { -1 });
        let mut slots = self.entries.iter_mut();
        order::Order::each_row(rho, eye, &mask, |_, first, cells| {
            let row = order | u32::from(first.subcell()) << 8 | first.rank();
            for ((i, rank), slot) in cells.zip(&mut slots) {
                *slot = row + (i << 8) + rank;
            }
        });
        self.count = MAX_PARENTS - slots.len();
    }

    /// The same of 3 x 3 x 3, from tables.
    #[inline(always)]
    fn outside_of_27(&mut self, mask: u32, descending: [bool; 3]) {
        let order = Order::new(descending);
        let (low, mid, high) = (
            order.cells(mask),
            order.cells(mask >> 9),
            order.cells(mask >> 18),
        );
        let ranks = [0, low.1, low.1 + mid.1];
        let planes = [(low, 0, ranks[0]), (mid, 9, ranks[1]), (high, 18, ranks[2])];
        let mut slots = self.entries.iter_mut();
        for ((cells, count), plane, ranks) in order.planes(planes) {
            let mut add = |entry: &u8| {
                let entry = u32::from(*entry);
                let subcell = (entry & 15) - FIRST + plane;
                if let Some(slot) = slots.next() {
                    *slot = order.bits() << 16 | subcell << 8 | ((entry >> 4) + ranks as u32);
                }
            };
            let cells = cells.iter().take(count);
            if order.is_backwards() {
                cells.rev().for_each(&mut add);
            } else {
                cells.for_each(&mut add);
            }
        }
        self.count = MAX_PARENTS - slots.len();
    }

    /// Of any block.
    #[inline(never)]
    fn round_the_eye(&mut self, rho: u8, mask: [u32; 4], eye: [i32; 3]) {
        // By 3; of five parents' cells and those beside them a product is as good as the quotient.
        let third = |e: i32| (((e + 3) * 171) >> 9) - 1;
        let eye = eye.map(|e| e.clamp(-2, 16));
        // Of each axis, how many of the parents have the eye beyond their middle.
        let [beyond_x, beyond_y, beyond_z] = eye.map(|e| third(e + 1).max(0) as u32);
        let mut slots = self.entries.iter_mut();
        order::Order::each_row(rho, eye.map(third), &mask, |[j, k], first, cells| {
            let order = Order::new([false, j < beyond_y, k < beyond_z]).bits();
            let row = order << 16 | u32::from(first.subcell()) << 8 | first.rank();
            for ((i, rank), slot) in cells.zip(&mut slots) {
                let beyond = u32::from(i < beyond_x) * Order::OPPOSITE;
                *slot = (row + (i << 8) + rank) ^ beyond << 16;
            }
        });
        self.count = MAX_PARENTS - slots.len();
    }

    /// Lists those of `all` in some of the block's subcells, in the same order.
    pub(in crate::render) fn take(&mut self, all: &Self, is_wanted: impl Fn(u8) -> bool) {
        let wanted = |entry: &&u32| is_wanted((**entry >> 8) as u8);
        self.count = 0;
        for (slot, entry) in self
            .entries
            .iter_mut()
            .zip(all.entries().iter().filter(wanted))
        {
            *slot = *entry;
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The entries one by one, by quotients.
    fn listed(rho: u8, mask: &[u32; 4], eye: [i32; 3]) -> Vec<u32> {
        let mut list = [order::Listed::default(); MAX_PARENTS];
        let eye_of_parents = eye.map(|e| e.div_euclid(3));
        let count = order::Order::list(rho, eye_of_parents, mask, &mut list);
        let entry = |listed: &order::Listed| {
            let place = order::place(rho, listed.subcell());
            // The eye is beyond the middle of the parent's three subcells.
            let beyond = core::array::from_fn(|d| eye[d] > 3 * place[d] + 1);
            Order::new(beyond).bits() << 16 | u32::from(listed.subcell()) << 8 | listed.rank()
        };
        list[..count].iter().map(entry).collect()
    }

    proptest! {
        #[test]
        fn parents_are_listed_with_rank_and_order_wherever_the_eye_is(
            mask: u128, eye in prop::array::uniform3(-40..60i32)
        ) {
            for rho in 2..=5u8 {
                let mask = mask & u128::MAX >> (128 - u32::from(rho).pow(3));
                let words = [0, 32, 64, 96].map(|s| (mask >> s) as u32);
                let mut list = ParentList::EMPTY;
                list.list(rho, words, eye);
                prop_assert_eq!(list.entries(), listed(rho, &words, eye), "{} {:?}", rho, eye);
            }
        }

        #[test]
        fn parts_of_a_list_keep_its_order_and_together_are_all_of_it(mask: u64, eye in 0..12i32) {
            let mut all = ParentList::EMPTY;
            all.list(4, [mask as u32, (mask >> 32) as u32, 0, 0], [eye; 3]);
            let mut parts = [ParentList::EMPTY; 2];
            for (part, upper) in parts.iter_mut().zip([false, true]) {
                part.take(&all, |subcell| (subcell >= 32) == upper);
            }
            for (part, upper) in parts.iter().zip([false, true]) {
                let of_all = all.entries().iter().filter(|entry| (**entry >> 8 & 255 >= 32) == upper);
                prop_assert!(part.entries().iter().eq(of_all));
            }
        }
    }
}
