//! The cells of a plane of 3 x 3 in order, from a table.

/// The cells of a plane: how many, then one each: its number in the lower four bits and its rank
/// among the cells of the plane above them.
#[derive(Clone, Copy, Debug)]
pub(super) struct List([u8; 10]);

/// Which way a list goes along x while it goes towards higher y.
#[derive(Clone, Copy, Debug)]
struct Lists([List; 512]);

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
                list[list[0] as usize] = cell as u8 | rank << 4;
            }
            step += 1;
        }
        plane += 1;
    }
    Lists(lists)
}

static SAME: Lists = lists(false);
static OPPOSITE: Lists = lists(true);

/// The order of the cells of a plane, by the side from which they are seen.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct Order {
    lists: &'static Lists,
    /// The list is taken from its end.
    pub(in crate::render) backwards: bool,
}

impl Order {
    /// Along x and y, from the higher cells to the lower ones or from the lower to the higher.
    #[inline(always)]
    pub(in crate::render) fn new(descending: [bool; 2]) -> Self {
        let [x, y] = descending;
        Self {
            lists: if x == y { &SAME } else { &OPPOSITE },
            backwards: y,
        }
    }

    /// The cells in `plane` (nine bits) in the order of the list, and how many there are.
    #[inline(always)]
    pub(in crate::render) fn cells(self, plane: u32) -> (&'static [u8; 9], usize) {
        let List([count, cells @ ..]) = self.lists.0.get(plane as usize & 511).unwrap_or(&NONE);
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
                let order = Order::new([dx, dy]);
                let (cells, count) = order.cells(plane);
                let mut cells: Vec<u8> = cells[..count].to_vec();
                if order.backwards {
                    cells.reverse();
                }
                let mut expected = Vec::new();
                for j in 0..3 {
                    for i in 0..3 {
                        let (x, y) = (if dx { 2 - i } else { i }, if dy { 2 - j } else { j });
                        let cell = 3 * y + x;
                        if plane >> cell & 1 == 1 {
                            let rank = (plane & ((1 << cell) - 1)).count_ones();
                            expected.push((cell | rank << 4) as u8);
                        }
                    }
                }
                assert_eq!(cells, expected);
            }
        }
    }
}
