//! Tones for scenes: one palette for all that the frame's materials yield under its lights.
//!
//! A palette divided among the materials beforehand would give most of its tones to colours that
//! nothing has: a flat ground has one, and what has no highlight needs none for it. So the colours
//! which the materials in use yield are gathered, and 128 tones found for them
//! ([`crate::quantise`]). Per instance a table then tells the tone of each normal under each of its
//! materials, with as many normals as its grid can show.

use super::Placed;
use crate::blob::format::{MAX_MATERIALS, MAX_SCENE_MATERIALS};
use crate::blob::{Blob, Instance, Layout, Material};
use crate::camera::Camera;
use crate::lighting::Lighting;
use crate::mode::ShadowMode;
use crate::normal::{COUNT, FACES, normal, signed};
use crate::q::Unit;
use crate::quantise::{Quantiser, Rgb, TONES, pack};
use crate::shading::{Palette, Shade, even_tones, even_tones_of_several, steps};
use crate::unlit::{self, Unlit};

/// Steps of light on a material without highlight, under one light.
const STEPS: usize = 64;

/// How many samples of an instance say what is seen of it.
const SAMPLES: u32 = 32;

/// Words of the table: 8 materials of 2,048 normals, four tones a word.
const WORDS: usize = MAX_MATERIALS * COUNT / 4 / 4;

/// The tones of a frame, about 22 kB.
#[derive(Clone, Debug)]
pub struct SceneTones {
    quantiser: Quantiser,
    /// The tones of each material from dark to lit, where it has one light and no highlight.
    ramps: [[u8; STEPS]; MAX_SCENE_MATERIALS],
    /// Of the materials in use those that have a ramp, a bit each.
    ramped: u32,
    /// Tones, four a word: 8,192 normals of one material, or eight materials of each of 2,048 normals.
    /// While tones are sought, the colours in hand.
    table: [u32; WORDS],
    /// Of each material of the instance, where the first light does not reach.
    unlit: unlit::Table<u8>,
    unlit_by: Unlit,
    fields: Fields,
}

/// How a word's place in the table is found.
#[derive(Clone, Copy, Debug)]
struct Fields {
    under_normal: u32,
    normal: u32,
    /// From the layout's normals to the table's.
    lift: u32,
    drop: u32,
    under_material: u32,
    material: u32,
    /// Materials a normal in the table, as a power of two.
    materials: u32,
    /// From a material's tone to the next one's, where the table has one of them.
    apart: u16,
    /// Words carry colours, and the table steps of light.
    is_coloured: bool,
}

