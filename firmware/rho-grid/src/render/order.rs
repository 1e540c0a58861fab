//! Subcells from front to back.
//!
//! A subcell can hide another only if, along each axis, its slab is not farther from the eye's
//! slab. So three nested loops over slabs, each from the eye's slab outwards, visit what hides
//! before what is hidden; which side comes first does not matter. This holds wherever the eye is,
//! also inside (paper, section 5.3, has the order by a light's direction; Botsch et al. 2002 by
//! octant).

/// Most subcells of a cell: rho = 5.
const MAX_SUBCELLS: usize = 125;

/// A subcell of a cell, and its rank among those that are there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Listed(u16);

impl Listed {
    /// The first.
    pub(super) const ZERO: Self = Self(0);

    /// Below 125, both.
    #[inline(always)]
    fn new(subcell: u32, rank: u32) -> Self {
        Self((rank << 8 | subcell) as u16)
    }

    /// Its number.
    #[inline(always)]
    pub(super) fn subcell(self) -> u8 {
        self.0 as u8
    }

    /// How many come before it in the numbering of children.
    #[inline(always)]
    pub(super) fn rank(self) -> u32 {
        u32::from(self.0 >> 8)
    }
}

/// Subcells in order.
pub(super) type List = [Listed; MAX_SUBCELLS];

/// Up to five slabs in the order in which they are taken, six bits each: one more than the slab's
/// number, and above that its rank among those that are there; the end is 0.
#[derive(Clone, Copy)]
pub(super) struct Few(u32);

impl Iterator for Few {
    /// A slab and its rank.
    type Item = (u32, u32);

    #[inline(always)]
    fn next(&mut self) -> Option<(u32, u32)> {
        let (n, rank) = (self.0 & 7, self.0 >> 3 & 7);
        self.0 >>= 6;
        n.checked_sub(1).map(|slab| (slab, rank))
    }
}

/// The slabs of an axis divided by rho, those in `bits`, from the eye's outwards.
const fn outwards(rho: u32, eye: u32, bits: u32) -> Few {
    let mut few = 0;
    let mut at = rho;
    while at > 0 {
        at -= 1;
        // eye, eye - 1, ... 0, then eye + 1, ...
        let slab = if at <= eye { eye - at } else { at };
        if bits >> slab & 1 == 1 {
            let rank = (bits & ((1 << slab) - 1)).count_ones();
            few = few << 6 | rank << 3 | (slab + 1);
        }
    }
    Few(few)
}

/// Orders along an axis: `AXES[rho - 2][eye's slab][bits]`, those of the slabs that `bits` names. Rows beyond rho are
/// empty.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static AXES: [[[Few; 32]; 8]; 4] = {
    let mut axes = [[[Few(0); 32]; 8]; 4];
    let mut rho = 2;
    while rho <= 5 {
        let mut eye = 0;
        while eye < rho {
            let mut bits = 0;
            while bits < 1 << rho {
                axes[rho - 2][eye][bits] = outwards(rho as u32, eye as u32, bits as u32);
                bits += 1;
            }
            eye += 1;
        }
        rho += 1;
    }
    axes
};

/// The order of a cell's subcells for one place of the eye.
#[derive(Clone, Copy)]
pub(super) struct Order {
    rho: u32,
    along_x: &'static [Few; 32],
    along_y: Few,
    along_z: Few,
}

impl Order {
    /// Of a cell divided by `rho`; `eye` is the eye's slab along each axis, any number below 0 or beyond rho - 1
    /// when it is outside.
    #[inline(always)]
    pub(super) fn new(rho: u8, eye: [i32; 3]) -> Self {
        let [first, ..] = &AXES;
        let axis = AXES.get(usize::from(rho).wrapping_sub(2)).unwrap_or(first);
        let rho = u32::from(rho);
        let along = |eye: i32| {
            let eye = eye.clamp(0, rho as i32 - 1) as usize & 7;
            axis.get(eye).unwrap_or(&[Few(0); 32])
        };
        let all = |rows: &[Few; 32]| rows.get((1 << rho) - 1).copied().unwrap_or(Few(0));
        let [x, y, z] = eye;
        Self {
            rho,
            along_x: along(x),
            along_y: all(along(y)),
            along_z: all(along(z)),
        }
    }

