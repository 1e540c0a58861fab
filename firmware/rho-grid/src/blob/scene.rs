//! What stands where in a blob: objects, instances, lights, camera.
//!
//! A blob without these sections is one object of all its grids and one instance of it, as it is.

use super::format::{
    CAMERA_BYTES, INSTANCE_BYTES, LIGHT_BYTES, MAX_INSTANCES, MAX_LIGHTS, MAX_MATERIALS,
    OBJECT_BYTES, OWN_MATERIAL, kind,
};
use super::{Blob, BlobError, Grid, u16_at, u32_at};
use crate::camera::Camera;
use crate::q::{Extent, Focal, Length, Place, Rotation, Scale, Unit};

/// The same thing in one or more grids, each for one size on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// Its first grid; the others follow.
    pub first_grid: u16,
    /// How many there are, at least 1.
    pub grids: u16,
    /// The blob's material that a sample's material 0 is; the others follow.
    pub first_material: u16,
    /// How many there are, 1 to 8.
    pub materials: u16,
    /// The box, in the grid's cube, that holds its surface: low and high corner.
    pub bounds: [[Extent; 3]; 2],
}

/// An object at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instance {
    /// Which of the objects.
    pub object: u16,
    /// Which of the blob's materials; its samples' own if none.
    pub material: Option<u16>,
    /// From the object's axes to the scene's: a rotation.
    pub rotation: [[Rotation; 3]; 3],
    /// The side of the object's cube in sides of the scene's.
    pub scale: Scale,
    /// Where the cube's centre stands in the scene.
    pub translation: [Place; 3],
}

impl Instance {
    /// The least scale: what is smaller is no part of the picture.
    pub const SMALLEST: Scale = Scale::from_bits(1 << 18);
    /// The largest scale: of an object that fills the scene's cube and was turned.
    pub const LARGEST: Scale = Scale::from_bits(2 << 30);

    /// The object as it is.
    pub const AS_IS: Self = Self {
        object: 0,
        material: None,
        rotation: [
            [Rotation::ONE, Rotation::ZERO, Rotation::ZERO],
            [Rotation::ZERO, Rotation::ONE, Rotation::ZERO],
            [Rotation::ZERO, Rotation::ZERO, Rotation::ONE],
        ],
        scale: Scale::ONE,
        translation: [Place::ZERO; 3],
    };

    /// A direction of the scene in the axes of the instance's cube.
    #[must_use]
    pub fn into_cube(&self, direction: [Unit; 3]) -> [Unit; 3] {
        let along = |axis: usize| {
            let rows = self.rotation.iter().zip(direction);
            // Q44, three of them.
            let sum: i64 = rows
                .map(|(row, d)| {
                    let entry = row.get(axis).map_or(0, |v| v.to_bits());
                    i64::from(entry) * i64::from(d.to_bits())
                })
                .sum();
            Unit::from_bits(((sum + (1 << 29)) >> 30).clamp(-(1 << 14), 1 << 14) as i16)
        };
        [along(0), along(1), along(2)]
    }
}

/// A light from afar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Light {
    /// Towards it, of length 1, in the scene's axes.
    pub towards: [Unit; 3],
    /// Its share of each channel, 32768 = 1.
    pub colour: [u16; 3],
    /// Whether what hides it casts a shadow; at most one light does.
    pub casts_shadows: bool,
}

impl Light {
    /// White.
    #[must_use]
    pub const fn white(towards: [Unit; 3]) -> Self {
        Self {
            towards,
            colour: [1 << 15; 3],
            casts_shadows: false,
        }
    }
}

impl<'a> Blob<'a> {
    /// How many objects there are, at least 1.
    #[must_use]
    pub fn object_count(&self) -> u16 {
        self.find(kind::OBJECTS, 0)
            .map_or(1, |bytes| (bytes.len() / OBJECT_BYTES) as u16)
    }

    /// Object `index`, or `None` from [`Self::object_count`] on.
    #[must_use]
    pub fn object(&self, index: u16) -> Option<Object> {
        let Some(bytes) = self.find(kind::OBJECTS, 0) else {
            return (index == 0).then(|| Object {
                first_grid: 0,
                grids: self.grids,
                first_material: 0,
                materials: self.materials().len() as u16,
                bounds: [[-HALF; 3], [HALF; 3]],
            });
        };
        let o = bytes.chunks_exact(OBJECT_BYTES).nth(index.into())?;
        let corner = |at: usize| {
            [at, at + 2, at + 4].map(|at| Extent::from_bits(u16_at(o, at).cast_signed()))
        };
        Some(Object {
            first_grid: u16_at(o, 0),
            grids: u16_at(o, 2),
            first_material: u16_at(o, 4),
            materials: u16_at(o, 6),
            bounds: [corner(8), corner(14)],
        })
    }

