//! What the bits of an attribute word mean.

use super::error::BlobError;

/// The attribute layout which a grid declares.
///
/// From the lowest bit: offset, material, normal, colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Bytes of a word, 2 or 4.
    pub word_bytes: u8,
    /// Bits of the normal: 9, 11, 13, 15 or 17.
    pub normal: u8,
    /// Bits of the offset along the normal, 0 to 4.
    pub offset: u8,
    /// Bits of the material, 0 to 3.
    pub material: u8,
    /// Bits of the RGB565 colour, 0 or 16.
    pub colour: u8,
    /// The offset's range, +- this many 1/128 of a cell's side.
    pub offset_range: u8,
}

impl Layout {
    /// The paper's 16 bits: a normal of 13, one of 8 materials.
    pub const MATERIAL: Self = Self {
        word_bytes: 2,
        normal: 13,
        offset: 0,
        material: 3,
        colour: 0,
        offset_range: 0,
    };

    /// 16 bits: a normal of 13, an offset of 3 within half a cell (thin leaves).
    pub const OFFSET_THIN: Self = Self {
        word_bytes: 2,
        normal: 13,
        offset: 3,
        material: 0,
        colour: 0,
        offset_range: 64,
    };

    /// 16 bits: a normal of 13, an offset of 3 within half the diagonal of a cell.
    pub const OFFSET: Self = Self {
        offset_range: 111,
        ..Self::OFFSET_THIN
    };

    /// 16 bits for both: a normal of 11, an offset of 2 within half a cell, one of 8 materials.
    pub const BOTH_THIN: Self = Self {
        word_bytes: 2,
        normal: 11,
        offset: 2,
        material: 3,
        colour: 0,
        offset_range: 64,
    };

    /// The same with an offset within half the diagonal of a cell.
    pub const BOTH: Self = Self {
        offset_range: 111,
        ..Self::BOTH_THIN
    };

    /// 32 bits: a normal of 13, an offset of 3 within half a cell, a colour.
    pub const COLOUR_THIN: Self = Self {
        word_bytes: 4,
        colour: 16,
        ..Self::OFFSET_THIN
    };

    /// The same with an offset within half the diagonal of a cell.
    pub const COLOUR: Self = Self {
        offset_range: 111,
        ..Self::COLOUR_THIN
    };

    /// Whether the fields are among those that the format knows and fit the word.
    ///
    /// # Errors
    /// [`BlobError::Layout`] if not.
    pub const fn check(self) -> Result<(), BlobError> {
        let known = matches!(self.word_bytes, 2 | 4)
            && matches!(self.normal, 9 | 11 | 13 | 15 | 17)
            && self.offset <= 4
            && self.material <= 3
            && matches!(self.colour, 0 | 16)
            && self.normal + self.offset + self.material + self.colour <= 8 * self.word_bytes;
        if known {
            Ok(())
        } else {
            Err(BlobError::Layout)
        }
    }

    /// Whether this version of the renderer draws it: a normal of at most 13 bits, an offset of at
    /// most 3.
    #[must_use]
    pub const fn is_drawn(self) -> bool {
        self.normal <= 13 && self.offset <= 3 && (self.colour == 0 || self.material == 0)
    }

    /// Packs a word; values beyond their bits are cut.
    #[must_use]
    pub const fn pack(self, normal: u32, offset: u32, material: u32, colour: u32) -> u32 {
        (offset & mask(self.offset))
            | (material & mask(self.material)) << self.offset
            | (normal & mask(self.normal)) << (self.material + self.offset)
            | if self.colour == 0 {
                0
            } else {
                (colour & 0xFFFF) << 16
            }
    }

    /// The normal's index.
    #[must_use]
    pub const fn normal_of(self, word: u32) -> u32 {
        (word >> (self.material + self.offset)) & mask(self.normal)
    }

    /// The normal's index among those of 13 bits: of a coarser one the face in its middle, which faces
    /// the same way. For layouts that are drawn.
    #[inline(always)]
    #[must_use]
    pub const fn normal_13(self, word: u32) -> u32 {
        self.normal_of(word) << (13 - self.normal)
    }

    /// The colour, RGB565.
    #[inline(always)]
    #[must_use]
    pub const fn colour_of(self, word: u32) -> u16 {
        if self.colour == 0 {
            return u16::MAX;
        }
        (word >> 16) as u16
    }

    /// The offset's step.
    #[must_use]
    pub const fn offset_of(self, word: u32) -> u32 {
        word & mask(self.offset)
    }

    /// The material.
    #[must_use]
    pub const fn material_of(self, word: u32) -> u32 {
        (word >> self.offset) & mask(self.material)
    }

    /// The offset along the normal in sides of the cell, times 256.
    #[inline(always)]
    #[must_use]
    pub const fn offset_q8(self, word: u32) -> i32 {
        let odd = 2 * self.offset_of(word) as i32 + 1 - (1 << self.offset);
        (odd * 2 * self.offset_range as i32) >> self.offset
    }

    /// The offset step nearest to `sides` (a signed length in sides of the cell, times 2^16).
    #[must_use]
    pub const fn offset_step(self, sides_q16: i32) -> u32 {
        if self.offset == 0 {
            return 0;
        }
        let steps = 1i64 << self.offset;
        let range = (self.offset_range as i64) << 9;
        let step = ((sides_q16 as i64 + range) * steps).div_euclid(2 * range);
        if step < 0 {
            0
        } else if step >= steps {
            (steps - 1) as u32
        } else {
            step as u32
        }
    }
}

const fn mask(bits: u8) -> u32 {
    (1 << bits) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_reads_back() {
        let all = Layout {
            word_bytes: 4,
            normal: 11,
            offset: 2,
            material: 3,
            colour: 16,
            offset_range: 64,
        };
        assert_eq!(all.check(), Ok(()));
        let word = all.pack(1234, 3, 5, 0xBEEF);
        assert_eq!(all.normal_of(word), 1234);
        assert_eq!(all.offset_of(word), 3);
        assert_eq!(all.material_of(word), 5);
        assert_eq!(word >> 16, 0xBEEF);
    }

    #[test]
    fn fields_that_do_not_fit_the_word_are_refused() {
        let wide = Layout {
            normal: 15,
            ..Layout::MATERIAL
        };
        assert_eq!(wide.check(), Err(BlobError::Layout));
    }

    #[test]
    fn the_offset_is_the_nearest_step() {
        let thin = Layout::OFFSET_THIN;
        // Steps lie at -7/16, -5/16 ... 7/16 of a cell.
        for step in 0..8i32 {
            assert_eq!(thin.offset_step((2 * step - 7) * 65536 / 16), step as u32);
        }
        assert_eq!(thin.offset_q8(thin.pack(0, 7, 0, 0)), 7 * 256 / 16);
        assert_eq!(thin.offset_q8(thin.pack(0, 0, 0, 0)), -7 * 256 / 16);
        assert_eq!(Layout::MATERIAL.offset_q8(0xFFFF), 0);
        assert_eq!(thin.offset_step(-70000), 0);
        assert_eq!(thin.offset_step(70000), 7);
    }
}
