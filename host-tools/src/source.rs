//! What MODEL means on the command line: a file, standard input, or the name of an object that
//! needs no file.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use clap::Args;
use toml::Table;

use crate::failure::{Failure, Outcome};
use crate::geometry::Geometry;
use crate::geometry::procedural::{self, BadParameter, PROCEDURAL, Procedural};
use crate::mesh::Mesh;
use crate::model::{self, LoadOptions, SourceInfo, Up};

/// The flags that say how a model is found and read.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Model")]
pub struct ModelArgs {
    /// Where a model is looked for that is not in the current folder
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Which way is up in the file
    #[arg(long, value_enum, default_value_t = Up::Y)]
    pub up: Up,
    /// Ignore the colours of the file
    #[arg(long)]
    pub white: bool,
    /// The most memory that may be used; K, M, G are 1024
    #[arg(long, value_name = "SIZE", default_value = "4G", value_parser = bytes)]
    pub memory: u64,
}

impl ModelArgs {
    /// The same for the readers.
    #[must_use]
    pub fn options(&self) -> LoadOptions {
        LoadOptions {
            memory_limit: self.memory,
            up: self.up,
            white: self.white,
        }
    }

    /// Finds and reads a model.
    ///
    /// # Errors
    /// As [`open`].
    pub fn open(&self, model: &str) -> Outcome<Model> {
        open(model, self.models.as_deref(), &self.options())
    }
}

/// A model that was found.
pub struct Model {
    /// The file's name without its folder, `standard input`, or the object's name with its
    /// parameters as they were given.
    pub name: String,
    /// What it is made of.
    pub shape: Shape,
    /// Its colours are ignored.
    pub white: bool,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

/// What a model is made of.
pub enum Shape {
    /// A mesh out of a file.
    Mesh(Mesh, SourceInfo),
    /// An object that answers for itself.
    Procedural(Box<dyn Geometry>),
}

impl Model {
    /// Triangles; of a procedural object, those that stand for it in pictures.
    #[must_use]
    pub fn mesh(&self) -> Cow<'_, Mesh> {
        match &self.shape {
            Shape::Mesh(mesh, _) => Cow::Borrowed(mesh),
            Shape::Procedural(object) => {
                let mut mesh = object.mesh();
                if self.white && !mesh.colours.is_empty() {
                    mesh.to_mut().colours.clear();
                }
                mesh
            }
        }
    }

    /// Whether it has parts of different colours, and they count.
    #[must_use]
    pub fn is_coloured(&self) -> bool {
        let mesh = self.mesh();
        !self.white && mesh.colours.windows(2).any(|pair| pair[0] != pair[1])
    }

    /// Triangles in the file, also those without area; `None` for a point cloud and a procedural
    /// object.
    #[must_use]
    pub fn triangles(&self) -> Option<u64> {
        match &self.shape {
            Shape::Mesh(_, source) => Some(source.triangles as u64).filter(|&n| n > 0),
            Shape::Procedural(_) => None,
        }
    }

    /// `ply`, `obj`, ..., or `procedural`.
    #[must_use]
    pub fn format(&self) -> String {
        match &self.shape {
            Shape::Mesh(_, source) => source.format.to_string().to_lowercase(),
            Shape::Procedural(_) => "procedural".to_owned(),
        }
    }
}

/// Finds and reads a model: one of [`PROCEDURAL`] by its name (`./teapot` is a file), with
/// parameters after a colon; `-` for a file on standard input; else a path, also one within the
/// folder `models`.
///
/// # Errors
/// Exit 2: nothing has that name, a parameter cannot be, or as [`model::load`].
pub fn open(model: &str, models: Option<&Path>, options: &LoadOptions) -> Outcome<Model> {
    let (name, parameters) = match model.split_once(':') {
        Some((name, parameters)) => (name, Some(parameters)),
        None => (model, None),
    };
    if let Some(object) = Procedural::named(name) {
        let given = parameters.map_or_else(|| Ok(Table::new()), procedural::parse);
        let given = given.map_err(|bad| bad_parameter(name, &bad))?;
        return make(model, object, &given, options);
    }
    let path = find(model, models)?;
    if path.extension().is_some_and(|e| e == "toml") {
        return Err(Failure::input(format!(
            "{model} is a scene, and this version takes one model"
        ))
        .help("name one model file: .ply, .obj, .stl, .glb or .gltf, or one of them .gz"));
    }
    open_file(&path, options)
}

/// Reads a model file, or standard input when the path is `-`.
///
/// # Errors
/// As [`model::load`].
pub fn open_file(path: &Path, options: &LoadOptions) -> Outcome<Model> {
    let name = match path.file_name() {
        Some(name) if path != Path::new("-") => name.to_string_lossy().into_owned(),
        _ => "standard input".to_owned(),
    };
    let loaded = model::load(path, options)?;
    Ok(Model {
        name,
        shape: Shape::Mesh(loaded.mesh, loaded.source),
        white: options.white,
        warnings: loaded.warnings,
    })
}

