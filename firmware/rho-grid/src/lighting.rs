//! Directional lights on a material, as one instance sees them.
//!
//! ```text
//! ambient + sum over lights of colour * (diffuse * max(0, n.l) + phong * max(0, r.e)^exponent)
//! ```
//!
//! clipped at 1, with n the normal, l towards the light, r its mirror image about n and e towards the
//! eye; a light behind the surface counts not at all. The eye's direction is one for all of an
//! instance (that of its centre), so that a sample's colour depends on its normal and material alone
//! (paper, section 5.5).

use crate::blob::format::MAX_LIGHTS;
use crate::blob::{Instance, Light, Material};
use crate::q::Unit;
use crate::quantise::{Rgb, pack};

/// The lights, in the axes of an instance's cube.
#[derive(Clone, Copy, Debug)]
pub struct Lighting {
    lights: [Lit; MAX_LIGHTS],
    count: usize,
    eye: [i32; 3],
}

/// A light, Q14 and Q15.
#[derive(Clone, Copy, Debug, Default)]
struct Lit {
    towards: [i32; 3],
    colour: [u16; 3],
    /// The cosine between light and eye, Q14.
    from_eye: i32,
}

/// A material under each of the lights.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    lighting: &'a Lighting,
    ambient: [u16; 3],
    /// By light, Q15.
    diffuse: [[u32; 3]; MAX_LIGHTS],
    specular: [[u32; 3]; MAX_LIGHTS],
    exponent: u16,
    /// Cosines (Q15) below this one leave nothing of the highlight.
    dull: u32,
}

impl Lighting {
    /// `lights` and the direction `eye` towards the eye, each in the cube's axes; of more than four
    /// lights the first count.
    #[must_use]
    pub fn new(lights: impl Iterator<Item = Light>, eye: [Unit; 3]) -> Self {
        let eye = eye.map(|c| i32::from(c.to_bits()));
        let mut all = [Lit::default(); MAX_LIGHTS];
        let mut count = 0;
        for (slot, light) in all.iter_mut().zip(lights) {
            let towards = light.towards.map(|c| i32::from(c.to_bits()));
            *slot = Lit {
                towards,
                colour: light.colour,
                from_eye: dot(towards, eye) >> 14,
            };
            count += 1;
        }
        Self {
            lights: all,
            count,
            eye,
        }
    }

    /// One white light, and nothing that shines.
    #[must_use]
    pub fn white(towards: [Unit; 3]) -> Self {
        let ahead = [Unit::ZERO, Unit::ZERO, Unit::ONE];
        Self::new(core::iter::once(Light::white(towards)), ahead)
    }

    /// Of lights in a scene's axes: the same in those of an instance's cube.
    #[must_use]
    pub fn turned_into(&self, instance: &Instance) -> Self {
        let turned = |v: [i32; 3]| {
            let v = v.map(|c| Unit::from_bits(c as i16));
            instance.into_cube(v).map(|c| i32::from(c.to_bits()))
        };
        let mut all = *self;
        for light in &mut all.lights {
            light.towards = turned(light.towards);
        }
        all.eye = turned(all.eye);
        all
    }

    /// How many lights there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// How much of the first light falls on the normal (x, y, z), Q14, in 63 steps.
    #[inline(always)]
    #[must_use]
    pub fn first_step(&self, normal: [i32; 3]) -> u32 {
        let [first, ..] = &self.lights;
        let cosine = dot(normal, first.towards).max(0) as u32;
        // Q14 times 63, to nearest.
        (((cosine >> 14) * 63 + (1 << 13)) >> 14).min(63)
    }

    /// A material under these lights.
    #[must_use]
    pub fn on(&self, material: &Material) -> Surface<'_> {
        let mut surface = Surface {
            lighting: self,
            ambient: material.ambient,
            diffuse: [[0; 3]; MAX_LIGHTS],
            specular: [[0; 3]; MAX_LIGHTS],
            exponent: material.exponent,
            dull: u32::MAX,
        };
        let by_light = surface.diffuse.iter_mut().zip(&mut surface.specular);
        for ((diffuse, specular), light) in by_light.zip(&self.lights) {
            *diffuse = product(material.diffuse, light.colour);
            *specular = product(material.specular, light.colour);
        }
        if material.specular != [0; 3] {
            surface.dull = dull(material.exponent);
        }
        surface
    }
}

