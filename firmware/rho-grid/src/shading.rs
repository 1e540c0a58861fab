//! Shading before drawing: one colour a normal and material (paper, section 5.5).
//!
//! Lights are directional and the eye's place enters by one direction an instance
//! ([`crate::lighting`]), so a sample's colour depends on its attribute word alone: one look-up while
//! drawing.

use crate::blob::format::MAX_MATERIALS;
use crate::blob::{Blob, Layout, Material};
use crate::lighting::{self, Lighting};
use crate::normal::{BITS, COUNT, FACES, OCTANT};
use crate::q::Unit;
use crate::quantise::{Rgb, TONES};
use crate::scene::Placed;

/// What a sample looks like, in the unit of the frame it is drawn into.
pub trait Shade {
    /// The colour of a sample with this attribute word of 16 bits.
    fn colour(&self, word: u32) -> u16;

    /// The colour of a sample with the normal `index` (13 bits) and the first material.
    fn of_normal(&self, index: u32) -> u16;

    /// The tones of the first material, if colours are tones.
    #[cfg(rho_thumb)]
    fn tones(&self) -> Option<&[u8; COUNT]> {
        None
    }
}

/// Colours of every normal under every material, RGB565.
#[derive(Clone, Copy, Debug)]
pub struct Shading<'a> {
    colours: &'a [u16],
    /// Bits under the normal in an attribute word.
    under_normal: u32,
    /// The bits of the normal.
    normal: u32,
    /// From the layout's normals to those of 13 bits.
    lift: u32,
    /// The bits of the material.
    material: u32,
    /// Words carry colours, and the table is the light on white.
    is_coloured: bool,
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
        // Of a layout's coarser normals only those in the middle of them are looked up.
        Self::every(table, layout, materials, lighting, 1 << lift(layout))
    }

    /// The same for each `every`th normal, which serves those up to the next, too.
    fn every(
        table: &'a mut [u16],
        layout: Layout,
        materials: impl ExactSizeIterator<Item = Material>,
        lighting: &Lighting,
        every: usize,
    ) -> Option<Self> {
        let words = Self::words(materials.len());
        let table = table.get_mut(..words)?;
        for (material, colours) in materials.zip(table.chunks_exact_mut(COUNT)) {
            let surface = lighting.on(&material);
            for (octant, colours) in colours.chunks_exact_mut(OCTANT).enumerate() {
                let sign = |bit: usize, v: i16| {
                    let v = i32::from(v);
                    if octant & bit == 0 { v } else { -v }
                };
                let faces = FACES.iter().step_by(every);
                for (colours, [x, y, z]) in colours.chunks_mut(every).zip(faces) {
                    colours.fill(surface.rgb565([sign(4, *x), sign(2, *y), sign(1, *z)]));
                }
            }
        }
        Some(Self {
            colours: table,
            under_normal: u32::from(layout.offset + layout.material) & 31,
            normal: layout.normal_of(u32::MAX),
            lift: lift(layout),
            material: layout.material_of(u32::MAX),
            is_coloured: false,
        })
    }

    /// The same for an instance of `blob`.
    ///
    /// A grid of 40 cells an axis at most has 512 normals: there neighbouring cells differ more.
    #[must_use]
    pub fn of_instance(
        table: &'a mut [u16],
        blob: &Blob<'_>,
        placed: &Placed<'_>,
        lighting: &Lighting,
    ) -> Option<Self> {
        let (layout, instance) = (placed.grid.layout(), &placed.instance);
        let is_coloured = layout.colour > 0 && instance.material.is_none();
        let mut materials = [WHITE; MAX_MATERIALS];
        let mut count = 1;
        if !is_coloured {
            let (first, all) = blob.materials_of(instance)?;
            count = all;
            for (slot, index) in materials.iter_mut().zip(first..) {
                *slot = blob.material(index).unwrap_or_default();
            }
        }
        let materials = materials.into_iter().take(count.into());
        let coarse = blob.is_scene() && placed.grid.cells(placed.grid.subdivisions()) <= 40;
        let every = if coarse { 16 } else { 1 << lift(layout) };
        let mut shading = Self::every(table, layout, materials, lighting, every)?;
        if count == 1 {
            // Whatever its samples name.
            shading.material = 0;
        }
        shading.is_coloured = is_coloured;
        Some(shading)
    }
}

/// What carries its own colours, before they are multiplied: 0.1 in the shade, 0.9 more in the light.
const WHITE: Material = Material {
    ambient: [3277; 3],
    diffuse: [29491; 3],
    specular: [0; 3],
    exponent: 1,
};

