//! Colours to 128 tones: a tree of median cuts (Heckbert 1982).
//!
//! The box of colours that is spread the widest is cut at its mean, again and again, until there are
//! 128 boxes. The cuts are kept as a tree, so that any colour finds its tone by some seven
//! comparisons, and no table of all colours is needed.

/// Tones there are: seven bits.
pub const TONES: usize = 128;

/// A colour of three channels of 8 bits, red the highest.
pub type Rgb = u32;

/// Packs red, green and blue of Q15, 0 to 1.
#[inline(always)]
#[must_use]
pub fn pack([red, green, blue]: [u32; 3]) -> Rgb {
    let bits = |c: u32| (c * 255 + (1 << 14)) >> 15;
    bits(red) << 16 | bits(green) << 8 | bits(blue)
}

/// A cut: colours whose channel is below `at` are on its low side.
#[derive(Clone, Copy, Debug, Default)]
struct Cut {
    /// The channel's place in a packed colour.
    shift: u8,
    at: u8,
    /// The next cut on the low and on the high side, or [`LEAF`] and a tone.
    next: [u8; 2],
}

const LEAF: u8 = 0x80;

/// Colours not yet cut.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    first: u16,
    end: u16,
    /// Where it hangs: a cut and its side.
    cut: u8,
    side: u8,
    /// The channel in which it is spread the widest, and how much that counts.
    shift: u8,
    spread: u32,
}

/// The tones of a frame, 3 kB.
#[derive(Clone, Debug)]
pub struct Quantiser {
    cuts: [Cut; TONES],
    colours: [Rgb; TONES],
    parts: [Part; TONES],
    count: usize,
}

/// How much a step of red, green and blue is seen.
const SEEN: [(u8, u32); 3] = [(16, 3), (8, 4), (0, 2)];

impl Quantiser {
    /// One tone, black.
    #[must_use]
    pub const fn empty() -> Self {
        let cut = Cut {
            shift: 0,
            at: 0,
            next: [0; 2],
        };
        let part = Part {
            first: 0,
            end: 0,
            cut: 0,
            side: 0,
            shift: 0,
            spread: 0,
        };
        Self {
            cuts: [cut; TONES],
            colours: [0; TONES],
            parts: [part; TONES],
            count: 0,
        }
    }

    /// Finds tones for these colours (at most 65,535 of them), which it puts in another order.
    pub fn build(&mut self, colours: &mut [Rgb]) {
        *self = Self::empty();
        let most = colours.len().min(usize::from(u16::MAX));
        let colours = colours.get_mut(..most).unwrap_or_default();
        let whole = Part {
            end: colours.len() as u16,
            ..Part::default()
        };
        self.set(0, measured(whole, colours));
        self.count = 1;
        // The first cut hangs nowhere: cut 0 is the root.
        let mut cuts = 0;
        while self.count < TONES {
            let parts = self.parts.iter().take(self.count).enumerate();
            let Some((index, part)) = parts.max_by_key(|(_, part)| part.spread) else {
                break;
            };
            if part.spread == 0 {
                break;
            }
            let part = *part;
            let (at, middle) = divide(part, colours);
            let (low, high) = (index as u8, self.count as u8);
            if cuts > 0
                && let Some(above) = self.cuts.get_mut(usize::from(part.cut))
                && let Some(next) = above.next.get_mut(usize::from(part.side))
            {
                *next = cuts;
            }
            if let Some(cut) = self.cuts.get_mut(usize::from(cuts)) {
                *cut = Cut {
                    shift: part.shift,
                    at,
                    next: [LEAF | low, LEAF | high],
                };
            }
            let below = |first, end, side| Part {
                first,
                end,
                cut: cuts,
                side,
                ..Part::default()
            };
            self.set(index, measured(below(part.first, middle, 0), colours));
            self.set(self.count, measured(below(middle, part.end, 1), colours));
            self.count += 1;
            cuts += 1;
        }
        for (colour, part) in self.colours.iter_mut().zip(&self.parts).take(self.count) {
            *colour = mean(within(*part, colours));
        }
    }

    fn set(&mut self, index: usize, part: Part) {
        if let Some(slot) = self.parts.get_mut(index) {
            *slot = part;
        }
    }

    /// The tone of a colour, 0 to 127.
    #[inline(always)]
    #[must_use]
    pub fn tone(&self, colour: Rgb) -> u8 {
        let mut next = 0;
        // A path has at most as many cuts as there are.
        for _ in 0..TONES {
            let Some(cut) = self.cuts.get(usize::from(next)) else {
                break;
            };
            let high = (colour >> cut.shift) as u8 >= cut.at;
            let [low_side, high_side] = cut.next;
            next = if high { high_side } else { low_side };
            if next & LEAF != 0 {
                break;
            }
        }
        next & !LEAF
    }

