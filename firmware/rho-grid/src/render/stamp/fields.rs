//! What is read of attribute words, by layout.

#[cfg(rho_thumb)]
use super::{Parents, Stamps};
use crate::blob::{Attributes, Layout};
#[cfg(rho_thumb)]
use crate::render::visibility::Visibility;
use crate::shading::Shade;

/// By offset step: 32nds of a pixel.
pub(super) type Offsets = [i8; 8];

/// How far the largest offset may reach: 224 64ths of a pixel, for cells of 4 pixels and leaves of all layouts.
pub(super) const UNITS: usize = 224;

static EIGHT: [Offsets; UNITS] = steps(8);
static FOUR: [Offsets; UNITS] = steps(4);

/// Offsets in so many steps, each in the middle of its part of all that they may reach. Of four steps all eight
/// entries tell, whatever stands above them in a word.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const fn steps(count: i32) -> [Offsets; UNITS] {
    let mut all = [[0; 8]; UNITS];
    let mut unit = 0;
    while unit < UNITS {
        // 4096ths of a pixel; rounded to 32nds.
        let reach = unit as i32 * 64 + 32;
        let first = 64 - (count - 1) * reach / count;
        let mut step = 0;
        while step < 8 {
            let along = reach * (step as i32 % count) * 2 / count;
            all[unit][step] = ((first + along) >> 7) as i8;
            step += 1;
        }
        unit += 1;
    }
    all
}

/// What a stamp reads of an attribute word; one type for each layout that can be stamped.
pub(super) trait Fields {
    /// A word in flash.
    type Word: Copy + Default + Into<u32>;

    /// `[reach in 64ths of a pixel]`: offsets by step.
    const OFFSETS: &'static [Offsets; UNITS];

    /// Those among a grid's words; none when they are of another size.
    fn words<'g>(words: Attributes<'g>) -> &'g [Self::Word];

    /// The normal's index, 13 bits.
    fn normal(word: u32) -> u32;

    /// The offset's step; bits above it are ignored.
    fn offset(word: u32) -> u32;

    /// What it looks like.
    fn colour(shading: &impl Shade, word: u32) -> u16;

    /// Stamps all of a block's parents in assembly, if that is made for such words and this target.
    #[cfg(rho_thumb)]
    fn thumb<V: Visibility>(
        _: &mut Stamps<'_>,
        _: &mut V,
        _: &Parents<'_, '_>,
        _: &impl Shade,
    ) -> bool {
        false
    }
}

/// A normal of 13 bits over an offset of 3.
pub(super) struct Offset;
/// A normal of 11 bits over a material of 3 over an offset of 2.
pub(super) struct Both;
/// A colour over a normal of 13 bits over an offset of 3.
pub(super) struct Colour;

impl Fields for Offset {
    type Word = u16;
    const OFFSETS: &'static [Offsets; UNITS] = &EIGHT;

    #[inline(always)]
    fn words<'g>(words: Attributes<'g>) -> &'g [u16] {
        words.halves()
    }

    #[inline(always)]
    fn normal(word: u32) -> u32 {
        word >> 3
    }

    #[inline(always)]
    fn offset(word: u32) -> u32 {
        word
    }

    #[inline(always)]
    fn colour(shading: &impl Shade, word: u32) -> u16 {
        shading.of_normal(word >> 3)
    }

    #[cfg(rho_thumb)]
    fn thumb<V: Visibility>(
        stamps: &mut Stamps<'_>,
        target: &mut V,
        parents: &Parents<'_, '_>,
        shading: &impl Shade,
    ) -> bool {
        super::thumb::stamp::<false, _, _>(stamps, parents, target, shading)
    }
}

impl Fields for Both {
    type Word = u16;
    const OFFSETS: &'static [Offsets; UNITS] = &FOUR;

    #[inline(always)]
    fn words<'g>(words: Attributes<'g>) -> &'g [u16] {
        words.halves()
    }

    #[inline(always)]
    fn normal(word: u32) -> u32 {
        word >> 5 << 2
    }

    #[inline(always)]
    fn offset(word: u32) -> u32 {
        word & 3
    }

    #[inline(always)]
    fn colour(shading: &impl Shade, word: u32) -> u16 {
        shading.colour(word)
    }

    #[cfg(rho_thumb)]
    fn thumb<V: Visibility>(
        stamps: &mut Stamps<'_>,
        target: &mut V,
        parents: &Parents<'_, '_>,
        shading: &impl Shade,
    ) -> bool {
        super::thumb::stamp::<true, _, _>(stamps, parents, target, shading)
    }
}

impl Fields for Colour {
    type Word = u32;
    const OFFSETS: &'static [Offsets; UNITS] = &EIGHT;

    #[inline(always)]
    fn words<'g>(words: Attributes<'g>) -> &'g [u32] {
        words.words()
    }

    #[inline(always)]
    fn normal(word: u32) -> u32 {
        word >> 3 & 0x1FFF
    }

    #[inline(always)]
    fn offset(word: u32) -> u32 {
        word
    }

    #[inline(always)]
    fn colour(shading: &impl Shade, word: u32) -> u16 {
        shading.colour(word)
    }
}

/// Which [`Fields`] a grid's words have.
#[derive(Clone, Copy)]
pub(in crate::render) enum Kind {
    Offset,
    Both,
    Colour,
}

impl Kind {
    /// Offsets by step, as [`Fields::OFFSETS`].
    #[inline(always)]
    pub(super) fn offsets(self) -> &'static [Offsets; UNITS] {
        match self {
            Self::Offset => Offset::OFFSETS,
            Self::Both => Both::OFFSETS,
            Self::Colour => Colour::OFFSETS,
        }
    }

    /// That of a layout; `None` when it cannot be stamped.
    pub(in crate::render) fn of(layout: Layout) -> Option<Self> {
        [
            (Self::Offset, [Layout::OFFSET_THIN, Layout::OFFSET]),
            (Self::Both, [Layout::BOTH_THIN, Layout::BOTH]),
            (Self::Colour, [Layout::COLOUR_THIN, Layout::COLOUR]),
        ]
        .into_iter()
        .find(|(_, layouts)| layouts.contains(&layout))
        .map(|(kind, _)| kind)
    }
}
