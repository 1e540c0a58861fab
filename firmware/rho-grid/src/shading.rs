//! Shading before drawing: one colour a normal and material (paper, section 5.5).
//!
//! Lights are directional and the eye's place enters by one direction an instance
//! ([`crate::lighting`]), so a sample's colour depends on its attribute word alone: one look-up while
//! drawing.

use crate::blob::format::MAX_MATERIALS;
use crate::blob::{Blob, Instance, Layout, Material};
use crate::lighting::{self, Lighting};
use crate::normal::{BITS, COUNT, FACES, OCTANT};
use crate::q::Unit;
use crate::render::ShadowView;
#[cfg(rho_thumb)]
use crate::render::shadow::LookUp;

/// What a sample looks like, in the unit of the frame it is drawn into.
pub trait Shade {
    /// The colour of a sample with this attribute word of 16 bits.
    fn colour(&self, word: u32) -> u16;

    /// The colour of a sample with the normal `index` (13 bits) and the first material.
    fn of_normal(&self, index: u32) -> u16;

    /// The colour of a sample with this attribute word that the light does not reach.
    fn unlit(&self, word: u32) -> u16;

    /// Where the grid's cells are in the light, if it matters what lies between.
    #[inline(always)]
    fn light(&self) -> Option<&ShadowView> {
        None
    }

    /// The colour of a sample in a cell at this place in the light.
    #[inline(always)]
    fn colour_at(&self, word: u32, _place: u32) -> u16 {
        self.colour(word)
    }

    /// The tones of the first material, if colours are tones.
    #[cfg(rho_thumb)]
    fn tones(&self) -> Option<&[u8; COUNT]> {
        None
    }

    /// Where shadows are looked up, if they are and colours are tones.
    #[cfg(rho_thumb)]
    #[inline(always)]
    fn look_up(&self) -> Option<LookUp<'_>> {
        None
    }
}

/// Colours of every normal under every material, RGB565.
#[derive(Clone, Copy, Debug)]
pub struct Shading<'a> {
    colours: &'a [u16],
    /// Of each material in the dark.
    unlit: [u16; MAX_MATERIALS],
    /// Bits under the normal in an attribute word.
    under_normal: u32,
    /// The bits of the material.
    material: u32,
}

impl<'a> Shading<'a> {
    /// Words needed for `materials` materials.
    #[must_use]
    pub const fn words(materials: usize) -> usize {
        materials * COUNT
    }

    /// Shades every normal under every material; `None` when the table is too small.
    ///
    /// Channels are rounded to the nearest of 32 or 64 levels.
    #[must_use]
    pub fn new(
        table: &'a mut [u16],
        layout: Layout,
        materials: impl ExactSizeIterator<Item = Material>,
        lighting: &Lighting,
    ) -> Option<Self> {
        let words = Self::words(materials.len());
        let table = table.get_mut(..words)?;
        let mut unlit = [0; MAX_MATERIALS];
        let tables = table.chunks_exact_mut(COUNT).zip(&mut unlit);
        for (material, (colours, unlit)) in materials.zip(tables) {
            let surface = lighting.on(&material);
            *unlit = surface.unlit();
            for (octant, colours) in colours.chunks_exact_mut(OCTANT).enumerate() {
                let sign = |bit: usize, v: i16| {
                    let v = i32::from(v);
                    if octant & bit == 0 { v } else { -v }
                };
                for (colour, [x, y, z]) in colours.iter_mut().zip(&FACES) {
                    *colour = surface.rgb565([sign(4, *x), sign(2, *y), sign(1, *z)]);
                }
            }
        }
        Some(Self {
            colours: table,
            unlit,
            under_normal: u32::from(layout.offset + layout.material) & 31,
            material: layout.material_of(u32::MAX),
        })
    }

    /// The same for an instance of `blob` in a grid of this layout.
    #[must_use]
    pub fn of_instance(
        table: &'a mut [u16],
        layout: Layout,
        blob: &Blob<'_>,
        instance: &Instance,
        lighting: &Lighting,
    ) -> Option<Self> {
        let (first, count) = blob.materials_of(instance)?;
        let mut materials = [Material::default(); MAX_MATERIALS];
        for (slot, index) in materials.iter_mut().zip(first..) {
            *slot = blob.material(index).unwrap_or_default();
        }
        let materials = materials.into_iter().take(count.into());
        let mut shading = Self::new(table, layout, materials, lighting)?;
        if count == 1 {
            // Whatever its samples name.
            shading.material = 0;
        }
        Some(shading)
    }
}