impl SceneTones {
    /// No tones.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            quantiser: Quantiser::empty(),
            ramps: [[0; STEPS]; MAX_SCENE_MATERIALS],
            ramped: 0,
            table: [0; WORDS],
            unlit: [[0; MAX_MATERIALS]; unlit::NORMALS],
            unlit_by: Unlit::ALIKE,
            fields: Fields {
                under_normal: 0,
                normal: 0,
                lift: 0,
                drop: 0,
                under_material: 0,
                material: 0,
                materials: 0,
                apart: 0,
                is_coloured: false,
            },
        }
    }

    /// Finds tones for the materials of these instances under the blob's lights, the first of them
    /// towards `first`, and, if there are to be shadows, for what that one does not reach.
    pub fn prepare(
        &mut self,
        blob: &Blob<'_>,
        instances: impl Iterator<Item = u16> + Clone,
        camera: &Camera,
        first: [Unit; 3],
        shadows: ShadowMode,
    ) {
        if is_plain(blob) {
            return;
        }
        let mut used = 0;
        let instances = instances.filter_map(|index| blob.instance(index));
        for instance in instances.clone() {
            if let Some((first, count)) = blob.materials_of(&instance) {
                let bits = (1u64 << count.min(32)) - 1;
                used |= (bits << (first & 31)) as u32;
            }
        }
        let lights = super::lights(blob, first);
        let one = blob.lights().len() < 2;
        // Highlights where the camera's axis meets them.
        let [_, _, back] = camera
            .rotation
            .map(|row| row.map(|v| Unit::from_bits((v.to_bits() >> 16) as i16)));
        let lighting = Lighting::new(lights, back);
        let materials = || {
            let all = (0..MAX_SCENE_MATERIALS as u16).filter(move |m| used >> m & 1 == 1);
            all.filter_map(|m| Some((m, blob.material(m)?)))
        };
        let is_ramped = |material: &Material| one && material.specular == [0; 3];
        self.ramped = materials()
            .filter(|(_, material)| is_ramped(material))
            .fold(0, |all, (m, _)| all | 1 << m);
        // As many normals of each of the others as there is room for.
        let ramped = self.ramped.count_ones() as usize;
        let others = (used & !self.ramped).count_ones() as usize;
        let has_shadows = shadows != ShadowMode::None;
        let is_dim = has_shadows && !one;
        let kinds = if is_dim { 2 } else { 1 };
        // As many normals of each of the others as there is room for, beside what is seen.
        let room = (WORDS - (STEPS * ramped).min(WORDS)) / (others * kinds).max(1);
        let every = if room >= 640 { 16 } else { 64 };

        let mut count = 0;
        let mut gather = |colour: Rgb| {
            if let Some(slot) = self.table.get_mut(count) {
                *slot = colour;
                count += 1;
            }
        };
        for (m, material) in materials() {
            let surface = lighting.on(&material);
            if self.ramped >> m & 1 == 1 {
                (0..STEPS as u32).for_each(|step| gather(surface.step(step)));
                continue;
            }
            for octant in 0..8 {
                for face in FACES.iter().step_by(every) {
                    gather(pack(surface.colour(signed(face, octant))));
                    if is_dim {
                        gather(pack(surface.behind_first(signed(face, octant))));
                    }
                }
            }
        }
        // A tone is the mean of what was gathered for it: samples draw it to what is there.
        for instance in instances {
            let lighting = lighting.turned_into(&instance);
            for (m, normal) in seen(blob, &instance) {
                let material = blob.material(m).unwrap_or_default();
                let surface = lighting.on(&material);
                gather(pack(surface.colour(normal)));
                if is_dim {
                    gather(pack(surface.behind_first(normal)));
                } else if has_shadows {
                    gather(pack(surface.unlit()));
                }
            }
        }
        let gathered = self.table.get_mut(..count).unwrap_or_default();
        self.quantiser.build(gathered);
        for (m, material) in materials() {
            let surface = lighting.on(&material);
            if let Some(ramp) = self.ramps.get_mut(usize::from(m)) {
                for (step, tone) in (0..).zip(ramp) {
                    *tone = 2 * self.quantiser.tone(surface.step(step)) + 1;
                }
            }
        }
    }

    /// Makes the table of an instance, the blob's first light being towards `first`.
    ///
    /// It has 2,048 normals, or 512 for grids so coarse that neighbouring cells differ more than
    /// neighbouring normals do. A blob of one model has the even tones of its materials, of as many normals as its
    /// words name.
    pub fn shade(&mut self, blob: &Blob<'_>, placed: &Placed<'_>, first: [Unit; 3]) {
        let layout = placed.grid.layout();
        if is_plain(blob) {
            let materials = blob.materials().len();
            let several = names_both(layout);
            self.fields = if several {
                Fields::of_several(layout)
            } else {
                Fields::of_one(layout, 2 * steps(materials) as u16)
            };
            self.unlit_by = Unlit::ALIKE;
            let [unlit, ..] = &mut self.unlit;
            for (unlit, material) in unlit.iter_mut().zip(0..) {
                *unlit = (2 * steps(materials) * material + 1) as u8;
            }
            if several {
                let (normals, _) = self.table.as_chunks_mut();
                even_tones_of_several(normals, materials, first);
                return;
            }
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut self.table);
            if let Some(tones) = bytes.first_chunk_mut() {
                even_tones(tones, materials, first);
            }
            return;
        }
        let lighting = &placed.lighting(blob, first);
        let Some((first, count)) = blob.materials_of(&placed.instance) else {
            return;
        };
        let is_coloured = layout.colour > 0 && placed.instance.material.is_none();
        let several = !is_coloured && (count > 1 || names_both(layout));
        // Words may name others where the instance has one of its own.
        let repeated = if several && count == 1 {
            MAX_MATERIALS
        } else {
            1
        };
        let materials = (first..first.saturating_add(count)).cycle();
        let materials = materials.map(|m| blob.material(m).unwrap_or_default());
        let materials = materials.take(usize::from(count) * repeated);
        let shadows = placed.mode.shadows != ShadowMode::None;
        let tone = |channels| 2 * self.quantiser.tone(pack(channels)) + 1;
        self.unlit_by = Unlit::shade(&mut self.unlit, materials, lighting, shadows, tone);
        let fine = placed.grid.cells(placed.grid.subdivisions()) > 40;
        let every = if fine { 4 } else { 16 };
        if several {
            self.fields = Fields::of_several(layout);
            self.shade_several(blob, (first, count), lighting, every);
        } else {
            self.fields = Fields {
                is_coloured,
                ..Fields::of_one(layout, 0)
            };
            self.shade_one(blob, first, lighting, every);
        }
    }

    /// The table of one material: each normal that is made serves those up to the next.
    fn shade_one(&mut self, blob: &Blob<'_>, m: u16, lighting: &Lighting, every: usize) {
        let Self {
            quantiser,
            ramps,
            ramped,
            table,
            fields,
            ..
        } = self;
        let ramp = ramps.get(usize::from(m)).unwrap_or(&[0; STEPS]);
        let has_ramp = *ramped >> (m & 31) & 1 == 1;
        let material = blob.material(m).unwrap_or_default();
        let surface = lighting.on(&material);
        for (octant, words) in table.chunks_exact_mut(COUNT / 4 / 8).take(8).enumerate() {
            let faces = FACES.iter().step_by(every);
            for (words, face) in words.chunks_exact_mut(every / 4).zip(faces) {
                let normal = signed(face, octant);
                let tone = if fields.is_coloured {
                    lighting.first_step(normal) as u8
                } else if has_ramp {
                    let step = lighting.first_step(normal) as usize;
                    ramp.get(step).copied().unwrap_or(0)
                } else {
                    2 * quantiser.tone(pack(surface.colour(normal))) + 1
                };
                words.fill(u32::from(tone) * 0x0101_0101);
            }
        }
    }

    /// The table of several materials, those of a normal side by side.
    fn shade_several(
        &mut self,
        blob: &Blob<'_>,
        (first, count): (u16, u16),
        lighting: &Lighting,
        every: usize,
    ) {
        let Self {
            quantiser,
            ramps,
            ramped,
            table,
            ..
        } = self;
        let mut materials = [Material::default(); MAX_MATERIALS];
        for (slot, m) in materials.iter_mut().zip(first..) {
            *slot = blob.material(m).unwrap_or_default();
        }
        let surfaces = materials.each_ref().map(|material| lighting.on(material));
        let ramps = ramps.get(usize::from(first)..).unwrap_or_default();
        let per_octant = table.chunks_exact_mut(WORDS / 8);
        for (octant, words) in per_octant.enumerate() {
            // Eight materials are two words, and a normal of 11 bits is four of 13.
            let faces = FACES.iter().step_by(every);
            for (words, face) in words.chunks_exact_mut(every / 2).zip(faces) {
                let normal = signed(face, octant);
                let step = lighting.first_step(normal) as usize;
                let mut tones = [0u8; MAX_MATERIALS];
                let each = tones.iter_mut().zip(first..first.saturating_add(count));
                for (((tone, m), surface), ramp) in each.zip(&surfaces).zip(ramps) {
                    *tone = if *ramped >> (m & 31) & 1 == 1 {
                        ramp.get(step).copied().unwrap_or(0)
                    } else {
                        2 * quantiser.tone(pack(surface.colour(normal))) + 1
                    };
                }
                let [a, b, c, d, e, f, g, h] = tones;
                let pair = [
                    u32::from_le_bytes([a, b, c, d]),
                    u32::from_le_bytes([e, f, g, h]),
                ];
                for words in words.as_chunks_mut().0 {
                    *words = pair;
                }
            }
        }
        if count == 1 {
            // Whatever material a word names.
            let pairs: &mut [[u32; 2]] = table.as_chunks_mut().0;
            for pair in pairs {
                let [first, _] = *pair;
                *pair = [0x0101_0101 * (first & 255); 2];
            }
        }
    }

    /// The colours of the tones.
    #[must_use]
    pub fn palette(&self, blob: &Blob<'_>) -> Palette {
        if is_plain(blob) {
            return Palette::new(blob.materials(), blob.background());
        }
        Palette::of_tones(|tone| self.quantiser.colour(tone), blob.background())
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.table)
    }
}

