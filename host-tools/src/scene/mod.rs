//! Scenes: objects at their places, materials, lights, a ground, a camera; read from TOML.
//!
//! A scene is plain data that has been checked: every number is in range, every reference
//! resolved, every file was there. Objects of the same source and sequence share one
//! [`Source`]; an [`Instance`] is a transform. Lengths are the scene's own; an object without
//! a transform fills the cube of side 1 about the origin.

pub mod bake;
mod file;
pub mod fit;
mod place;

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use toml::Table;

use crate::colour::Colour;
use crate::failure::{Failure, Outcome};
use crate::geometry::procedural::Procedural;
use crate::model::{LoadOptions, Up};
use crate::sampling::{Separation, Sequence};
use crate::source::{self, Model};
use crate::view::View;

/// Whether a name on the command line is that of a scene file.
#[must_use]
pub fn is_file(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|e| e == "toml")
}

/// A scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Where no object is.
    pub background: Colour,
    /// Where the eye stands, in sides of the scene's bounding cube.
    pub camera: View,
    /// At most [`rho_grid::blob::format::MAX_MATERIALS`].
    pub materials: Vec<Material>,
    /// At least one; at most one casts shadows.
    pub lights: Vec<Light>,
    /// A square to stand on.
    pub ground: Option<Ground>,
    /// What the instances are instances of, all different.
    pub sources: Vec<Source>,
    /// In the file's order.
    pub instances: Vec<Instance>,
}

/// How a surface takes light.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What objects call it.
    pub name: String,
    /// Its colour in no light.
    pub ambient: Colour,
    /// What a light adds that shines straight on it.
    pub diffuse: Colour,
    /// What is added where it mirrors a light.
    pub phong: Colour,
    /// How sharp that is: the power of the cosine, 1 to 255.
    pub exponent: u32,
}

/// A light from afar.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Towards it, of length 1.
    pub direction: DVec3,
    /// Its share of each channel, as parts of 255.
    pub colour: Colour,
    /// Whether what hides it casts a shadow.
    pub shadows: bool,
}

/// A level square about the scene's vertical axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// Where it lies.
    pub height: f64,
    /// Its side.
    pub size: f64,
    /// Which of the materials.
    pub material: usize,
    /// How its cube is cut, if the scene says.
    pub sequence: Option<Sequence>,
}

/// What an object is made of, and how it is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The object.
    pub object: Object,
    /// Which way is up in its file.
    pub up: Up,
    /// How its cube is cut, if the scene says.
    pub sequence: Option<Sequence>,
    /// Which cells are leaves.
    pub separation: Separation,
}

/// What an object is made of.
#[derive(Clone, Debug)]
pub enum Object {
    /// A model file.
    File(PathBuf),
    /// An object that needs no file, and the parameters that were given.
    Procedural(&'static Procedural, Table),
}

impl PartialEq for Object {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::File(a), Self::File(b)) => a == b,
            (Self::Procedural(a, given), Self::Procedural(b, others)) => {
                a.name == b.name && given == others
            }
            _ => false,
        }
    }
}

/// An object at its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Which of the sources.
    pub source: usize,
    /// Which of the materials; its own colours if none.
    pub material: Option<usize>,
    /// What its transform turns and moves.
    pub pivot: Pivot,
    /// From the object's cube into the scene.
    pub transform: Transform,
}

/// The point of an object that comes to lie at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pivot {
    /// The middle of its bounding cube.
    Middle,
    /// The middle of the lower face of its bounding box: it stands.
    Foot,
}

/// Scales, turns, then moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// More than 0.
    pub scale: f64,
    /// Without any scale.
    pub rotation: DMat3,
    /// In the scene's lengths.
    pub translation: DVec3,
}

impl Transform {
    /// Where a point comes to lie.
    #[must_use]
    pub fn place(&self, point: DVec3) -> DVec3 {
        self.rotation * (self.scale * point) + self.translation
    }
}

impl Scene {
    /// Reads and checks a scene file. Its models are looked for here, beside the scene, and in
    /// the folder `models`.
    ///
    /// # Errors
    /// Exit 2, naming file, line and field.
    pub fn read(path: &Path, models: Option<&Path>) -> Outcome<Self> {
        let text = std::fs::read_to_string(path).map_err(|error| {
            Failure::input(format!("cannot read {}: {error}", path.display()))
                .help("name a scene file in TOML")
        })?;
        let folders: Vec<&Path> = path.parent().into_iter().chain(models).collect();
        Self::parse(&text, &path.display().to_string(), &folders)
    }

    /// The same for text in memory; `name` stands in messages.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn parse(text: &str, name: &str, folders: &[&Path]) -> Outcome<Self> {
        file::parse(text, folders).map_err(|bad| bad.failure(name, text))
    }

    /// Reads or makes what a source is made of.
    ///
    /// # Errors
    /// As [`crate::source::open`].
    pub fn open(&self, source: usize, options: &LoadOptions) -> Outcome<Model> {
        let Source { object, up, .. } = &self.sources[source];
        let options = LoadOptions {
            up: *up,
            ..*options
        };
        match object {
            Object::File(path) => source::open_file(path, &options),
            Object::Procedural(object, given) => source::make(object.name, object, given, &options),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(name: &str) -> Scene {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let scan = crate::model::scan("bunny").unwrap_or_else(|failure| panic!("{failure}"));
        Scene::read(&folder.join(name), scan.parent()).unwrap_or_else(|failure| panic!("{failure}"))
    }

    #[test]
    fn the_big_scene_has_the_papers_objects_on_a_ground() {
        let scene = kept("big.toml");
        assert_eq!((scene.instances.len(), scene.sources.len()), (5, 5));
        assert!(scene.ground.is_some());
        assert!(scene.lights.iter().any(|light| light.shadows));
    }

    #[test]
    fn the_forest_is_fifty_instances_of_one_tree_on_a_terrain() {
        let scene = kept("forest.toml");
        assert_eq!(scene.sources.len(), 2);
        let trees = scene.instances.iter().filter(|i| i.source == 1);
        assert_eq!(trees.count(), 50);
    }

    #[test]
    fn the_lights_are_three_on_four_materials() {
        let scene = kept("lights.toml");
        assert_eq!((scene.lights.len(), scene.materials.len()), (3, 4));
        assert!(
            scene
                .materials
                .iter()
                .any(|material| material.exponent > 20)
        );
    }

    #[test]
    fn a_scene_that_is_not_there_is_bad_input() {
        let failure = Scene::read(Path::new("no/such.toml"), None).unwrap_err();
        assert!(failure.message.contains("no/such.toml"), "{failure}");
    }
}