/// From a layout's normals to those of 13 bits.
const fn lift(layout: Layout) -> u32 {
    13u32.saturating_sub(layout.normal as u32)
}

/// The product of two RGB565 colours, channels rounded to nearest.
fn product(a: u16, b: u16) -> u16 {
    let channel = |shift: u32, levels: u32| {
        let of = |colour: u16| u32::from(colour) >> shift & levels;
        ((of(a) * of(b) + levels / 2) / levels) << shift
    };
    (channel(11, 31) | channel(5, 63) | channel(0, 31)) as u16
}

impl Shade for Shading<'_> {
    /// RGB565.
    #[inline(always)]
    fn colour(&self, word: u32) -> u16 {
        let normal = ((word >> self.under_normal) & self.normal) << self.lift;
        let index = (word & self.material) << BITS | normal;
        let colour = self.colours.get(index as usize).copied().unwrap_or(0);
        if self.is_coloured {
            return product(colour, (word >> 16) as u16);
        }
        colour
    }

    #[inline(always)]
    fn of_normal(&self, index: u32) -> u16 {
        self.colours.get(index as usize).copied().unwrap_or(0)
    }
}

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
    under_normal: u32,
    /// From the layout's normals to those of 13 bits.
    lift: u32,
    material: u32,
}

impl ToneTable {
    /// Not yet filled: everything is open.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            tones: [0; COUNT],
            per_material: 0,
            under_normal: 0,
            lift: 0,
            material: 0,
        }
    }

    /// Shades all normals with a light towards `towards`, a unit vector in the grid's own axes.
    ///
    /// Of two opposite normals one faces away from the light, so four sums shade eight normals.
    pub fn shade(&mut self, layout: Layout, materials: usize, towards: [Unit; 3]) {
        let steps = steps(materials) as i32;
        self.per_material = 2 * steps as u32;
        self.under_normal = u32::from(layout.offset + layout.material) & 15;
        self.lift = 13u32.saturating_sub(u32::from(layout.normal));
        self.material = layout.material_of(u32::MAX);
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
        Some(&self.tones)
    }

    /// A tone.
    #[inline(always)]
    fn colour(&self, word: u32) -> u16 {
        let material = (word & self.material) * self.per_material;
        self.of_normal(word >> self.under_normal << self.lift) + material as u16
    }

    #[inline(always)]
    fn of_normal(&self, index: u32) -> u16 {
        let tone = self.tones.get(index as usize % COUNT);
        tone.copied().unwrap_or(0).into()
    }
}

/// Steps from dark to bright of each of `materials`.
const fn steps(materials: usize) -> usize {
    match materials {
        0 | 1 => TONES,
        _ => TONES / materials,
    }
}

/// The colours of the tones, RGB565.
#[derive(Clone, Debug)]
pub struct Palette {
    colours: [u16; TONES],
    background: u16,
}

impl Palette {
    /// For at most eight materials.
    #[must_use]
    pub fn new(materials: impl ExactSizeIterator<Item = Material>, background: u16) -> Self {
        let steps = steps(materials.len());
        let mut colours = [background; TONES];
        for (material, colours) in materials.zip(colours.chunks_mut(steps)) {
            for (step, colour) in colours.iter_mut().enumerate() {
                let lit = (step << 15) / (steps - 1);
                *colour = shade(&material, lit as u32);
            }
        }
        Self {
            colours,
            background,
        }
    }

    /// For tones of these colours.
    #[must_use]
    pub fn of_tones(colour: impl Fn(u8) -> Rgb, background: u16) -> Self {
        let mut colours = [background; TONES];
        for (tone, slot) in (0..).zip(&mut colours) {
            // 8 bits to 5 and 6, to nearest.
            let channel =
                |shift: u32, levels: u32| ((colour(tone) >> shift & 255) * levels + 127) / 255;
            *slot = (channel(16, 31) << 11 | channel(8, 63) << 5 | channel(0, 31)) as u16;
        }
        Self {
            colours,
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
}

/// The colour under `lit` = max(0, n.l) of one white light (32768 = 1), RGB565.
fn shade(material: &Material, lit: u32) -> u16 {
    let channel = |ambient: u16, diffuse: u16| {
        let value = u32::from(ambient) + ((u32::from(diffuse) * lit + (1 << 14)) >> 15);
        value.min(1 << 15)
    };
    let ([ar, ag, ab], [dr, dg, db]) = (material.ambient, material.diffuse);
    lighting::rgb565([channel(ar, dr), channel(ag, dg), channel(ab, db)])
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec;

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