/// Material and normal of some of an instance's samples.
fn seen(blob: &Blob<'_>, instance: &Instance) -> impl Iterator<Item = (u16, [i32; 3])> {
    let object = blob.object(instance.object);
    let grid = object.and_then(|object| Some((object, blob.grid(object.first_grid)?)));
    let of = instance.material;
    grid.into_iter().flat_map(move |(object, grid)| {
        let layout = grid.layout();
        let apart = grid.leaf_samples().div_ceil(SAMPLES) as usize;
        let leaves = grid.first_leaf()..grid.first_leaf().saturating_add(grid.leaf_samples());
        leaves.step_by(apart).map(move |leaf| {
            let word = grid.attribute(leaf);
            let named = object.first_material + layout.material_of(word) as u16;
            let normal = normal(layout.normal_13(word)).map(|c| i32::from(c.to_bits()));
            (of.unwrap_or(named), normal)
        })
    })
}

/// Whether words name a normal and a material that are looked up together.
fn names_both(layout: Layout) -> bool {
    layout.material > 0 && layout.normal <= 11
}

/// Whether a blob is one model whose samples have no colours of their own.
fn is_plain(blob: &Blob<'_>) -> bool {
    !blob.is_scene() && blob.layouts().all(|layout| layout.colour == 0)
}