    /// The slabs along z that are not empty, and their bits.
    #[inline(always)]
    pub(super) fn planes(self, mask: &[u32; 4]) -> impl Iterator<Item = (u32, u32)> {
        let rho = self.rho;
        self.along_z
            .map(move |(k, _)| (k, plane(rho, mask, k)))
            .filter(|(_, plane)| *plane != 0)
    }

    /// The rows of a slab that are not empty, and their bits.
    #[inline(always)]
    pub(super) fn rows(self, plane: u32) -> impl Iterator<Item = (u32, u32)> {
        let rho = self.rho;
        self.along_y
            .map(move |(j, _)| (j, (plane >> ((rho * j) & 31)) & ((1 << (rho & 31)) - 1)))
            .filter(|(_, row)| *row != 0)
    }

    /// The subcells of a row.
    #[inline(always)]
    pub(super) fn cells(self, row: u32) -> Few {
        self.along_x
            .get(row as usize & 31)
            .copied()
            .unwrap_or(Few(0))
    }

    /// The first subcell of row (j, k).
    #[inline(always)]
    pub(super) fn row(self, j: u32, k: u32) -> u32 {
        self.rho * (j + self.rho * k)
    }

    /// Takes all rows in `mask` of a cell divided by `rho`, the eye in this slab ([`Self::new`]): j and k, the first of
    /// its subcells, and those that are there. Each rho has a loop of its own.
    #[inline(always)]
    pub(super) fn each_row(
        rho: u8,
        eye: [i32; 3],
        mask: &[u32; 4],
        take: impl FnMut([u32; 2], Listed, Few),
    ) {
        match rho {
            2 => Self::new(2, eye).take_rows(mask, take),
            3 => Self::new(3, eye).take_rows(mask, take),
            4 => Self::new(4, eye).take_rows(mask, take),
            _ => Self::new(5, eye).take_rows(mask, take),
        }
    }

    #[inline(always)]
    fn take_rows(self, mask: &[u32; 4], mut take: impl FnMut([u32; 2], Listed, Few)) {
        let rho = self.rho;
        // Of each slab, how many subcells come before it, and before each of its rows within it.
        let mut ranks = [(0, 0); 5];
        let mut before = 0;
        for (k, ranks) in (0..rho).zip(&mut ranks) {
            let rows = counts(rho, plane(rho, mask, k));
            let before_rows = rows.wrapping_mul(sums(rho));
            *ranks = (before, before_rows);
            let last = rho * (rho - 1);
            before += (before_rows >> last & ((1 << rho) - 1)) + (rows >> last);
        }
        for (k, plane) in self.planes(mask) {
            let (before, before_rows) = ranks.get(k as usize).copied().unwrap_or((0, 0));
            for (j, row) in self.rows(plane) {
                let before = before + (before_rows >> (rho * j) & ((1 << rho) - 1));
                take([j, k], Listed::new(self.row(j, k), before), self.cells(row));
            }
        }
    }

    /// Lists all subcells in `mask`, as [`Self::each_row`] takes them; returns how many there are.
    #[inline(always)]
    pub(super) fn list(rho: u8, eye: [i32; 3], mask: &[u32; 4], list: &mut List) -> usize {
        let mut entries = list.iter_mut();
        Self::each_row(rho, eye, mask, |_, first, cells| {
            for ((i, rank), entry) in cells.zip(&mut entries) {
                *entry = Listed(first.0 + (rank << 8 | i) as u16);
            }
        });
        let left = entries.len();
        MAX_SUBCELLS - left
    }
}

/// The bits of slab `k` along z.
#[inline(always)]
fn plane(rho: u32, mask: &[u32; 4], k: u32) -> u32 {
    let bit = rho * rho * k;
    let all = (1 << ((rho * rho) & 31)) - 1;
    if rho <= 3 {
        let [low, ..] = *mask;
        return (low >> (bit & 31)) & all;
    }
    let word = |i: u32| u64::from(mask.get(i as usize).copied().unwrap_or(0));
    let both = word(bit / 32 + 1) << 32 | word(bit / 32);
    (both >> (bit % 32)) as u32 & all
}

