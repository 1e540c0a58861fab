//! The cells of a recursive grid, and the rho x rho x rho subcells of one of them.
//!
//! Duguet & Drettakis 2003, section 4.2: a cell is cut into rho^3 equal subcells. With n
//! cells an axis, cell (i, j, k) covers [i/n - 1/2, (i + 1)/n - 1/2] along x and so on, its
//! faces included. A face is one value whoever asks: [`plane`] divides two integers, which
//! rounds once, so that neighbours, parents and children share it to the last bit.

use glam::DVec3;

/// The most subcells along an axis of one cell.
pub const MAX_RHO: u8 = 5;

/// Where face `i` of `n` cells an axis lies, `0 <= i <= n`, in cube units.
#[must_use]
pub fn plane(i: u32, n: u32) -> f64 {
    (2.0 * f64::from(i) - f64::from(n)) / (2.0 * f64::from(n))
}

/// One cell of the cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Cells an axis at this cell's level, n >= 1.
    pub per_axis: u32,
    /// (i, j, k) along x, y, z; each below `per_axis`.
    pub index: [u32; 3],
}

impl Cell {
    /// The whole cube.
    pub const ROOT: Self = Self {
        per_axis: 1,
        index: [0; 3],
    };

    /// The side in cube units.
    #[must_use]
    pub fn side(&self) -> f64 {
        1.0 / f64::from(self.per_axis)
    }

    /// The centre in cube units.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        DVec3::from_array(self.index.map(|i| plane(2 * i + 1, 2 * self.per_axis)))
    }

    /// The lowest and the highest corner in cube units.
    #[must_use]
    pub fn corners(&self) -> (DVec3, DVec3) {
        let corner = |step| DVec3::from_array(self.index.map(|i| plane(i + step, self.per_axis)));
        (corner(0), corner(1))
    }

    /// Subcell number `bit` = i + rho j + rho^2 k of this cell cut into rho^3.
    #[must_use]
    pub fn child(&self, rho: u8, bit: u32) -> Self {
        let rho = u32::from(rho);
        let within = [bit % rho, bit / rho % rho, bit / (rho * rho)];
        Self {
            per_axis: self.per_axis * rho,
            index: [0, 1, 2].map(|a| self.index[a] * rho + within[a]),
        }
    }
}

/// The rho^3 subcells of one cell, as the planes that bound them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subcells {
    rho: usize,
    /// `planes[axis][0..=rho]`, ascending; what follows repeats the last.
    planes: [[f64; MAX_RHO as usize + 1]; 3],
    /// `centres[axis][0..rho]`.
    centres: [[f64; MAX_RHO as usize]; 3],
    half: f64,
}

impl Subcells {
    /// Cuts `cell` into rho^3; `rho` is 1 (the cell itself) to [`MAX_RHO`], and is brought
    /// into that range otherwise.
    #[must_use]
    pub fn of(cell: &Cell, rho: u8) -> Self {
        let rho = u32::from(rho.clamp(1, MAX_RHO));
        let n = cell.per_axis * rho;
        let mut planes = [[0.0; MAX_RHO as usize + 1]; 3];
        let mut centres = [[0.0; MAX_RHO as usize]; 3];
        for axis in 0..3 {
            let first = cell.index[axis] * rho;
            for (step, at) in (0..).zip(&mut planes[axis]) {
                *at = plane(first + rho.min(step), n);
            }
            for (step, at) in (0..).zip(&mut centres[axis]) {
                *at = plane(2 * (first + (rho - 1).min(step)) + 1, 2 * n);
            }
        }
        Self {
            rho: rho as usize,
            planes,
            centres,
            half: 0.5 / f64::from(n),
        }
    }

    /// Subcells along an axis.
    #[must_use]
    pub fn rho(&self) -> usize {
        self.rho
    }

    /// The rho + 1 planes across `axis` (0 x, 1 y, 2 z) that bound the subcells.
    #[must_use]
    pub fn planes(&self, axis: usize) -> &[f64] {
        &self.planes[axis][..=self.rho]
    }