impl Fields {
    /// Of a table of one material, of which others are `apart`.
    fn of_one(layout: Layout, apart: u16) -> Self {
        Self {
            under_normal: u32::from(layout.material + layout.offset),
            normal: layout.normal_of(u32::MAX),
            lift: 13u32.saturating_sub(u32::from(layout.normal)),
            drop: 0,
            under_material: u32::from(layout.offset),
            material: layout.material_of(u32::MAX),
            materials: 0,
            apart,
            is_coloured: false,
        }
    }

    /// Of a table of several.
    fn of_several(layout: Layout) -> Self {
        Self {
            drop: 2,
            materials: 3,
            ..Self::of_one(layout, 0)
        }
    }
}

impl Shade for SceneTones {
    #[cfg(rho_thumb)]
    fn tones(&self, both: bool) -> Option<&[u8]> {
        let bytes = self.bytes();
        // Words of both kinds look up normal and material together.
        let fits = !self.fields.is_coloured && both == (self.fields.materials > 0);
        fits.then_some(bytes)
    }

    /// A tone.
    #[inline(always)]
    fn colour(&self, word: u32) -> u16 {
        let f = &self.fields;
        let normal = ((word >> f.under_normal) & f.normal) << f.lift >> f.drop;
        let material = word >> f.under_material & f.material;
        let several = if f.materials > 0 { material } else { 0 };
        let index = (normal << f.materials) + several;
        let tone = self.bytes().get(index as usize).copied().unwrap_or(0);
        if f.is_coloured {
            return self.of_colour((word >> 16) as u16, tone);
        }
        u16::from(tone) + material as u16 * f.apart
    }

    #[inline(always)]
    fn unlit(&self, word: u32) -> u16 {
        let f = &self.fields;
        if f.is_coloured {
            return self.of_colour((word >> 16) as u16, 0);
        }
        // One material, or one of those that words name.
        let names = f.apart > 0 || f.materials > 0;
        let material = if names {
            word >> f.under_material & f.material
        } else {
            0
        };
        let normal = ((word >> f.under_normal) & f.normal) << f.lift;
        let tone = self.unlit_by.of(&self.unlit, normal, material);
        u16::from(tone.unwrap_or(0))
    }

    #[cfg(rho_thumb)]
    #[inline(always)]
    fn unlit_tones(&self) -> Option<(&unlit::Table<u8>, u32)> {
        Some((&self.unlit, self.unlit_by.rows()))
    }

    #[inline(always)]
    fn of_normal(&self, index: u32) -> u16 {
        let tone = self.bytes().get(index as usize % COUNT);
        tone.copied().unwrap_or(0).into()
    }
}

impl SceneTones {
    /// The tone of an RGB565 colour at a step of light.
    fn of_colour(&self, colour: u16, step: u8) -> u16 {
        // 0.1 + 0.9 of it, 256 = 1.
        let lit = 26 + ((u32::from(step) * 936) >> 8);
        let channel = |shift: u32, bits: u32| {
            let levels = (1 << bits) - 1;
            let value = u32::from(colour) >> shift & levels;
            (value * 255 * lit / levels) >> 8
        };
        let rgb = channel(11, 5) << 16 | channel(5, 6) << 8 | channel(0, 5);
        u16::from(2 * self.quantiser.tone(rgb) + 1)
    }
}

const _: () = assert!(TONES == 128 && MAX_SCENE_MATERIALS <= 32);