impl Shade for Shading<'_> {
    /// RGB565.
    #[inline(always)]
    fn colour(&self, word: u32) -> u16 {
        let index = (word & self.material) << BITS | word >> self.under_normal;
        self.colours.get(index as usize).copied().unwrap_or(0)
    }

    #[inline(always)]
    fn of_normal(&self, index: u32) -> u16 {
        self.colours.get(index as usize).copied().unwrap_or(0)
    }

    #[inline(always)]
    fn unlit(&self, word: u32) -> u16 {
        let material = (word & self.material) as usize;
        self.unlit.get(material).copied().unwrap_or(0)
    }
}

/// Tones there are: seven bits.
const TONES: usize = 128;
/// How bright each normal is, for frames of a byte a pixel.
///
/// The palette is divided evenly among the materials: with one there are 128 steps from dark to
/// bright, twice as many as a channel of RGB565 has; with eight there are 16.
#[derive(Clone, Debug)]
pub struct ToneTable {
    /// Doubled, plus one ([`Tones`](crate::render::Tones)); of the first material.
    tones: [u8; COUNT],
    /// From a material's tones to the next one's.
    per_material: u32,
    /// Of the first material.
    first: u16,
    under_normal: u32,
    material: u32,
}

impl ToneTable {
    /// Not yet filled: everything is open.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            tones: [0; COUNT],
            per_material: 0,
            first: 0,
            under_normal: 0,
            material: 0,
        }
    }

    /// Shades all normals with a light towards `towards`, a unit vector in the grid's own axes.
    ///
    /// Of two opposite normals one faces away from the light, so four sums shade eight normals.
    pub fn shade(&mut self, layout: Layout, materials: usize, towards: [Unit; 3]) {
        self.shade_from(layout, materials, 0, false, towards);
    }

    /// The same for samples whose material 0 is the palette's `first`; `one` material for all of them
    /// if asked.
    pub fn shade_from(
        &mut self,
        layout: Layout,
        materials: usize,
        first: u16,
        one: bool,
        towards: [Unit; 3],
    ) {
        let steps = steps(materials) as i32;
        self.per_material = 2 * steps as u32;
        self.first = self.per_material as u16 * first;
        self.under_normal = u32::from(layout.offset + layout.material) & 15;
        self.material = if one { 0 } else { layout.material_of(u32::MAX) };
        // The brightest step at 2^8; with a normal's 2^14, a step is 2^22.
        let [lx, ly, lz] = towards.map(|c| (i32::from(c.to_bits()) * (steps - 1)) >> 6);
        let (front, opposite) = self.tones.split_at_mut(COUNT / 2);
        let (front, _) = front.as_chunks_mut::<OCTANT>();
        let (opposite, _) = opposite.as_chunks_mut::<OCTANT>();
        let ([f0, f1, f2, f3], [b0, b1, b2, b3]) = (front, opposite) else {
            return;
        };
        // Half a step is added, so that a step is rounded to nearest; doubled, plus one. What faces
        // away is negative, and dark.
        let half = 1 << 21;
        let tone = |sum: i32| ((sum >> 21).clamp(0, 255) | 1) as u8;
        let pair = |front: &mut u8, opposite: &mut u8, sum: i32| {
            *front = tone(half + sum);
            *opposite = tone(half - sum);
        };
        let fronts = f0.iter_mut().zip(f1).zip(f2).zip(f3);
        let opposites = b0.iter_mut().zip(b1).zip(b2).zip(b3);
        for ((face, (((f0, f1), f2), f3)), (((b0, b1), b2), b3)) in
            FACES.iter().zip(fronts).zip(opposites)
        {
            let [x, y, z] = face.map(i32::from);
            let (x, y, z) = (x * lx, y * ly, z * lz);
            pair(f0, b3, x + y + z);
            pair(f1, b2, x + y - z);
            pair(f2, b1, x - y + z);
            pair(f3, b0, x - y - z);
        }
    }
}