    /// The objects, in the order of their indices.
    pub fn objects(&self) -> impl Iterator<Item = Object> + use<'a> {
        let blob = *self;
        (0..self.object_count()).filter_map(move |index| blob.object(index))
    }

    /// The grids of an object, in the order of their indices.
    pub fn grids_of(&self, object: &Object) -> impl Iterator<Item = Grid<'a>> + use<'a> {
        let blob = *self;
        (object.first_grid..object.first_grid.saturating_add(object.grids))
            .filter_map(move |index| blob.grid(index))
    }

    /// How many instances there are, 1 to 128.
    #[must_use]
    pub fn instance_count(&self) -> u16 {
        self.find(kind::INSTANCES, 0)
            .map_or(1, |bytes| (bytes.len() / INSTANCE_BYTES) as u16)
    }

    /// Instance `index`, or `None` from [`Self::instance_count`] on.
    #[must_use]
    pub fn instance(&self, index: u16) -> Option<Instance> {
        let Some(bytes) = self.find(kind::INSTANCES, 0) else {
            return (index == 0).then_some(Instance::AS_IS);
        };
        let i = bytes.chunks_exact(INSTANCE_BYTES).nth(index.into())?;
        let material = u16_at(i, 2);
        Some(Instance {
            object: u16_at(i, 0),
            material: (material != OWN_MATERIAL).then_some(material),
            rotation: rotation(i, 4),
            scale: Scale::from_bits(u32_at(i, 40)),
            translation: words(i, 44).map(Place::from_bits),
        })
    }

    /// The material that an instance's samples call 0, and how many follow: its own one, or those of
    /// its object. `None` when there is no such object.
    #[must_use]
    pub fn materials_of(&self, instance: &Instance) -> Option<(u16, u16)> {
        match instance.material {
            Some(material) => Some((material, 1)),
            None => {
                let object = self.object(instance.object)?;
                Some((object.first_material, object.materials))
            }
        }
    }

    /// Whether the blob says what stands where.
    #[must_use]
    pub fn is_scene(&self) -> bool {
        self.find(kind::INSTANCES, 0).is_some()
    }

    /// The lights, at most four, the one that casts shadows first; none when the blob does not say.
    pub fn lights(&self) -> impl ExactSizeIterator<Item = Light> + use<'a> {
        let bytes = self.find(kind::LIGHTS, 0).unwrap_or_default();
        let (lights, _) = bytes.as_chunks::<LIGHT_BYTES>();
        let casts = |l: &[u8; LIGHT_BYTES]| u16_at(l, 6) == 1;
        let caster = lights.iter().position(casts).unwrap_or(0);
        // It comes before those that were before it.
        let at = move |index: usize| match index {
            0 => caster,
            _ if index <= caster => index - 1,
            _ => index,
        };
        (0..lights.len()).map(move |index| {
            let l = lights.get(at(index)).map_or(&[][..], |l| l);
            Light {
                towards: [0, 2, 4].map(|at| Unit::from_bits(u16_at(l, at).cast_signed())),
                colour: [8, 10, 12].map(|at| u16_at(l, at)),
                casts_shadows: u16_at(l, 6) == 1,
            }
        })
    }

    /// The camera, if the blob has one.
    #[must_use]
    pub fn camera(&self) -> Option<Camera> {
        let c = self.find(kind::CAMERA, 0)?;
        Some(Camera {
            rotation: rotation(c, 0),
            translation: words(c, 36).map(Length::from_bits),
            focal: Focal::from_bits(u32_at(c, 48)),
            width: u16_at(c, 52),
            height: u16_at(c, 54),
        })
    }

    /// What is seen where nothing stands, RGB565: black when the blob does not say.
    #[must_use]
    pub fn background(&self) -> u16 {
        self.find(kind::CAMERA, 0).map_or(0, |c| u16_at(c, 56))
    }

    /// How many materials the samples of a grid may name; `None` when no object has it.
    pub(super) fn sample_materials(&self, grid: u16) -> Option<usize> {
        self.find(kind::OBJECTS, 0)?
            .chunks_exact(OBJECT_BYTES)
            .filter(|o| {
                let first = u16_at(o, 0);
                (first..first.saturating_add(u16_at(o, 2))).contains(&grid)
            })
            .map(|o| usize::from(u16_at(o, 6)))
            .min()
    }

    /// Checks objects, instances, lights and camera against the rest.
    pub(super) fn check_scene(&self) -> Result<(), BlobError> {
        let records = |kind, bytes: usize, most: usize| {
            let Some(section) = self.find(kind, 0) else {
                return Ok(());
            };
            let count = section.len() / bytes;
            if count == 0 || count > most || !section.len().is_multiple_of(bytes) {
                return Err(BlobError::Section { kind });
            }
            Ok(())
        };
        records(kind::OBJECTS, OBJECT_BYTES, usize::from(self.grids))?;
        records(kind::INSTANCES, INSTANCE_BYTES, MAX_INSTANCES)?;
        records(kind::LIGHTS, LIGHT_BYTES, MAX_LIGHTS)?;
        records(kind::CAMERA, CAMERA_BYTES, 1)?;
        for (here, there) in [
            (kind::OBJECTS, kind::INSTANCES),
            (kind::INSTANCES, kind::OBJECTS),
        ] {
            if self.find(here, 0).is_some() {
                self.required(there, 0)?;
            }
        }

        let materials = self.materials().len();
        for (index, object) in (0..).zip(self.objects()) {
            let grids = usize::from(object.first_grid) + usize::from(object.grids);
            let last = usize::from(object.first_material) + usize::from(object.materials);
            let [low, high] = object.bounds;
            if object.grids == 0
                || grids > usize::from(self.grids)
                || object.materials == 0
                || usize::from(object.materials) > MAX_MATERIALS
                || last > materials
                || low.iter().zip(&high).any(|(low, high)| low > high)
            {
                return Err(BlobError::Object { object: index });
            }
        }
        for index in 0..self.instance_count() {
            let wrong = BlobError::Instance { instance: index };
            let instance = self.instance(index).ok_or(wrong)?;
            let known = instance.object < self.object_count()
                && instance.material.is_none_or(|m| usize::from(m) < materials);
            if !known
                || !is_rotation(&instance.rotation)
                || !(Instance::SMALLEST..=Instance::LARGEST).contains(&instance.scale)
            {
                return Err(wrong);
            }
        }
        let mut casting = 0;
        for (index, light) in (0..).zip(self.lights()) {
            casting += u16::from(light.casts_shadows);
            // Q28; components computed in f64 and rounded are far within a hundredth.
            let square: i64 = light
                .towards
                .iter()
                .map(|c| i64::from(c.to_bits()) * i64::from(c.to_bits()))
                .sum();
            let unit = (square - (1 << 28)).abs() < 1 << 22;
            if !unit || casting > 1 || light.colour.iter().any(|c| *c > 1 << 15) {
                return Err(BlobError::Light { light: index });
            }
        }
        match self.camera() {
            Some(camera) if camera.check().is_err() => Err(BlobError::Camera),
            _ => Ok(()),
        }
    }
}

/// A half.
const HALF: Extent = Extent::from_bits(1 << 14);

/// Three words.
fn words(bytes: &[u8], at: usize) -> [i32; 3] {
    [at, at + 4, at + 8].map(|at| u32_at(bytes, at).cast_signed())
}

/// Nine words, row by row.
fn rotation(bytes: &[u8], at: usize) -> [[Rotation; 3]; 3] {
    [at, at + 12, at + 24].map(|at| words(bytes, at).map(Rotation::from_bits))
}

/// Whether rows are of length 1 and perpendicular, to a thousandth.
fn is_rotation(rows: &[[Rotation; 3]; 3]) -> bool {
    // Q28, so that sums of products fit.
    let dot = |a: &[Rotation; 3], b: &[Rotation; 3]| -> i64 {
        let parts = a.iter().zip(b);
        parts
            .map(|(a, b)| i64::from(a.to_bits() >> 2) * i64::from(b.to_bits() >> 2))
            .sum()
    };
    let [x, y, z] = rows;
    let unit = |row| (dot(row, row) - (1 << 56)).abs() < 1 << 46;
    let right = |a, b| dot(a, b).abs() < 1 << 46;
    unit(x) && unit(y) && unit(z) && right(x, y) && right(y, z) && right(z, x)
}