    /// The colour of a tone.
    #[must_use]
    pub fn colour(&self, tone: u8) -> Rgb {
        let colour = self.colours.get(usize::from(tone));
        colour.copied().unwrap_or(0)
    }
}

fn within(part: Part, colours: &[Rgb]) -> &[Rgb] {
    colours
        .get(usize::from(part.first)..usize::from(part.end))
        .unwrap_or_default()
}

/// With the widest channel and how much it counts: its width times the root of the number of colours.
fn measured(part: Part, colours: &[Rgb]) -> Part {
    let colours = within(part, colours);
    let (mut low, mut high) = ([255; 3], [0; 3]);
    for colour in colours {
        for ((low, high), (shift, _)) in low.iter_mut().zip(&mut high).zip(SEEN) {
            let c = colour >> shift & 255;
            *low = c.min(*low);
            *high = c.max(*high);
        }
    }
    let widths = low.iter().zip(&high).zip(SEEN);
    let widths =
        widths.map(|((low, high), (shift, seen))| (high.saturating_sub(*low) * seen, shift));
    let (width, shift) = widths.max_by_key(|(width, _)| *width).unwrap_or_default();
    let root = ((colours.len() as u32) << 4).isqrt();
    Part {
        shift,
        spread: width * root,
        ..part
    }
}

/// Puts the colours below the mean of the widest channel first. Returns the least value that is not
/// below, and where the upper ones begin; neither side is empty.
fn divide(part: Part, colours: &mut [Rgb]) -> (u8, u16) {
    let channel = |colour: Rgb| colour >> part.shift & 255;
    let colours = colours.get_mut(usize::from(part.first)..usize::from(part.end));
    let colours = colours.unwrap_or_default();
    let sum: u32 = colours.iter().map(|c| channel(*c)).sum();
    // Above the least, since not all are equal.
    let at = sum / (colours.len() as u32).max(1) + 1;
    let mut below = 0;
    for i in 0..colours.len() {
        if colours.get(i).is_some_and(|c| channel(*c) < at) {
            colours.swap(below, i);
            below += 1;
        }
    }
    (at as u8, part.first + below as u16)
}

fn mean(colours: &[Rgb]) -> Rgb {
    let count = (colours.len() as u32).max(1);
    let of = |shift: u8| {
        let sum: u32 = colours.iter().map(|c| c >> shift & 255).sum();
        ((sum + count / 2) / count) << shift
    };
    of(16) | of(8) | of(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn channels(c: Rgb) -> [i32; 3] {
        [c >> 16, c >> 8 & 255, c & 255].map(|c| c as i32)
    }

    #[test]
    fn up_to_as_many_colours_as_tones_are_kept() {
        let colours: Vec<Rgb> = (0..TONES as u32).map(|i| i * 0x0002_0101).collect();
        let mut quantiser = Quantiser::empty();
        quantiser.build(&mut colours.clone());
        for colour in colours {
            assert_eq!(quantiser.colour(quantiser.tone(colour)), colour);
        }
    }

    #[test]
    fn no_colour_and_one_have_a_tone() {
        let mut quantiser = Quantiser::empty();
        quantiser.build(&mut []);
        assert_eq!(quantiser.tone(0x0012_3456), 0);
        quantiser.build(&mut [0x0012_3456; 7]);
        assert_eq!(quantiser.colour(quantiser.tone(0)), 0x0012_3456);
    }

    proptest! {
        #[test]
        fn ramps_of_several_colours_find_tones_near_them(
            ends in prop::collection::vec(0..0x0100_0000u32, 1..8)
        ) {
            let mut colours = Vec::new();
            for end in &ends {
                for step in 0..64 {
                    let [r, g, b] = channels(*end).map(|c| (c * step / 63) as u32);
                    colours.push(r << 16 | g << 8 | b);
                }
            }
            let mut quantiser = Quantiser::empty();
            quantiser.build(&mut colours.clone());
            // 128 tones among so many ramps: a step is at most so large.
            let step = 10 + 5 * ends.len() as i32;
            for colour in colours {
                let found = channels(quantiser.colour(quantiser.tone(colour)));
                for (a, b) in channels(colour).into_iter().zip(found) {
                    prop_assert!((a - b).abs() <= step, "{colour:06x} {found:?}");
                }
            }
        }
    }
}
