//! Tones for scenes: one palette for all that the frame's materials yield under its lights.
//!
//! A palette divided among the materials beforehand would give most of its tones to colours that
//! nothing has: a flat ground has one, and what has no highlight needs none for it. So the colours
//! which the materials in use yield are gathered, and 128 tones found for them
//! ([`crate::quantise`]). Per instance a table then tells the tone of each normal under each of its
//! materials, with as many normals as its grid can show.

use super::Placed;
use crate::blob::format::MAX_SCENE_MATERIALS;
use crate::blob::{Blob, Layout, Material};
use crate::camera::Camera;
use crate::lighting::Lighting;
use crate::normal::{COUNT, FACES};
use crate::q::Unit;
use crate::quantise::{Quantiser, Rgb, TONES, pack};
use crate::shading::{Palette, Shade};

/// Steps of light on a material without highlight, under one light.
const STEPS: usize = 64;

/// Normals an own material has in a table of several: 11 bits.
const NORMALS: usize = COUNT / 4;

/// Words of the table: 8 materials, four normals a word.
const WORDS: usize = 8 * NORMALS / 4;

/// The tones of a scene's frame, about 22 kB.
#[derive(Clone, Debug)]
pub struct SceneTones {
    quantiser: Quantiser,
    /// The tones of each material from dark to lit, where it has one light and no highlight.
    ramps: [[u8; STEPS]; MAX_SCENE_MATERIALS],
    /// Materials in use, a bit each.
    used: u32,
    /// Of them those that have a ramp.
    ramped: u32,
    /// Four normals a word; while tones are sought, the colours in hand.
    table: [u32; WORDS],
    fields: Fields,
}

/// How a word's place in the table is found.
#[derive(Clone, Copy, Debug)]
struct Fields {
    under_normal: u32,
    normal: u32,
    lift: u32,
    drop: u32,
    material: u32,
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
            used: 0,
            ramped: 0,
            table: [0; WORDS],
            fields: Fields {
                under_normal: 0,
                normal: 0,
                lift: 0,
                drop: 0,
                material: 0,
                is_coloured: false,
            },
        }
    }

    /// Finds tones for the materials of these instances under the blob's lights, the first of them
    /// towards `first`.
    pub fn prepare(
        &mut self,
        blob: &Blob<'_>,
        instances: impl Iterator<Item = u16>,
        camera: &Camera,
        first: [Unit; 3],
    ) {
        self.used = 0;
        for instance in instances.filter_map(|index| blob.instance(index)) {
            if let Some((first, count)) = blob.materials_of(&instance) {
                let bits = (1u64 << count.min(32)) - 1;
                self.used |= (bits << (first & 31)) as u32;
            }
        }
        let lights = super::lights(blob, first);
        let one = blob.lights().len() < 2;
        // Highlights where the camera's axis meets them.
        let [_, _, back] = camera
            .rotation
            .map(|row| row.map(|v| Unit::from_bits((v.to_bits() >> 16) as i16)));
        let lighting = Lighting::new(lights, back);
        let used = self.used;
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
        let others = (self.used & !self.ramped).count_ones() as usize;
        let room = (WORDS - (STEPS * ramped).min(WORDS)) / others.max(1);
        let every = if room >= 512 { 16 } else { 64 };

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

    /// Makes the table of an instance.
    ///
    /// It has 2,048 normals, or 512 for grids so coarse that neighbouring cells differ more than
    /// neighbouring normals do.
    pub fn shade(&mut self, blob: &Blob<'_>, placed: &Placed<'_>, lighting: &Lighting) {
        let layout = placed.grid.layout();
        let Some((first, count)) = blob.materials_of(&placed.instance) else {
            return;
        };
        let is_coloured = layout.colour > 0 && placed.instance.material.is_none();
        let count = if is_coloured { 1 } else { usize::from(count) };
        let fine = placed.grid.cells(placed.grid.subdivisions()) > 40;
        let every = if fine { 4 } else { 16 };
        self.fields = Fields::new(layout, count, is_coloured);
        // Words of a material in the table, which has 8,192 normals of one, 2,048 each of several; and
        // of a normal that is made.
        let (per_material, words) = if count == 1 {
            (COUNT / 4, every / 4)
        } else {
            (NORMALS / 4, every / 16)
        };
        let Self {
            quantiser,
            ramps,
            ramped,
            table,
            ..
        } = self;
        for (index, table) in table.chunks_mut(per_material).take(count).enumerate() {
            let m = first + index as u16;
            let ramp = ramps.get(usize::from(m)).unwrap_or(&[0; STEPS]);
            let ramp = (*ramped >> (m & 31) & 1 == 1).then_some(ramp);
            let material = blob.material(m).unwrap_or_default();
            let surface = lighting.on(&material);
            let tone = |face: &[i16; 3], octant: usize| -> u32 {
                let normal = signed(face, octant);
                u32::from(match ramp {
                    _ if is_coloured => lighting.first_step(normal) as u8,
                    Some(ramp) => {
                        let step = lighting.first_step(normal) as usize;
                        ramp.get(step).copied().unwrap_or(0)
                    }
                    None => 2 * quantiser.tone(pack(surface.colour(normal))) + 1,
                })
            };
            for (octant, slots) in table.chunks_exact_mut(per_material / 8).enumerate() {
                if words == 0 {
                    // Four of the normals that are made in a word.
                    for (slot, faces) in slots.iter_mut().zip(FACES.chunks_exact(16)) {
                        let tones = faces.iter().step_by(4).rev();
                        *slot = tones.fold(0, |word, face| word << 8 | tone(face, octant));
                    }
                    continue;
                }
                for (slots, face) in slots.chunks_mut(words).zip(FACES.iter().step_by(every)) {
                    slots.fill(tone(face, octant) * 0x0101_0101);
                }
            }
        }
    }

    /// The colours of the tones.
    #[must_use]
    pub fn palette(&self, background: u16) -> Palette {
        Palette::of_tones(|tone| self.quantiser.colour(tone), background)
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.table)
    }
}

/// A face's normal in one of the eight octants.
#[inline(always)]
fn signed([x, y, z]: &[i16; 3], octant: usize) -> [i32; 3] {
    let sign = |bit: usize, v: i16| {
        let v = i32::from(v);
        if octant & bit == 0 { v } else { -v }
    };
    [sign(4, *x), sign(2, *y), sign(1, *z)]
}

impl Fields {
    fn new(layout: Layout, count: usize, is_coloured: bool) -> Self {
        let bits = u32::from(layout.normal);
        let of = if count == 1 { 13 } else { 11 };
        Self {
            under_normal: u32::from(layout.material + layout.offset),
            normal: (1 << bits) - 1,
            lift: 13u32.saturating_sub(bits),
            drop: 13 - of,
            material: if count == 1 {
                0
            } else {
                layout.material_of(u32::MAX)
            },
            is_coloured,
        }
    }
}

impl Shade for SceneTones {
    #[cfg(rho_thumb)]
    fn tones(&self) -> Option<&[u8; COUNT]> {
        self.bytes().first_chunk()
    }

    /// A tone.
    #[inline(always)]
    fn colour(&self, word: u32) -> u16 {
        let f = &self.fields;
        let normal = ((word >> f.under_normal) & f.normal) << f.lift >> f.drop;
        let index = normal + (word & f.material) * NORMALS as u32;
        let tone = self.bytes().get(index as usize).copied().unwrap_or(0);
        if f.is_coloured {
            return self.of_colour((word >> 16) as u16, tone);
        }
        tone.into()
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
        let lit = 26 + (u32::from(step) * 936 >> 8);
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