impl Shade for ToneTable {
    #[cfg(rho_thumb)]
    fn tones(&self) -> Option<&[u8; COUNT]> {
        (self.first == 0).then_some(&self.tones)
    }

    /// A tone.
    #[inline(always)]
    fn colour(&self, word: u32) -> u16 {
        let material = (word & self.material) * self.per_material;
        self.of_normal(word >> self.under_normal) + material as u16
    }

    #[inline(always)]
    fn of_normal(&self, index: u32) -> u16 {
        let tone = self.tones.get(index as usize % COUNT);
        u16::from(tone.copied().unwrap_or(0)) + self.first
    }

    #[inline(always)]
    fn unlit(&self, word: u32) -> u16 {
        ((word & self.material) * self.per_material + 1) as u16 + self.first
    }
}

/// Steps from dark to bright of each of `materials`.
const fn steps(materials: usize) -> usize {
    match materials {
        0 | 1 => TONES,
        _ => TONES / materials,
    }
}

/// A colour that can be averaged: levels of RGB565 in eighths (red, blue) and quarters (green), ten bits
/// each, of which a colour takes eight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Addend(u32);

impl Addend {
    fn new([red, green, blue]: [u32; 3]) -> Self {
        Self(red << 20 | green << 10 | blue)
    }

    /// Of red, green, blue of Q15, 0 to 1.
    fn of_channels([red, green, blue]: [u32; 3]) -> Self {
        let channel = |value: u32, levels: u32| (value * levels + (1 << 14)) >> 15;
        Self::new([
            channel(red, 31 * 8),
            channel(green, 63 * 4),
            channel(blue, 31 * 8),
        ])
    }

    /// Of a colour without fractions.
    fn of(colour: u16) -> Self {
        let colour = u32::from(colour);
        Self::new([
            colour >> 11 << 3,
            (colour >> 5 & 63) << 2,
            (colour & 31) << 3,
        ])
    }

    /// The mean of four, RGB565, each channel rounded to nearest.
    #[inline(always)]
    #[must_use]
    pub fn mean([a, b, c, d]: [Self; 4]) -> u16 {
        // At most 4 x 255 a channel, half a level included, so none reaches into the next.
        let sum = a.0 + b.0 + c.0 + d.0 + (16 << 20 | 8 << 10 | 16);
        ((sum >> 14) & 0xF800 | (sum >> 9) & 0x07E0 | (sum >> 5) & 0x1F) as u16
    }
}

/// The colours of the tones, RGB565.
#[derive(Clone, Debug)]
pub struct Palette {
    colours: [u16; TONES],
    addends: [Addend; TONES],
    background: u16,
}

impl Palette {
    /// For at most eight materials.
    #[must_use]
    pub fn new(materials: impl ExactSizeIterator<Item = Material>, background: u16) -> Self {
        let steps = steps(materials.len());
        let mut colours = [background; TONES];
        let mut addends = [Addend::of(background); TONES];
        let tones = colours.chunks_mut(steps).zip(addends.chunks_mut(steps));
        for (material, (colours, addends)) in materials.zip(tones) {
            for (step, (colour, addend)) in colours.iter_mut().zip(addends).enumerate() {
                let lit = ((step << 15) / (steps - 1)) as u32;
                *colour = shade(&material, lit);
                *addend = Addend::of_channels(lit_by_one(&material, lit));
            }
        }
        Self {
            colours,
            addends,
            background,
        }
    }

    /// The colour of a pixel, RGB565.
    #[must_use]
    pub fn colour(&self, tone: u8) -> u16 {
        if tone & 1 == 0 {
            return self.background;
        }
        let colour = self.colours.get(usize::from(tone >> 1)).copied();
        colour.unwrap_or(self.background)
    }

    /// The colour of a pixel, to be averaged.
    #[must_use]
    pub fn addend(&self, tone: u8) -> Addend {
        let addend = self.addends.get(usize::from(tone >> 1)).copied();
        let covered = addend.filter(|_| tone & 1 == 1);
        covered.unwrap_or(Addend::of(self.background))
    }
}

