//! Reads model files: PLY, OBJ, STL, glTF and GLB, each also gzipped, into a [`Mesh`]. Points
//! without faces become a surface of discs.
//!
//! Every reader ends in the same place: a soup of vertices and triangles that is checked,
//! given normals, turned upright and scaled into cube units. A file that cannot be used is
//! refused with its name, the place in it and what to do.

mod cloud;
mod detect;
mod glb;
mod input;
mod obj;
mod ply;
mod polygon;
mod soup;
mod stl;

use std::path::{Path, PathBuf};

pub use detect::Format;

use crate::failure::{Failure, Outcome};
use crate::mesh::Mesh;
use input::Input;

/// Which way is up in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Up {
    /// y points up, as in the cube.
    #[default]
    Y,
    /// z points up: the model is turned by -90 degrees about x, so z becomes y.
    Z,
}

/// How a model is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOptions {
    /// The most bytes that the inflated file and the mesh made from it may take together.
    pub memory_limit: u64,
    /// Which way is up in the file.
    pub up: Up,
    /// Ignore the file's colours.
    pub white: bool,
}

impl Default for LoadOptions {
    /// 4 GiB, y up, the file's colours.
    fn default() -> Self {
        Self {
            memory_limit: 4 << 30,
            up: Up::Y,
            white: false,
        }
    }
}

/// What was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The model in cube units.
    pub mesh: Mesh,
    /// What the user should know about the file, one sentence each.
    pub warnings: Vec<String>,
    /// What the file was.
    pub source: SourceInfo,
}

/// What a file was, as found in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SourceInfo {
    /// The format, by content.
    pub format: Format,
    /// Vertices; of STL and glTF those of the mesh made from it.
    pub vertices: usize,
    /// Triangles after polygons were cut, those without area included; 0 of a point cloud.
    pub triangles: usize,
    /// Bytes after inflating.
    pub bytes: u64,
}

/// Reads a model from a file, or from standard input when the path is `-`.
///
/// # Errors
/// Exit 2 with the file's name and the place in it: when it cannot be read, is empty, cut
/// short or of another type, holds a number that is not finite or an index out of range, has
/// no triangle with an area nor points enough for a surface, or needs more memory than allowed.
pub fn load(path: &Path, options: &LoadOptions) -> Outcome<Loaded> {
    let input = Input::open(path, options.memory_limit)?;
    parse(&input, options)
}

/// Reads a model from bytes in memory; `name` stands in messages and its extension counts
/// as that of a file.
///
/// # Errors
/// As [`load`]. Files beside it (a glTF's buffers) are not read.
pub fn read(name: &str, bytes: Vec<u8>, options: &LoadOptions) -> Outcome<Loaded> {
    let input = Input::from_bytes(name, bytes, options.memory_limit)?;
    parse(&input, options)
}

fn parse(input: &Input, options: &LoadOptions) -> Outcome<Loaded> {
    let (format, note) = detect::format(input)?;
    let mut soup = match format {
        Format::Ply => ply::read(input)?,
        Format::Obj => obj::read(input)?,
        Format::Stl => stl::read(input)?,
        Format::Glb | Format::Gltf => glb::read(input)?,
    };
    soup.warnings.splice(0..0, note);
    soup.finish(input, format, options)
}

/// The path of one of the scans that the tests measure, such as `bunny`.
///
/// They lie in the folder that the variable `RHO_MODELS` names, else in `shared/models`
/// beside the workspace, and are not part of the project.
///
/// # Errors
/// Exit 3 when there is no such file; the message names the folder and the variable.
pub fn scan(name: &str) -> Result<PathBuf, Failure> {
    let folder = std::env::var_os("RHO_MODELS").map_or_else(
        || {
            let here = Path::new(env!("CARGO_MANIFEST_DIR"));
            here.join("../../shared/models")
        },
        PathBuf::from,
    );
    let path = folder.join(format!("{name}.ply.gz"));
    if path.is_file() {
        Ok(path)
    } else {
        Err(Failure::missing(format!(
            "no test model {name}.ply.gz in {}",
            folder.display()
        ))
        .help("set RHO_MODELS to the folder with the scans"))
    }
}

#[cfg(test)]
mod tests;