/// Makes an object that needs no file; `name` is what it is called.
///
/// # Errors
/// Exit 2: a parameter cannot be.
pub fn make(
    name: &str,
    object: &Procedural,
    given: &Table,
    options: &LoadOptions,
) -> Outcome<Model> {
    let made = object.make(given);
    let shape = made.map_err(|bad| bad_parameter(object.name, &bad))?;
    let mut warnings = Vec::new();
    if options.up != Up::Y {
        warnings.push(format!("{name} stands upright already: --up is not used"));
    }
    Ok(Model {
        name: name.to_owned(),
        shape: Shape::Procedural(shape),
        white: options.white,
        warnings,
    })
}

fn bad_parameter(name: &str, bad: &BadParameter) -> Failure {
    Failure::input(format!("{name}: {bad}")).help(format!(
        "write parameters as {name}:name=value,name=value; rho bake --help lists them"
    ))
}

/// Where a file is: here, or in the folder `models`.
///
/// # Errors
/// Exit 2: in neither; the message lists the objects that need no file.
pub fn find(model: &str, models: Option<&Path>) -> Outcome<PathBuf> {
    let here = PathBuf::from(model);
    if model == "-" || here.exists() {
        return Ok(here);
    }
    let mut message = format!("there is no file {model}");
    // A path from the root is not looked for elsewhere.
    if let Some(models) = models.filter(|_| here.is_relative()) {
        let there = models.join(&here);
        if there.exists() {
            return Ok(there);
        }
        message = format!("{message}, neither here nor in {}", models.display());
    }
    Err(Failure::input(message).help(format!(
        "name a model file, or an object that needs none: {}",
        PROCEDURAL.each_ref().map(|object| object.name).join(", ")
    )))
}

/// A number of bytes such as `512K`; K, M and G are powers of 1024.
///
/// # Errors
/// A sentence for the command line.
pub fn bytes(text: &str) -> Result<u64, String> {
    let (number, shift) = match text.strip_suffix(['K', 'M', 'G']) {
        Some(number) if text.ends_with('K') => (number, 10),
        Some(number) if text.ends_with('M') => (number, 20),
        Some(number) => (number, 30),
        None => (text, 0),
    };
    number
        .parse::<u64>()
        .ok()
        .and_then(|n| n.checked_mul(1 << shift))
        .ok_or_else(|| "expected a number of bytes, such as 65536, 512K or 4M".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    fn open_plain(model: &str, models: Option<&Path>) -> Outcome<Model> {
        open(model, models, &LoadOptions::default())
    }

    #[test]
    fn sizes_are_powers_of_1024() {
        assert_eq!(bytes("512K"), Ok(524_288));
        assert_eq!(bytes("4G"), Ok(4 << 30));
        assert_eq!(bytes("7"), Ok(7));
        for bad in ["", "K", "-1", "1k", "1.5M", "99999999999G"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_name_that_is_nothing_says_so_and_lists_the_objects() {
        let failure = open_plain("nothing-here.ply", None).err().unwrap();
        assert!(
            failure.message.contains("no file nothing-here.ply"),
            "{failure}"
        );
        assert!(failure.help.unwrap().contains("teapot"));
    }

    #[test]
    fn a_procedural_object_goes_by_its_name() {
        let model = open_plain("teapot", None).unwrap();
        assert_eq!((&*model.name, &*model.format()), ("teapot", "procedural"));
        assert!(!model.mesh().triangles.is_empty());
        assert!(!model.mesh().colours.is_empty());
        assert!(model.warnings.is_empty());
        let options = LoadOptions {
            up: Up::Z,
            white: true,
            ..LoadOptions::default()
        };
        let model = open("teapot", None, &options).unwrap();
        assert_eq!(model.warnings.len(), 1);
        assert!(model.mesh().colours.is_empty());
    }

    #[test]
    fn parameters_follow_the_name_of_an_object() {
        let model = open_plain("terrain:resolution=3,seed=5", None).unwrap();
        assert_eq!(model.name, "terrain:resolution=3,seed=5");
        assert_eq!(model.mesh().triangles.len(), 2 * 9 + 4 * 6 + 2);
        for (bad, part) in [
            ("terrain:", "name=value"),
            ("terrain:seed", "seed is no parameter"),
            ("terrain:resolution=0", "resolution is 0"),
            ("teapot:seed=1", "seed is not known"),
        ] {
            let failure = open_plain(bad, None).err().unwrap();
            assert!(failure.message.contains(part), "{failure}");
        }
    }

    #[test]
    fn a_relative_name_is_also_looked_for_in_the_folder_of_models() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("only-there.obj"), TRIANGLE).unwrap();
        let model = open_plain("only-there.obj", Some(folder.path())).unwrap();
        assert_eq!((&*model.name, &*model.format()), ("only-there.obj", "obj"));
        for missing in ["not-there.obj", "/not-there.obj"] {
            let failure = open_plain(missing, Some(folder.path())).err().unwrap();
            let searched = failure.message.contains(&*folder.path().to_string_lossy());
            assert_eq!(searched, !missing.starts_with('/'), "{failure}");
        }
    }

    #[test]
    fn a_scene_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.toml"), "").unwrap();
        let failure = open_plain("scene.toml", Some(folder.path())).err().unwrap();
        assert!(failure.message.contains("one model"), "{failure}");
    }
}
