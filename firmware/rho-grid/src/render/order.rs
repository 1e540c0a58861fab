//! Subcells from front to back.
//!
//! A subcell can hide another only if, along each axis, its slab is not farther from the eye's
//! slab. So three nested loops over slabs, each from the eye's slab outwards, visit what hides
//! before what is hidden; which side comes first does not matter. This holds wherever the eye is,
//! also inside (paper, section 5.3, has the order by a light's direction; Botsch et al. 2002 by
//! octant).

/// Most subcells of a cell: rho = 5.
pub(super) const MAX_SUBCELLS: usize = 125;

/// `AXIS[rho][eye's slab]`: the slabs of an axis, from the eye's outwards.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static AXIS: [[[u8; 5]; 5]; 6] = {
    let mut axis = [[[0; 5]; 5]; 6];
    let mut rho = 2;
    while rho <= 5 {
        let mut eye = 0;
        while eye < rho {
            let mut at = 0;
            let mut slab = eye as i32;
            while slab >= 0 {
                axis[rho][eye][at] = slab as u8;
                at += 1;
                slab -= 1;
            }
            let mut slab = eye + 1;
            while slab < rho {
                axis[rho][eye][at] = slab as u8;
                at += 1;
                slab += 1;
            }
            eye += 1;
        }
        rho += 1;
    }
    axis
};

/// The slabs of an axis divided by `RHO`, from `eye` (clamped to it) outwards.
#[inline(always)]
fn slabs<const RHO: usize>(eye: i32) -> &'static [u8] {
    let eye = eye.clamp(0, RHO as i32 - 1) as usize;
    AXIS.get(RHO)
        .and_then(|a| a.get(eye))
        .and_then(|a| a.get(..RHO))
        .unwrap_or_default()
}

/// Lists the subcells in `mask` from front to back; `eye` is the eye's slab along each axis,
/// any number below 0 or beyond RHO - 1 when it is outside. Returns how many there are.
#[inline(always)]
pub(super) fn list<const RHO: usize>(
    mask: &[u32; 4],
    eye: [i32; 3],
    list: &mut [u8; MAX_SUBCELLS],
) -> usize {
    let [ex, ey, ez] = eye;
    let (along_x, along_y, along_z) = (slabs::<RHO>(ex), slabs::<RHO>(ey), slabs::<RHO>(ez));
    let mut count = 0;
    for &k in along_z {
        let plane = plane::<RHO>(mask, usize::from(k));
        if plane == 0 {
            continue;
        }
        for &j in along_y {
            let row = plane >> (RHO * usize::from(j)) & ((1 << RHO) - 1);
            if row == 0 {
                continue;
            }
            let first = RHO as u8 * (j + RHO as u8 * k);
            for &i in along_x {
                if row >> i & 1 != 0
                    && let Some(entry) = list.get_mut(count)
                {
                    *entry = first + i;
                    count += 1;
                }
            }
        }
    }
    count
}

/// The bits of slab `k` along z.
#[inline(always)]
fn plane<const RHO: usize>(mask: &[u32; 4], k: usize) -> u32 {
    let bit = RHO * RHO * k;
    let word = |i: usize| mask.get(i).copied().unwrap_or(0);
    let low = word(bit / 32) >> (bit % 32);
    let high = if RHO == 5 && !bit.is_multiple_of(32) {
        word(bit / 32 + 1) << (32 - bit % 32)
    } else {
        0
    };
    (low | high) & ((1 << (RHO * RHO)) - 1)
}

/// How many subcells in `mask` come before `subcell` in the numbering of children.
#[inline(always)]
pub(super) fn rank<const RHO: usize>(mask: &[u32; 4], subcell: u8) -> u32 {
    let below = (1u32 << (subcell % 32)) - 1;
    let [a, b, c, d] = *mask;
    if RHO <= 3 {
        return (a & below).count_ones();
    }
    match subcell / 32 {
        0 => (a & below).count_ones(),
        1 => a.count_ones() + (b & below).count_ones(),
        2 => a.count_ones() + b.count_ones() + (c & below).count_ones(),
        _ => a.count_ones() + b.count_ones() + c.count_ones() + (d & below).count_ones(),
    }
}

/// `(x, y, z)` of a subcell's number.
#[inline(always)]
pub(super) fn place(rho: u8, subcell: u8) -> [i32; 3] {
    let rho = i32::from(rho).max(1);
    let n = i32::from(subcell);
    [n % rho, n / rho % rho, n / (rho * rho)]
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use proptest::prelude::*;

    fn check<const RHO: usize>(mask: u128, eye: [i32; 3]) {
        let cells = RHO.pow(3) as u32;
        let mask = mask & (u128::MAX >> (128 - cells));
        let words = [0, 32, 64, 96].map(|s| (mask >> s) as u32);
        let mut entries = [0; MAX_SUBCELLS];
        let count = list::<RHO>(&words, eye, &mut entries);
        assert_eq!(count as u32, mask.count_ones());
        let listed = &entries[..count];
        let inside = eye.map(|e| e.clamp(0, RHO as i32 - 1));
        let between = |a: i32, b: i32, eye: i32| (eye <= a && a <= b) || (b <= a && a <= eye);
        for (at, n) in listed.iter().enumerate() {
            assert!(mask >> n & 1 == 1, "only cells of the mask");
            let rank_here = rank::<RHO>(&words, *n);
            assert_eq!(rank_here, (mask & ((1 << n) - 1)).count_ones());
            // Nothing that could hide it comes later.
            let me = place(RHO as u8, *n);
            for later in &listed[at + 1..] {
                let other = place(RHO as u8, *later);
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
            check::<2>(mask, eye);
            check::<3>(mask, eye);
            check::<4>(mask, eye);
            check::<5>(mask, eye);
        }
    }
}
