//! What things look like where the first light does not reach.
//!
//! Under one light that is a colour a material. Under several the others still shine there, so that it
//! depends on the normal: a table of few normals serves, since what is in the shadow is dim.

use crate::blob::Material;
use crate::blob::format::MAX_MATERIALS;
use crate::lighting::Lighting;
use crate::normal::{COUNT, FACES, signed};

/// Normals that are told apart.
pub(crate) const NORMALS: usize = 128;
/// Faces of an octant for one of them.
const EVERY: usize = COUNT / NORMALS;

/// The colours of each material, of each normal.
pub(crate) type Table<T> = [[T; MAX_MATERIALS]; NORMALS];

/// How a table is read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unlit {
    /// The bits of a normal's row.
    rows: u32,
}

impl Unlit {
    /// All normals have one row.
    pub(crate) const ALIKE: Self = Self { rows: 0 };

    /// Fills `table` for at most [`MAX_MATERIALS`] materials, `colour` telling an entry of Q15 channels;
    /// of each normal if `lighting` has several lights and `by_normal` is asked.
    pub(crate) fn shade<T: Copy>(
        table: &mut [[T; MAX_MATERIALS]],
        materials: impl Iterator<Item = Material>,
        lighting: &Lighting,
        by_normal: bool,
        colour: impl Fn([u32; 3]) -> T,
    ) -> Self {
        let several = by_normal && lighting.count() > 1;
        for (m, material) in materials.take(MAX_MATERIALS).enumerate() {
            let surface = lighting.on(&material);
            let rows = table.iter_mut().filter_map(|row| row.get_mut(m));
            if !several {
                rows.take(1)
                    .for_each(|entry| *entry = colour(surface.unlit()));
                continue;
            }
            let octants = (0..8).flat_map(|octant| {
                let faces = FACES.iter().step_by(EVERY);
                faces.map(move |face| signed(face, octant))
            });
            for (entry, normal) in rows.zip(octants) {
                *entry = colour(surface.behind_first(normal));
            }
        }
        let rows = if several { NORMALS as u32 - 1 } else { 0 };
        Self { rows }
    }

    /// The entry of a normal (13 bits) and a material.
    #[inline(always)]
    pub(crate) fn of<T: Copy>(
        self,
        table: &[[T; MAX_MATERIALS]],
        normal: u32,
        material: u32,
    ) -> Option<T> {
        let row = (normal / EVERY as u32) & self.rows;
        table.get(row as usize)?.get(material as usize).copied()
    }

    /// The bits of a normal's row.
    #[cfg(rho_thumb)]
    pub(crate) fn rows(self) -> u32 {
        self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blob::Light;
    use crate::q::Unit;

    #[test]
    fn of_several_lights_only_the_first_is_kept_away() {
        let towards = |x: f64, y: f64, z: f64| [x, y, z].map(Unit::from_num);
        let white = Light::white(towards(0.0, 1.0, 0.0));
        let side = Light {
            towards: towards(1.0, 0.0, 0.0),
            ..white
        };
        let material = Material {
            ambient: [1 << 12; 3],
            diffuse: [1 << 14; 3],
            ..Material::default()
        };
        let ahead = towards(0.0, 0.0, 1.0);
        let mut table: Table<u32> = [[0; MAX_MATERIALS]; NORMALS];
        let several = Lighting::new([white, side].into_iter(), ahead);
        let materials = || core::iter::once(material);
        let red = |[red, ..]: [u32; 3]| red;
        let unlit = Unlit::shade(&mut table, materials(), &several, true, red);
        // Towards x, and away from it.
        let normal = |x: f64| {
            let n = towards(x, 0.0, 0.0).map(|c| i32::from(c.to_bits()));
            let near = |k: &usize| {
                let [a, ..] = signed(&FACES[k % 1024], k / 1024);
                (a - n[0]).abs()
            };
            (0..COUNT).min_by_key(near).unwrap() as u32
        };
        let at = |normal| unlit.of(&table, normal, 0).unwrap();
        assert!(at(normal(1.0)) > 19_000, "{}", at(normal(1.0)));
        assert_eq!(at(normal(-1.0)), 1 << 12);

        for (lighting, by_normal) in [(several, false), (Lighting::white(ahead), true)] {
            let unlit = Unlit::shade(&mut table, materials(), &lighting, by_normal, red);
            for n in 0..COUNT as u32 {
                assert_eq!(unlit.of(&table, n, 0), Some(1 << 12));
            }
        }
    }
}
