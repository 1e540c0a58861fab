//! The cells of a plane of 3 x 3 in order, from a table.

/// The cells of a plane: how many, then one each: [`FIRST`] and its number in the lower four bits,
/// and its rank among the cells of the plane above them.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct List([u8; 10]);

/// What the number of a plane's first cell is in a list.
pub(super) const FIRST: u32 = 2;

/// The lists of all planes, for one way along x while y grows.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct Lists([List; 512]);

#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const fn lists(towards_lower_x: bool) -> Lists {
    let mut lists = [List([0; 10]); 512];
    let mut plane = 0;
    while plane < 512 {
        let list = &mut lists[plane].0;
        let mut step = 0;
        while step < 9 {
            let x = if towards_lower_x {
                2 - step % 3
            } else {
                step % 3
            };
            let cell = step / 3 * 3 + x;
            if plane >> cell & 1 == 1 {
                let rank = (plane & ((1 << cell) - 1)).count_ones() as u8;
                list[0] += 1;
                list[list[0] as usize] = (cell as u8 + FIRST as u8) | rank << 4;
            }
            step += 1;
        }
        plane += 1;
    }
    Lists(lists)
}

/// Lists that go the same way along x as along y, and those that go the opposite way.
pub(super) static LISTS: [Lists; 2] = [lists(false), lists(true)];

/// The order of a cell's subcells, 3 x 3 x 3, by the sides from which they are seen.
///
/// A cell hides another only if it is nearer along each axis, so each axis is walked from the eye's
/// side. Where the eye is within the middle slab the cells of either side are beside each other as
/// it sees them, and the order along that axis does not matter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order(u32);

impl Order {
    /// The lists of the opposite way.
    pub(super) const OPPOSITE: u32 = 1;
    /// Lists are taken from their ends.
    pub(super) const BACKWARDS: u32 = 2;
    /// Planes are taken from the highest.
    pub(super) const DESCENDING: u32 = 4;

    /// Along x, y, z: whether higher cells come first.
    #[inline(always)]
    pub(super) fn new([x, y, z]: [bool; 3]) -> Self {
        Self(u32::from(x != y) | u32::from(y) << 1 | u32::from(z) << 2)
    }

    /// From the lowest of these bits.
    #[inline(always)]
    pub(super) fn from_bits(bits: u32) -> Self {
        Self(bits & 7)
    }

    /// The bits of an order.
    #[inline(always)]
    pub(super) fn bits(self) -> u32 {
        self.0
    }

    /// Whether lists are taken from their ends.
    #[inline(always)]
    pub(super) fn is_backwards(self) -> bool {
        self.0 & Self::BACKWARDS != 0
    }

    /// Three planes in order, of those from the lowest to the highest.
    #[inline(always)]
    pub(super) fn planes<T>(self, [low, mid, high]: [T; 3]) -> [T; 3] {
        if self.0 & Self::DESCENDING != 0 {
            [high, mid, low]
        } else {
            [low, mid, high]
        }
    }

    /// The cells in `plane` (nine bits) in the order of the list, and how many there are.
    #[inline(always)]
    pub(super) fn cells(self, plane: u32) -> (&'static [u8; 9], usize) {
        let [same, opposite] = &LISTS;
        let Lists(lists) = if self.0 & Self::OPPOSITE != 0 {
            opposite
        } else {
            same
        };
        let List([count, cells @ ..]) = lists.get(plane as usize & 511).unwrap_or(&NONE);
        (cells, usize::from(*count))
    }
}

static NONE: List = List([0; 10]);

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec::Vec;

    #[test]
    fn every_plane_is_listed_from_the_side_it_is_seen_from_with_ranks() {
        for plane in 0..512u32 {
            for (dx, dy) in [(false, false), (false, true), (true, false), (true, true)] {
                let order = Order::new([dx, dy, false]);
                let (cells, count) = order.cells(plane);
                let mut cells: Vec<u8> = cells[..count].to_vec();
                if order.is_backwards() {
                    cells.reverse();
                }
                let mut expected = Vec::new();
                for j in 0..3 {
                    for i in 0..3 {
                        let (x, y) = (if dx { 2 - i } else { i }, if dy { 2 - j } else { j });
                        let cell = 3 * y + x;
                        if plane >> cell & 1 == 1 {
                            let rank = (plane & ((1 << cell) - 1)).count_ones();
                            expected.push(((cell + FIRST) | (rank << 4)) as u8);
                        }
                    }
                }
                assert_eq!(cells, expected);
            }
        }
    }
}