/// The colour under `lit` = max(0, n.l) of one white light (32768 = 1), RGB565.
fn shade(material: &Material, lit: u32) -> u16 {
    lighting::rgb565(lit_by_one(material, lit))
}

/// Red, green, blue of Q15, 0 to 1, under `lit` of one white light.
fn lit_by_one(material: &Material, lit: u32) -> [u32; 3] {
    let channel = |ambient: u16, diffuse: u16| {
        let value = u32::from(ambient) + ((u32::from(diffuse) * lit + (1 << 14)) >> 15);
        value.min(1 << 15)
    };
    let ([ar, ag, ab], [dr, dg, db]) = (material.ambient, material.diffuse);
    [channel(ar, dr), channel(ag, dg), channel(ab, db)]
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec;

    const WHITE: Material = Material {
        ambient: [3277; 3],
        diffuse: [29491; 3],
        specular: [0; 3],
        exponent: 1,
    };

    #[test]
    fn every_colour_is_the_exact_one_or_a_level_beside_it_where_rounding_is_close() {
        let light = [0.4, 0.6, 0.7f64];
        let length = light.iter().map(|v| v * v).sum::<f64>().sqrt();
        let light = light.map(|v| v / length);
        let towards = light.map(|v| Unit::from_bits((v * 16384.0).round() as i16));
        let mut table = vec![0; Shading::words(1)];
        let shading = Shading::new(
            &mut table,
            Layout::MATERIAL,
            [WHITE].into_iter(),
            &Lighting::white(towards),
        )
        .unwrap();
        for index in 0..COUNT as u32 {
            let n = crate::normal::normal(index).map(|c| f64::from(c.to_bits()) / 16384.0);
            let dot: f64 = (0..3).map(|k| n[k] * light[k]).sum();
            let value = 0.1 + 0.9 * dot.max(0.0);
            let colour = shading.colour(index << 3);
            let green = f64::from(colour >> 5 & 63);
            assert!((green - value * 63.0).abs() < 0.52, "{index}: {green}");
            assert_eq!(colour >> 11, colour & 31);
        }
    }

    #[test]
    fn every_tone_is_the_exact_one_or_a_step_beside_it_where_rounding_is_close() {
        let light = [-0.48, 0.6, 0.64f64];
        let towards = light.map(|v| Unit::from_bits((v * 16384.0).round() as i16));
        for materials in [1, 3, 8] {
            let mut table = ToneTable::empty();
            table.shade(Layout::MATERIAL, materials, towards);
            let last = (steps(materials) - 1) as f64;
            for index in 0..COUNT as u32 {
                let n = crate::normal::normal(index).map(|c| f64::from(c.to_bits()) / 16384.0);
                let dot: f64 = (0..3).map(|k| n[k] * light[k]).sum();
                let tone = table.colour(index << 3 | (materials - 1) as u32);
                let first = (materials - 1) * steps(materials);
                assert_eq!(tone & 1, 1);
                let step = f64::from(tone >> 1) - first as f64;
                assert!((step - dot.max(0.0) * last).abs() < 0.62, "{index}: {step}");
            }
        }
    }

    #[test]
    fn a_mean_of_four_colours_is_the_nearest_in_each_channel() {
        let colours = [0xFFFF, 0, 0x1234, 0x8765, 0xF81F, 0x07E0, 0x8410];
        let at = |i: usize| colours[i % colours.len()];
        for i in 0..colours.len() * colours.len() {
            let four = [at(i), at(i / 7), at(i + 3), at(i / 2)];
            let mean = Addend::mean(four.map(Addend::of));
            for (shift, most) in [(11, 31), (5, 63), (0, 31)] {
                let of = |colour: u16| u32::from(colour >> shift) & most;
                let exact = four.iter().map(|c| of(*c)).sum::<u32>();
                assert_eq!(of(mean), (exact + 2) / 4);
            }
        }
    }

    #[test]
    fn a_table_too_small_is_refused() {
        let mut table = [0; 100];
        let towards = [Unit::ZERO; 3];
        assert!(
            Shading::new(
                &mut table,
                Layout::MATERIAL,
                [WHITE].into_iter(),
                &Lighting::white(towards)
            )
            .is_none()
        );
    }
}
