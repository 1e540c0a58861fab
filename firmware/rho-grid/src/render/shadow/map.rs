//! What a light sees: the depth at which it first meets something, a texel.

use super::view::{ACROSS, DEPTH};
use crate::mode::MapSize;

/// Nothing: deeper than all.
const OPEN: u16 = u16::MAX;

/// The depth at which the light first meets something, a texel.
#[derive(Debug)]
pub struct ShadowMap<'a> {
    texels: &'a mut [u16],
    size: MapSize,
}

impl<'a> ShadowMap<'a> {
    /// The map in the first [`MapSize::words`] words of a buffer, as it is; `None` when they are too
    /// few.
    #[must_use]
    pub fn kept(buffer: &'a mut [u16], size: MapSize) -> Option<Self> {
        let texels = buffer.get_mut(..size.words())?;
        Some(Self { texels, size })
    }

    /// The same, cleared: the light meets nothing.
    #[must_use]
    pub fn cleared(buffer: &'a mut [u16], size: MapSize) -> Option<Self> {
        let map = Self::kept(buffer, size)?;
        map.texels.fill(OPEN);
        Some(map)
    }

    /// The same map for a while.
    #[must_use]
    pub fn lend(&mut self) -> ShadowMap<'_> {
        ShadowMap {
            texels: self.texels,
            size: self.size,
        }
    }

    /// The depths of the rows of texels after each other, 0 to 1023, 65535 for none.
    #[must_use]
    pub fn texels(&self) -> &[u16] {
        let side = usize::from(self.size.side());
        self.texels.get(..side * side).unwrap_or_default()
    }

    /// Texels a side.
    #[must_use]
    pub fn size(&self) -> MapSize {
        self.size
    }

    /// The depths, and those of the rows beyond the map's last.
    #[cfg(rho_thumb)]
    pub(super) fn all(&mut self) -> &mut [u16] {
        self.texels
    }

    /// The texel of a place ([`super::view`]).
    #[inline(always)]
    fn at(&self, place: u32) -> usize {
        let bits = self.size.bits();
        let side = (1 << bits) - 1;
        let u = place >> (ACROSS - bits) & side;
        let v = place >> (2 * ACROSS - bits) & side;
        (v << bits | u) as usize
    }

    /// Whether something lies between the light and a place.
    #[inline(always)]
    pub(super) fn shades(&self, place: u32) -> bool {
        let nearest = self.texels.get(self.at(place));
        nearest.is_some_and(|nearest| u32::from(*nearest) < place >> DEPTH)
    }

    /// Lays a splat of `SIDE` x `SIDE` texels, the first of them at `place`: a texel's depth becomes the
    /// place's where that is nearer to the light.
    #[inline(always)]
    pub(super) fn splat<const SIDE: usize>(&mut self, place: u32) {
        let depth = (place >> DEPTH) as u16;
        let mut at = self.at(place);
        for _ in 0..SIDE {
            let row = self.texels.get_mut(at..);
            let Some(row) = row.and_then(|row| row.first_chunk_mut::<SIDE>()) else {
                return;
            };
            for texel in row {
                if depth < *texel {
                    *texel = depth;
                }
            }
            at += usize::from(self.size.side());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec;

    fn place(u: u32, v: u32, depth: u32) -> u32 {
        u | v << ACROSS | depth << DEPTH
    }

    #[test]
    fn a_splat_shades_what_is_deeper_and_the_nearest_one_stays() {
        let size = MapSize::of(64).unwrap();
        let mut buffer = vec![0; size.words()];
        let mut map = ShadowMap::cleared(&mut buffer, size).unwrap();
        // A texel is 32 wide.
        map.splat::<2>(place(10 * 32 + 31, 20 * 32, 500));
        map.splat::<1>(place(11 * 32, 20 * 32, 300));
        map.splat::<1>(place(10 * 32, 21 * 32, 700));
        let shades = |u: u32, v: u32, depth| map.shades(place(u * 32 + 16, v * 32 + 16, depth));
        assert!(!shades(10, 20, 500) && shades(10, 20, 501));
        assert!(!shades(11, 20, 300) && shades(11, 20, 301));
        assert!(!shades(10, 21, 500) && shades(10, 21, 501));
        assert!(!shades(9, 20, 1023) && !shades(12, 20, 1023));
        assert_eq!(map.texels().iter().filter(|t| **t != OPEN).count(), 4);
    }

    #[test]
    fn a_splat_at_the_maps_end_stays_in_the_buffer() {
        let size = MapSize::of(64).unwrap();
        let mut buffer = vec![0; size.words()];
        let mut map = ShadowMap::cleared(&mut buffer, size).unwrap();
        map.splat::<4>(place(2047, 2047, 5));
        assert_eq!(map.texels().iter().filter(|t| **t == 5).count(), 1);
        assert_eq!(buffer.iter().filter(|t| **t == 5).count(), 16);
        assert!(ShadowMap::kept(&mut buffer[1..], size).is_none());
    }
}
