//! Shading before drawing: one colour a normal and material (paper, section 5.5).
//!
//! Lights are directional and the eye's place enters by one direction an instance
//! ([`crate::lighting`]), so a sample's colour depends on its attribute word alone: one look-up while
//! drawing.

use crate::blob::format::MAX_MATERIALS;
use crate::blob::{Blob, Grid, Layout, Material};
use crate::lighting::{Lighting, rgb565};
use crate::mode::ShadowMode;
use crate::normal::{BITS, COUNT, FACES, OCTANT};
use crate::q::Unit;
use crate::quantise::{Rgb, TONES};
use crate::render::ShadowView;
#[cfg(rho_thumb)]
use crate::render::shadow::LookUp;
use crate::scene::Placed;
use crate::unlit::{self, Unlit};

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

    /// Whether samples must come in the order in which the light meets them.
    const MEETS: bool = false;

    /// Along each axis of the grid, whether higher cells are nearer to that light.
    #[inline(always)]
    fn higher(&self) -> [bool; 3] {
        [false; 3]
    }

    /// Meets a sample in a cell at this place in the light: it shades what is met later. Its colour.
    #[inline(always)]
    fn meet(&self, word: u32, _place: u32) -> u16 {
        self.colour(word)
    }

    /// Meets all samples below a cell of `level` that is out of sight.
    #[inline(always)]
    fn meet_below(&self, _grid: &Grid<'_>, _level: usize, _node: u32, _place: [i32; 3]) {}

    /// The colour of a sample in a cell at this place in the light.
    #[inline(always)]
    fn colour_at(&self, word: u32, _place: u32) -> u16 {
        self.colour(word)
    }

    /// The tones by normal (13 bits), or by normal (11 bits) and material (3 bits) if `both` are
    /// asked, if it has such a table.
    #[cfg(rho_thumb)]
    fn tones(&self, _both: bool) -> Option<&[u8]> {
        None
    }

    /// The tones of what the light does not reach, and the bits of a row.
    #[cfg(rho_thumb)]
    #[inline(always)]
    fn unlit_tones(&self) -> Option<(&[[u8; MAX_MATERIALS]; unlit::NORMALS], u32)> {
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
    /// Of each material where the first light does not reach.
    unlit: &'a [[u16; MAX_MATERIALS]],
    unlit_by: Unlit,
    /// Bits under the normal in an attribute word.
    under_normal: u32,
    /// The bits of the normal.
    normal: u32,
    /// From the layout's normals to those of 13 bits.
    lift: u32,
    /// Bits under the material.
    under_material: u32,
    /// The bits of the material.
    material: u32,
    /// Words carry colours, and the table is the light on white.
    is_coloured: bool,
}

impl<'a> Shading<'a> {
    /// Words needed for `materials` materials.
    #[must_use]
    pub const fn words(materials: usize) -> usize {
        materials * COUNT + MAX_MATERIALS * unlit::NORMALS
    }

    /// Shades every normal under every material; `None` when the table is too small.
    ///
    /// Channels are rounded to the nearest of 32 or 64 levels.
    #[must_use]
    pub fn new(
        table: &'a mut [u16],
        layout: Layout,
        materials: impl ExactSizeIterator<Item = Material> + Clone,
        lighting: &Lighting,
    ) -> Option<Self> {
        // Of a layout's coarser normals only those in the middle of them are looked up.
        Self::every(table, layout, materials, lighting, 1 << lift(layout), false)
    }

    /// The same for each `every`th normal, which serves those up to the next, too; and, with
    /// `shadows`, for what the first light does not reach.
    fn every(
        table: &'a mut [u16],
        layout: Layout,
        materials: impl ExactSizeIterator<Item = Material> + Clone,
        lighting: &Lighting,
        every: usize,
        shadows: bool,
    ) -> Option<Self> {
        let words = Self::words(materials.len());
        let (unlit, table) = table.get_mut(..words)?.split_at_mut(Self::words(0));
        let unlit = unlit.as_chunks_mut().0;
        let unlit_by = Unlit::shade(unlit, materials.clone(), lighting, shadows, rgb565);
        let tables = table.chunks_exact_mut(COUNT);
        for (material, colours) in materials.zip(tables) {
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
            unlit,
            unlit_by,
            under_normal: u32::from(layout.offset + layout.material) & 31,
            normal: layout.normal_of(u32::MAX),
            lift: lift(layout),
            under_material: u32::from(layout.offset) & 31,
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
        let shadows = placed.mode.shadows != ShadowMode::None;
        let mut shading = Self::every(table, layout, materials, lighting, every, shadows)?;
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
        let material = word >> self.under_material & self.material;
        let index = material << BITS | normal;
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

    #[inline(always)]
    fn unlit(&self, word: u32) -> u16 {
        let normal = ((word >> self.under_normal) & self.normal) << self.lift;
        let material = word >> self.under_material & self.material;
        let colour = self.unlit_by.of(self.unlit, normal, material).unwrap_or(0);
        if self.is_coloured {
            return product(colour, (word >> 16) as u16);
        }
        colour
    }
}

/// Shades all normals of one model under one white light towards `towards`, a unit vector in the
/// grid's own axes: tones of the first of `materials`, doubled, plus one. From a material's tones to
/// the next one's are twice [`steps`].
///
/// The palette is divided evenly among the materials: with one there are 128 steps from dark to
/// bright, twice as many as a channel of RGB565 has; with eight there are 16. Of two opposite normals
/// one faces away from the light, so four sums shade eight normals.
pub(crate) fn even_tones(tones: &mut [u8; COUNT], materials: usize, towards: [Unit; 3]) {
    let light = stepped(towards, steps(materials));
    let (front, opposite) = tones.split_at_mut(COUNT / 2);
    let (front, _) = front.as_chunks_mut::<OCTANT>();
    let (opposite, _) = opposite.as_chunks_mut::<OCTANT>();
    if let (Some(front), Some(opposite)) = (front.first_chunk_mut(), opposite.first_chunk_mut()) {
        pairs(front, opposite, light);
    }
}

/// The tones of all normals: four octants, and those opposite to them, the last one's first. A function of its own, so
/// that each half is written from one register.
#[inline(never)]
fn pairs(front: &mut [[u8; OCTANT]; 4], opposite: &mut [[u8; OCTANT]; 4], [lx, ly, lz]: [i32; 3]) {
    let ([f0, f1, f2, f3], [b0, b1, b2, b3]) = (front, opposite);
    // Sums have half a step more.
    let pair = |front: &mut u8, opposite: &mut u8, sum: i32| {
        *front = cut_tone(sum);
        *opposite = cut_tone(STEP - sum);
    };
    let fronts = f0.iter_mut().zip(f1).zip(f2).zip(f3);
    let opposites = b0.iter_mut().zip(b1).zip(b2).zip(b3);
    for ((face, (((f0, f1), f2), f3)), (((b0, b1), b2), b3)) in
        FACES.iter().zip(fronts).zip(opposites)
    {
        let [x, y, z] = face.map(i32::from);
        let (x, y, z) = (x * lx + STEP / 2, y * ly, z * lz);
        pair(f0, b3, x + y + z);
        pair(f1, b2, x + y - z);
        pair(f2, b1, x - y + z);
        pair(f3, b0, x - y - z);
    }
}

/// A direction in which the brightest of `steps` is at 2^8: with a normal's 2^14, a step is 2^22.
fn stepped(towards: [Unit; 3], steps: usize) -> [i32; 3] {
    towards.map(|c| (i32::from(c.to_bits()) * (steps as i32 - 1)) >> 6)
}

/// The tone of such a product with a normal, doubled, plus one. Half a step is added, so that a step is rounded to
/// nearest; what faces away is negative, and dark.
#[inline(always)]
fn even_tone(sum: i32) -> u8 {
    cut_tone(sum + STEP / 2)
}

/// The same of a product with half a step added.
#[inline(always)]
fn cut_tone(sum: i32) -> u8 {
    ((sum >> 21).clamp(0, 255) | 1) as u8
}

/// From one tone's product to the next one's.
const STEP: i32 = 1 << 22;

/// As [`even_tones`], of every fourth normal and of all materials side by side: eight bytes a normal, in words.
pub(crate) fn even_tones_of_several(tones: &mut [[u32; 2]], materials: usize, towards: [Unit; 3]) {
    let steps = steps(materials);
    let [lx, ly, lz] = stepped(towards, steps);
    let materials: [u32; 2] = [0u32, 4].map(|first| {
        let tone = |m: u32| (2 * steps as u32 * (first + m)) & 255;
        tone(0) | tone(1) << 8 | tone(2) << 16 | tone(3) << 24
    });
    for (octant, tones) in tones.chunks_exact_mut(OCTANT / 4).enumerate() {
        let turned = |axis: usize, c: i32| if octant >> (2 - axis) & 1 == 1 { -c } else { c };
        let (lx, ly, lz) = (turned(0, lx), turned(1, ly), turned(2, lz));
        for (pair, face) in tones.iter_mut().zip(FACES.iter().step_by(4)) {
            let [x, y, z] = face.map(i32::from);
            let tone = u32::from(even_tone(x * lx + y * ly + z * lz));
            // Of eight materials each has 16 steps: no sum is carried into the next byte of those that there are.
            *pair = materials.map(|m| m.wrapping_add(tone * 0x0101_0101));
        }
    }
}

/// Steps from dark to bright of each of `materials`.
pub(crate) const fn steps(materials: usize) -> usize {
    match materials {
        0 | 1 => TONES,
        _ => TONES / materials,
    }
}

/// A colour that can be averaged: levels of RGB565 in eighths (red, blue) and quarters (green), ten bits
/// each, of which a colour takes eight; half a level more, so that what is cut off from a mean is rounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Addend(u32);

impl Addend {
    fn new([red, green, blue]: [u32; 3]) -> Self {
        // A quarter of half a level: four are added.
        Self((red + 4) << 20 | (green + 2) << 10 | (blue + 4))
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
        // Below 2^10 a channel, so none reaches into the next.
        let sum = a.0 + b.0 + c.0 + d.0;
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

    /// For tones of these colours.
    #[must_use]
    pub fn of_tones(colour: impl Fn(u8) -> Rgb, background: u16) -> Self {
        let mut palette = Self {
            colours: [background; TONES],
            addends: [Addend::of(background); TONES],
            background,
        };
        let slots = palette.colours.iter_mut().zip(&mut palette.addends);
        for (tone, (slot, addend)) in (0..).zip(slots) {
            // 8 bits to Q15, to nearest.
            let rgb = colour(tone);
            let channels = [16, 8, 0].map(|shift| (((rgb >> shift & 255) << 15) + 127) / 255);
            *slot = rgb565(channels);
            *addend = Addend::of_channels(channels);
        }
        palette
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
    rgb565(lit_by_one(material, lit))
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
            let mut tones = [0; COUNT];
            even_tones(&mut tones, materials, towards);
            let last = (steps(materials) - 1) as f64;
            for (index, tone) in (0..).zip(tones) {
                let n = crate::normal::normal(index).map(|c| f64::from(c.to_bits()) / 16384.0);
                let dot: f64 = (0..3).map(|k| n[k] * light[k]).sum();
                assert_eq!(tone & 1, 1);
                let step = f64::from(tone >> 1);
                assert!((step - dot.max(0.0) * last).abs() < 0.62, "{index}: {step}");
            }
        }
    }

    #[test]
    fn several_materials_side_by_side_have_the_tones_of_each_of_them() {
        let towards = [-0.48, 0.6, 0.64f64].map(|v| Unit::from_bits((v * 16384.0).round() as i16));
        for materials in [2, 3, 8] {
            let (mut one, mut several) = ([0; COUNT], [[0; 2]; COUNT / 4]);
            even_tones(&mut one, materials, towards);
            even_tones_of_several(&mut several, materials, towards);
            for (normal, pair) in several.iter().enumerate() {
                let tones: &[u8] = bytemuck::cast_slice(pair);
                for (m, tone) in tones.iter().take(materials).enumerate() {
                    let alone = usize::from(one[4 * normal]) + 2 * steps(materials) * m;
                    assert_eq!(usize::from(*tone), alone, "{normal} {m} of {materials}");
                }
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