    /// The rho coordinates of the subcells' centres along `axis`.
    #[must_use]
    pub fn centres(&self, axis: usize) -> &[f64] {
        &self.centres[axis][..self.rho]
    }

    /// Half a subcell's side in cube units.
    #[must_use]
    pub fn half(&self) -> f64 {
        self.half
    }

    /// The bit of subcell (i, j, k).
    #[must_use]
    pub fn bit(&self, i: usize, j: usize, k: usize) -> u32 {
        (i + self.rho * (j + self.rho * k)) as u32
    }

    /// Along each axis, the first subcell whose closed extent meets the closed interval
    /// from `low` to `high`, and one past the last; `None` when an axis has none.
    #[must_use]
    pub fn range(&self, low: DVec3, high: DVec3) -> Option<[(usize, usize); 3]> {
        let mut range = [(0, 0); 3];
        for axis in 0..3 {
            let (low, high) = (low[axis], high[axis]);
            let (mut from, mut to) = (0, 0);
            for cell in 0..self.rho {
                from += usize::from(self.planes[axis][cell + 1] < low);
                to += usize::from(self.planes[axis][cell] <= high);
            }
            if from >= to {
                return None;
            }
            range[axis] = (from, to);
        }
        Some(range)
    }
}

/// The bits set in `mask`, ascending.
pub fn bits(mut mask: u128) -> impl Iterator<Item = u32> + Clone {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (bit < u128::BITS).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_has_one_value_at_every_level_and_from_both_sides() {
        for i in 0..=81 {
            assert_eq!(plane(i, 81), plane(3 * i, 243));
            assert_eq!(plane(i, 81), -plane(81 - i, 81));
        }
        let cell = Cell {
            per_axis: 9,
            index: [4, 0, 8],
        };
        for bit in 0..27 {
            let child = cell.child(3, bit);
            let (low, high) = child.corners();
            let subcells = Subcells::of(&cell, 3);
            let [i, j, k] = [bit % 3, bit / 3 % 3, bit / 9].map(|x| x as usize);
            assert_eq!(subcells.bit(i, j, k), bit);
            assert_eq!(low.x, subcells.planes(0)[i]);
            assert_eq!(high.y, subcells.planes(1)[j + 1]);
            assert_eq!(child.centre().z, subcells.centres(2)[k]);
        }
    }

    #[test]
    fn the_cells_fill_the_cube_from_minus_a_half_to_a_half() {
        assert_eq!((plane(0, 7), plane(7, 7)), (-0.5, 0.5));
        assert_eq!(Cell::ROOT.centre(), DVec3::ZERO);
        assert_eq!(
            Cell::ROOT.corners(),
            (DVec3::splat(-0.5), DVec3::splat(0.5))
        );
    }

    #[test]
    fn an_interval_that_ends_on_a_face_meets_both_neighbours() {
        let subcells = Subcells::of(&Cell::ROOT, 4);
        let range = |low: f64, high: f64| {
            subcells
                .range(DVec3::splat(low), DVec3::splat(high))
                .map(|r| r[0])
        };
        assert_eq!(range(0.0, 0.0), Some((1, 3)));
        assert_eq!(range(0.1, 0.2), Some((2, 3)));
        assert_eq!(range(-0.25, 0.1), Some((0, 3)));
        assert_eq!(range(0.5, 0.5), Some((3, 4)));
        assert_eq!(range(0.6, 0.7), None);
        assert_eq!(range(-9.0, 9.0), Some((0, 4)));
        assert_eq!(range(f64::NAN, f64::NAN), None);
    }

    #[test]
    fn bits_come_in_ascending_order() {
        assert_eq!(bits(1 | 1 << 5 | 1 << 124).collect::<Vec<_>>(), [0, 5, 124]);
        assert_eq!(bits(0).count(), 0);
        assert_eq!(bits(u128::MAX).count(), 128);
    }
}