impl Surface<'_> {
    /// The colour of the normal (x, y, z), Q14: red, green, blue, Q15, 0 to 1.
    #[inline(always)]
    #[must_use]
    pub fn colour(&self, normal: [i32; 3]) -> [u32; 3] {
        self.under::<0>(normal)
    }

    /// The same where the first light does not reach.
    #[must_use]
    pub fn behind_first(&self, normal: [i32; 3]) -> [u32; 3] {
        self.under::<1>(normal)
    }

    /// The colour under the lights from the `FROM`th on.
    #[inline(always)]
    fn under<const FROM: usize>(&self, normal: [i32; 3]) -> [u32; 3] {
        let mut sum = self.ambient.map(u32::from);
        let parts = self.diffuse.iter().zip(&self.specular);
        let lights = self.lighting.lights.iter().zip(parts);
        for (light, (diffuse, specular)) in lights.take(self.lighting.count).skip(FROM) {
            // Q28; of two unit vectors, so it stays within +-2^28 (1 + 2^-12).
            let cosine = dot(normal, light.towards);
            if cosine <= 0 {
                continue;
            }
            let lit = ((cosine >> 13) as u32).min(1 << 15);
            add(&mut sum, diffuse, lit);
            if self.dull < 1 << 15 {
                let ahead = dot(normal, self.lighting.eye) >> 13;
                // r.e = 2 n.l n.e - l.e, Q15.
                let mirrored = ((lit as i32 * ahead) >> 14) - 2 * light.from_eye;
                let mirrored = mirrored.clamp(0, 1 << 15) as u32;
                if mirrored > self.dull {
                    add(&mut sum, specular, power(mirrored, self.exponent));
                }
            }
        }
        sum.map(|c| c.min(1 << 15))
    }

    /// What is left where no light reaches, as [`Self::colour`] has it.
    #[must_use]
    pub fn unlit(&self) -> [u32; 3] {
        self.ambient.map(|c| u32::from(c).min(1 << 15))
    }

    /// The colour at a step of [`Lighting::first_step`], without highlight.
    #[must_use]
    pub fn step(&self, step: u32) -> Rgb {
        let mut sum = self.ambient.map(u32::from);
        let [first, ..] = &self.diffuse;
        add(&mut sum, first, (step << 15) / 63);
        pack(sum.map(|c| c.min(1 << 15)))
    }

    /// RGB565, channels rounded to nearest.
    #[inline(always)]
    #[must_use]
    pub fn rgb565(&self, normal: [i32; 3]) -> u16 {
        rgb565(self.colour(normal))
    }
}

/// Red, green, blue of Q15, 0 to 1, as RGB565, channels rounded to nearest.
#[inline(always)]
#[must_use]
pub(crate) fn rgb565([red, green, blue]: [u32; 3]) -> u16 {
    let channel = |value: u32, levels: u32| (value * levels + (1 << 14)) >> 15;
    (channel(red, 31) << 11 | channel(green, 63) << 5 | channel(blue, 31)) as u16
}

#[inline(always)]
fn dot([ax, ay, az]: [i32; 3], [bx, by, bz]: [i32; 3]) -> i32 {
    ax * bx + ay * by + az * bz
}

/// Channel by channel, Q15.
fn product(a: [u16; 3], b: [u16; 3]) -> [u32; 3] {
    let ([ar, ag, ab], [br, bg, bb]) = (a.map(u32::from), b.map(u32::from));
    [ar * br, ag * bg, ab * bb].map(|c| (c + (1 << 14)) >> 15)
}

/// Adds `colour` times `share`, Q15 both.
#[inline(always)]
fn add(sum: &mut [u32; 3], colour: &[u32; 3], share: u32) {
    for (sum, channel) in sum.iter_mut().zip(colour) {
        *sum += (channel * share + (1 << 14)) >> 15;
    }
}

/// A power of a number from 0 to 1, Q15.
fn power(base: u32, exponent: u16) -> u32 {
    let times = |a: u32, b: u32| (a * b + (1 << 14)) >> 15;
    let (mut result, mut square, mut left) = (1 << 15, base, exponent);
    while left > 0 {
        if left & 1 == 1 {
            result = times(result, square);
        }
        square = times(square, square);
        left >>= 1;
    }
    result
}

/// The largest cosine whose power leaves less than half a step of 8 bits.
fn dull(exponent: u16) -> u32 {
    // Sixteen steps halve the range from nothing to all.
    let (mut low, mut high) = (0, 1 << 15);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if power(middle, exponent) < 64 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use proptest::prelude::*;

    fn unit([x, y, z]: [f64; 3]) -> [f64; 3] {
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }

    fn q14(v: [f64; 3]) -> [Unit; 3] {
        v.map(|c| Unit::from_bits((c * 16384.0).round() as i16))
    }

    proptest! {
        #[test]
        fn a_colour_is_the_formulas(
            n in prop::array::uniform3(-1.0..1.0f64), l in prop::array::uniform3(-1.0..1.0f64),
            m in prop::array::uniform3(-1.0..1.0f64), e in prop::array::uniform3(-1.0..1.0f64),
            exponent in 1..256u16
        ) {
            for v in [n, l, m, e] {
                prop_assume!(v.iter().map(|c| c * c).sum::<f64>() > 0.01);
            }
            let [n, l, m, e] = [n, l, m, e].map(unit);
            let material = Material {
                ambient: [1000, 2000, 3000],
                diffuse: [20000, 10000, 5000],
                specular: [4000, 9000, 0],
                exponent,
            };
            let colours = [[32768, 16384, 8192], [0, 8192, 32768]];
            let lights = [(l, colours[0]), (m, colours[1])].map(|(towards, colour)| Light {
                towards: q14(towards),
                colour,
                casts_shadows: false,
            });
            let lighting = Lighting::new(lights.into_iter(), q14(e));
            let normal = q14(n).map(|c| i32::from(c.to_bits()));
            let found = lighting.on(&material).colour(normal);
            let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
            for k in 0..3 {
                let mut exact = f64::from(material.ambient[k]) / 32768.0;
                for (towards, colour) in [(l, colours[0]), (m, colours[1])] {
                    let cosine = dot(n, towards);
                    if cosine > 0.0 {
                        let mirrored = 2.0 * cosine * dot(n, e) - dot(towards, e);
                        let shine = mirrored.max(0.0).powi(exponent.into());
                        let of = |c: [u16; 3]| f64::from(c[k]) / 32768.0;
                        exact += of(colour) * (of(material.diffuse) * cosine + of(material.specular) * shine);
                    }
                }
                // A sharp highlight moves by its exponent times what the cosine is off.
                let off = (f64::from(found[k]) / 32768.0 - exact.min(1.0)).abs();
                prop_assert!(off < 0.003 + 0.0001 * f64::from(exponent), "{k}: {found:?} {exact}");
            }
        }
    }
}
