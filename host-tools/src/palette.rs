//! Colours to at most eight materials.
//!
//! A layout with three material bits has room for eight colours. A model of up to eight keeps
//! them exactly; more are gathered by median cut (Heckbert 1982), then moved to the means of what
//! they stand for, twice (Lloyd 1982).

use std::collections::BTreeMap;

use rho_grid::blob::Material;
use rho_grid::blob::format::MAX_MATERIALS;

use crate::sampling::TreeSample;

/// Colours and how many samples have them.
type Counts = Vec<([u8; 3], u64)>;

/// The colours of a model's materials.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Palette {
    colours: Vec<[u8; 3]>,
    /// Materials are twice as many: those in the light, then those in the shade.
    is_shaded: bool,
}

impl Palette {
    /// At most eight colours for these samples; the same whatever their order.
    #[must_use]
    pub fn of(samples: impl Iterator<Item = [u8; 3]>) -> Self {
        Self::of_at_most(MAX_MATERIALS, samples)
    }

    /// The same for at most `most` colours, at least 1.
    #[must_use]
    pub fn of_at_most(most: usize, samples: impl Iterator<Item = [u8; 3]>) -> Self {
        let mut counts = BTreeMap::<[u8; 3], u64>::new();
        for colour in samples {
            *counts.entry(colour).or_default() += 1;
        }
        let all: Counts = counts.into_iter().collect();
        if all.len() <= most {
            let mut colours: Vec<_> = all.iter().map(|(c, _)| *c).collect();
            if colours.is_empty() {
                colours.push([255; 3]);
            }
            return Self {
                colours,
                is_shaded: false,
            };
        }
        let mut boxes = vec![all.clone()];
        while boxes.len() < most {
            let widest = (0..boxes.len()).max_by_key(|b| spread(&boxes[*b]).0);
            let Some(split) = widest.map(|b| boxes.swap_remove(b)) else {
                break;
            };
            let (low, high) = halve(split);
            boxes.extend([low, high]);
        }
        let mut palette = Self {
            colours: boxes.iter().map(|b| mean(b)).collect(),
            is_shaded: false,
        };
        for _ in 0..2 {
            let mut parts = vec![Vec::new(); palette.colours.len()];
            for entry in &all {
                parts[palette.nearest(entry.0) as usize].push(*entry);
            }
            for (colour, part) in palette.colours.iter_mut().zip(&parts) {
                if !part.is_empty() {
                    *colour = mean(part);
                }
            }
        }
        palette.colours.sort_unstable();
        palette.colours.dedup();
        palette
    }

    /// The colours, 1 to 8.
    #[must_use]
    pub fn colours(&self) -> &[[u8; 3]] {
        &self.colours
    }

    /// The number of the colour nearest to `colour`.
    #[must_use]
    pub fn nearest(&self, colour: [u8; 3]) -> u32 {
        let distance = |c: &[u8; 3]| -> i32 {
            c.iter()
                .zip(colour)
                .map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2))
                .sum()
        };
        (0..self.colours.len())
            .min_by_key(|i| distance(&self.colours[*i]))
            .unwrap_or(0) as u32
    }

    /// The same with a material more for each of at most half as many colours: what lies in a shadow.
    #[must_use]
    pub fn shaded(self) -> Self {
        debug_assert!(2 * self.colours.len() <= MAX_MATERIALS);
        Self {
            is_shaded: true,
            ..self
        }
    }

    /// The number of a sample's material.
    #[must_use]
    pub fn material(&self, sample: &TreeSample) -> u32 {
        let shade = if self.is_shaded && sample.shaded {
            self.colours.len() as u32
        } else {
            0
        };
        self.nearest(sample.colour) + shade
    }

    /// Each colour as the standard scene lights it: 0.1 in the shade, 0.9 more in the light.
    #[must_use]
    pub fn materials(&self) -> Vec<Material> {
        let of = |light: f64| {
            self.colours.iter().map(move |colour| Material {
                ambient: colour.map(|c| part(0.1, c)),
                diffuse: colour.map(|c| part(light, c)),
                specular: [0; 3],
                exponent: 1,
            })
        };
        let lights: &[f64] = if self.is_shaded { &[0.9, 0.0] } else { &[0.9] };
        lights.iter().flat_map(|light| of(*light)).collect()
    }
}

fn part(share: f64, channel: u8) -> u16 {
    (share * f64::from(channel) / 255.0 * 32768.0).round() as u16
}

/// Samples weighted by how widely their colours are spread along the widest channel, and that
/// channel.
fn spread(part: &[([u8; 3], u64)]) -> (u64, usize) {
    let widest = (0..3)
        .map(|channel| {
            let values = part.iter().map(|(c, _)| u64::from(c[channel]));
            let range = values.clone().max().unwrap_or(0) - values.min().unwrap_or(0);
            (range, channel)
        })
        .max()
        .unwrap_or((0, 0));
    let weight: u64 = part.iter().map(|(_, n)| n).sum();
    if part.len() < 2 {
        return (0, widest.1);
    }
    (widest.0 * weight.isqrt() + 1, widest.1)
}

/// Two parts of about as many samples each, along the widest channel.
fn halve(mut part: Counts) -> (Counts, Counts) {
    let channel = spread(&part).1;
    part.sort_by_key(|(c, _)| (c[channel], *c));
    let total: u64 = part.iter().map(|(_, n)| n).sum();
    let mut seen = 0;
    let mut at = 0;
    for (_, n) in &part {
        if 2 * seen >= total {
            break;
        }
        seen += n;
        at += 1;
    }
    let high = part.split_off(at.clamp(1, part.len() - 1));
    (part, high)
}

fn mean(part: &[([u8; 3], u64)]) -> [u8; 3] {
    let weight: u64 = part.iter().map(|(_, n)| n).sum::<u64>().max(1);
    std::array::from_fn(|channel| {
        let sum: u64 = part.iter().map(|(c, n)| u64::from(c[channel]) * n).sum();
        ((sum + weight / 2) / weight) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_model_has_the_standard_scenes_material() {
        let palette = Palette::of(std::iter::empty());
        assert_eq!(palette.colours(), [[255; 3]]);
        let [white] = palette.materials()[..] else {
            panic!("one material");
        };
        assert_eq!((white.ambient, white.diffuse), ([3277; 3], [29491; 3]));
    }

    #[test]
    fn up_to_eight_colours_are_kept_exactly() {
        let colours = [[1, 2, 3], [200, 0, 0], [0, 200, 0]];
        let palette = Palette::of(colours.into_iter().cycle().take(30));
        for colour in colours {
            assert_eq!(palette.colours()[palette.nearest(colour) as usize], colour);
        }
    }

    #[test]
    fn many_colours_become_eight_that_are_near() {
        let ramp = |i: u32| [(i % 256) as u8, (i % 256) as u8, 40];
        let palette = Palette::of((0..1024).map(ramp));
        assert_eq!(palette.colours().len(), 8);
        for i in 0..256 {
            let c = ramp(i);
            let near = palette.colours()[palette.nearest(c) as usize];
            assert!(c[0].abs_diff(near[0]) <= 24, "{c:?} {near:?}");
        }
    }
}