/// Of each row of a slab, how many subcells it has: as many bits a row as it has subcells.
#[inline(always)]
fn counts(rho: u32, plane: u32) -> u32 {
    match rho {
        2 => plane - (plane >> 1 & 0b01_01),
        3 => plane - (plane >> 1 & 0o333) - (plane >> 2 & 0o111),
        4 => {
            let pairs = plane - (plane >> 1 & 0x5555);
            (pairs & 0x3333) + (pairs >> 2 & 0x3333)
        }
        _ => (0..5).map(|bit| plane >> bit & 0x10_8421).sum(),
    }
}

/// This times the counts of a slab's rows is how many subcells come before each row; these fit into as many bits.
#[inline(always)]
fn sums(rho: u32) -> u32 {
    match rho {
        2 => 0b01_00,
        3 => 0o110,
        4 => 0x1110,
        _ => 0x10_8420,
    }
}

/// How many subcells in `mask` come before `subcell` in the numbering of children.
#[inline(always)]
pub(super) fn rank(mask: &[u32; 4], subcell: u8) -> u32 {
    let below = (1u32 << (subcell % 32)) - 1;
    let [a, b, c, d] = *mask;
    match subcell / 32 {
        0 => (a & below).count_ones(),
        1 => a.count_ones() + (b & below).count_ones(),
        2 => a.count_ones() + b.count_ones() + (c & below).count_ones(),
        _ => a.count_ones() + b.count_ones() + c.count_ones() + (d & below).count_ones(),
    }
}

/// `PLACES[rho - 2][subcell]`: x, y, z.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static PLACES: [[[u8; 3]; MAX_SUBCELLS]; 4] = {
    let mut places = [[[0; 3]; MAX_SUBCELLS]; 4];
    let mut rho = 2;
    while rho <= 5 {
        let mut n = 0;
        while n < rho * rho * rho {
            let xyz = [n % rho, n / rho % rho, n / (rho * rho)];
            places[rho - 2][n] = [xyz[0] as u8, xyz[1] as u8, xyz[2] as u8];
            n += 1;
        }
        rho += 1;
    }
    places
};

/// `(x, y, z)` of a subcell's number.
#[inline(always)]
pub(super) fn place(rho: u8, subcell: u8) -> [i32; 3] {
    PLACES
        .get(usize::from(rho).wrapping_sub(2))
        .and_then(|places| places.get(usize::from(subcell)))
        .map_or([0; 3], |place| place.map(i32::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use proptest::prelude::*;

    fn check(rho: u8, mask: u128, eye: [i32; 3]) {
        let cells = u32::from(rho).pow(3);
        let mask = mask & (u128::MAX >> (128 - cells));
        let words = [0, 32, 64, 96].map(|s| (mask >> s) as u32);
        let mut entries = [Listed::default(); MAX_SUBCELLS];
        let count = Order::list(rho, eye, &words, &mut entries);
        assert_eq!(count as u32, mask.count_ones());
        let listed = &entries[..count];
        let inside = eye.map(|e| e.clamp(0, i32::from(rho) - 1));
        let between = |a: i32, b: i32, eye: i32| (eye <= a && a <= b) || (b <= a && a <= eye);
        for (at, entry) in listed.iter().enumerate() {
            let n = entry.subcell();
            assert!(mask >> n & 1 == 1, "only cells of the mask");
            assert_eq!(entry.rank(), (mask & ((1 << n) - 1)).count_ones());
            assert_eq!(entry.rank(), rank(&words, n));
            // Nothing that could hide it comes later.
            let me = place(rho, n);
            for later in &listed[at + 1..] {
                let other = place(rho, later.subcell());
                let hides = (0..3).all(|d| between(other[d], me[d], inside[d]));
                assert!(!hides, "{other:?} hides {me:?} from {inside:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn what_hides_comes_before_what_is_hidden(
            mask: u128, eye in prop::array::uniform3(-2..7i32)
        ) {
            for rho in 2..=5 {
                check(rho, mask, eye);
            }
        }
    }
}
