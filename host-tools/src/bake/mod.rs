//! The whole way from a model to a blob: read, sample, encode.

mod options;
mod shadows;

pub use options::{BakeOptions, GridChoice, LayoutChoice, SampleChoice};

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use rho_grid::blob::Layout;
use rho_grid::blob::facing::BACKS_BYTES;
use rho_grid::blob::format::{MAX_MATERIALS, mask_words};
use serde::Serialize;

use crate::blob_file::BlobFile;
use crate::contents::Contents;
use crate::encode::{Encoding, encode_all};
use crate::failure::{Failure, Outcome};
use crate::flash::{self, Found};
use crate::geometry::Geometry;
use crate::geometry::triangle::Corners;
use crate::geometry::triangles::Triangles;
use crate::mesh::Mesh;
use crate::model::Up;
use crate::palette::Palette;
use crate::peak::peak_memory;
use crate::reference::Caster;
use crate::sampling::{Sampling, Separation, Sequence, Tree};
use crate::scene::{self, Scene};
use crate::source::{self, Model, Shape};
use crate::text::{size, thousands};

/// How far a bake is, for who watches it from another thread.
#[derive(Debug, Default)]
pub struct Progress {
    /// Leaves made of the present grid.
    pub leaves: AtomicU64,
    /// Leaves that it will about have; 0 before sampling.
    pub expected: AtomicU64,
}

/// A baked model.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The blob.
    pub bytes: Vec<u8>,
    /// What there is to tell of it.
    pub report: Report,
}

/// What there is to tell of a bake.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The model's name.
    pub model: String,
    /// `ply`, `obj`, ..., or `procedural`.
    pub format: String,
    /// Triangles in the file; none of a procedural object.
    pub triangles: Option<u64>,
    /// What is in the blob.
    #[serde(flatten)]
    pub contents: Contents,
    /// Where the time went.
    pub seconds: Seconds,
    /// Blobs that were made until the finest was found that fits; 1 without a limit.
    pub bakes: u32,
    /// The most memory used, by the kernel's count, else as foreseen.
    pub peak_memory_bytes: u64,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

/// Where the time went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// Finding and reading the model.
    pub read: f64,
    /// Cutting the cube and sampling the surface, of all grids tried.
    pub sample: f64,
    /// Choosing materials and writing the bytes, of all grids tried.
    pub encode: f64,
    /// Putting them into the file.
    pub write: f64,
    /// From start to end.
    pub total: f64,
}

/// Bakes `model`, as [`source::open`] finds it, or a scene. The bytes depend on the model and the options
/// alone, not on the number of threads.
///
/// # Errors
/// Exit 2 with the model's name: it cannot be read, has no surface in the grid, needs more memory
/// than allowed, or does not fit into the flash.
pub fn bake(model: &str, options: &BakeOptions, progress: &Progress) -> Outcome<Baked> {
    let started = Instant::now();
    if scene::is_file(model) {
        if options.shadows.is_some() {
            return Err(Failure::input(format!(
                "{model} is a scene, and shadows are baked into single models alone"
            ))
            .help("let a [[light]] of it have shadows = true, and run it with --shadows kept"));
        }
        let path = source::find(model, options.models.as_deref())?;
        let scene = Scene::read(&path, options.models.as_deref())?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        return scene::bake::bake(&scene, &name, options, progress);
    }
    let model = source::open(model, options.models.as_deref(), &options.load)?;
    let standard;
    let options = match options.grid {
        GridChoice::Standard(flash) => {
            standard = BakeOptions::standard(&model, flash, options.clone());
            &standard
        }
        _ => options,
    };
    let layout = options.layout.layout(options.separation);
    if options.shadows.is_some() && layout.material == 0 {
        return Err(Failure::input(format!(
            "--layout {} has no room for shadows, which are baked into materials",
            options.layout.name()
        ))
        .help("give --layout both or material, or none"));
    }
    let mut seconds = Seconds {
        read: started.elapsed().as_secs_f64(),
        ..Seconds::default()
    };
    let made = match &model.shape {
        Shape::Mesh(mesh, _) => {
            let held = held_bytes(mesh);
            if held > options.load.memory_limit {
                return Err(Failure::input(format!(
                    "{}: the model alone takes {} of memory, and the limit is {}",
                    model.name,
                    size(held),
                    size(options.load.memory_limit)
                ))
                .help("raise the limit with --memory, or decimate the model"));
            }
            let ready = Instant::now();
            let geometry = Triangles::new(mesh);
            seconds.sample = ready.elapsed().as_secs_f64();
            Baker::new(&model, &geometry, held, options, progress).bake(&mut seconds)
        }
        Shape::Procedural(object) => {
            Baker::new(&model, &**object, 0, options, progress).bake(&mut seconds)
        }
    }?;
    let file = BlobFile::from_bytes(&made.bytes, &*model.name);
    let contents = Contents::of(&file.blob()?);
    seconds.total = started.elapsed().as_secs_f64();
    let triangles = model.triangles();
    let format = model.format();
    let mut warnings = model.warnings;
    warnings.extend(made.warnings);
    Ok(Baked {
        bytes: made.bytes,
        report: Report {
            model: model.name,
            format,
            triangles,
            contents,
            bakes: made.bakes,
            peak_memory_bytes: peak_memory().unwrap_or(made.memory),
            warnings,
            seconds,
        },
    })
}

/// The mesh and what [`Triangles`] adds to it, in bytes.
fn held_bytes(mesh: &Mesh) -> u64 {
    let corners = mesh.triangles.len() * size_of::<Corners>();
    let mesh = size_of_val(&*mesh.positions)
        + size_of_val(&*mesh.normals)
        + size_of_val(&*mesh.colours)
        + size_of_val(&*mesh.triangles);
    (mesh + corners) as u64
}

/// What of a memory limit is left for a tree while the geometry takes `held` bytes.
fn memory_left(limit: u64, held: u64) -> u64 {
    /// The program itself, with its threads and what encoding adds.
    const PROGRAM: u64 = 6 << 20;
    let left = limit.saturating_sub(held);
    // A fourth for what the readers left behind and lists that grow: a tree of 540,000 triangles
    // takes 82 MB where 62 MB are foreseen.
    (left - left / 4).saturating_sub(PROGRAM)
}

/// What baking a grid leaves.
struct Made {
    bytes: Vec<u8>,
    warnings: Vec<String>,
    /// How many blobs were made until this one was chosen.
    bakes: u32,
    /// About the most memory used.
    memory: u64,
}

/// An object and how it is baked.
struct Baker<'a, G: ?Sized> {
    model: &'a Model,
    geometry: &'a G,
    /// Memory that the geometry takes.
    held: u64,
    options: &'a BakeOptions,
    progress: &'a Progress,
}

impl<'a, G: Geometry + ?Sized> Baker<'a, G> {
    fn new(
        model: &'a Model,
        geometry: &'a G,
        held: u64,
        options: &'a BakeOptions,
        progress: &'a Progress,
    ) -> Self {
        Self {
            model,
            geometry,
            held,
            options,
            progress,
        }
    }

    /// The blob of the grid that the options ask for.
    fn bake(&self, seconds: &mut Seconds) -> Outcome<Made> {
        let name = &self.model.name;
        let (candidates, limit) = match &self.options.grid {
            GridChoice::Standard(_) => unreachable!("replaced when the model was read"),
            GridChoice::Fixed(sequences) => return self.all(sequences, seconds),
            GridChoice::Fits(sequences, limit) => return self.fitting(sequences, *limit, seconds),
            GridChoice::Finest(rho, limit) => (rho.map_or_else(flash::mixed, flash::powers), limit),
        };
        match self.finest(&candidates, *limit, seconds)? {
            Found::Fits(_, made) => Ok(made),
            Found::NeedsAtLeast(bytes) => Err(Failure::input(format!(
                "{name} does not fit into {} bytes: the blob needs at least {} bytes ({} cells an \
                 axis)",
                thousands(*limit),
                thousands(bytes),
                candidates[0].cells()
            ))
            .help("raise --flash, or try --thin, which needs fewer samples")),
        }
    }

    /// The blob of as many of these sequences as fit into `limit` bytes together.
    fn fitting(&self, sequences: &[Sequence], limit: u64, seconds: &mut Seconds) -> Outcome<Made> {
        let mut sequences = sequences.to_vec();
        let mut trees = self.sample(&sequences, seconds)?;
        let mut bakes = 0;
        let mut left_out = Vec::new();
        loop {
            bakes += 1;
            let made = self.encode(&sequences, &trees, seconds);
            let bytes = made.bytes.len() as u64;
            if bytes <= limit {
                let mut warnings = made.warnings;
                warnings.extend(left_out);
                return Ok(Made {
                    warnings,
                    bakes,
                    ..made
                });
            }
            let finest = (0..sequences.len()).max_by_key(|&at| sequences[at].cells());
            let sequence = sequences.remove(finest.unwrap_or_default());
            trees.remove(finest.unwrap_or_default());
            if trees.is_empty() {
                let help = self.what_would_fit(&sequence, limit)?;
                return Err(Failure::input(format!(
                    "{}: the blob has {} bytes ({} cells an axis) and does not fit by {} bytes",
                    self.model.name,
                    thousands(bytes),
                    sequence.cells(),
                    thousands(bytes - limit)
                ))
                .help(help));
            }
            left_out.push(format!(
                "{sequence} ({} cells) was left out: with it the blob has {} bytes, {} more than \
                 --flash allows",
                sequence.cells(),
                thousands(bytes),
                thousands(bytes - limit)
            ));
        }
    }

    /// The finest of the candidates that fits into `limit` bytes.
    fn finest(
        &self,
        candidates: &[Sequence],
        limit: u64,
        seconds: &mut Seconds,
    ) -> Outcome<Found<Made>> {
        let foreseen: Vec<u64> = candidates
            .par_iter()
            .map(|sequence| self.foreseen_bytes(sequence))
            .collect();
        let mut bakes = 0;
        let found = flash::finest(&foreseen, limit, |index| {
            bakes += 1;
            let made = self.all(&candidates[index..=index], seconds)?;
            Ok((made.bytes.len() as u64, made))
        })?;
        Ok(match found {
            Found::Fits(index, made) => Found::Fits(index, Made { bakes, ..made }),
            none => none,
        })
    }

    /// What to do when `sequence` does not fit: name the finest coarser one that does.
    fn what_would_fit(&self, sequence: &Sequence, limit: u64) -> Outcome<String> {
        let [first, rest @ ..] = sequence.as_slice() else {
            return Ok(String::new());
        };
        let mut coarser = if rest.iter().all(|rho| rho == first) {
            flash::powers(*first)
        } else {
            flash::mixed()
        };
        coarser.retain(|candidate| candidate.cells() < sequence.cells());
        Ok(
            match self.finest(&coarser, limit, &mut Seconds::default())? {
                Found::Fits(index, made) => format!(
                    "{} ({} cells) would: {}",
                    coarser[index],
                    coarser[index].cells(),
                    size(made.bytes.len() as u64)
                ),
                Found::NeedsAtLeast(0) => "raise --flash".to_owned(),
                Found::NeedsAtLeast(bytes) => format!(
                    "the blob needs at least {} bytes ({} cells an axis)",
                    thousands(bytes),
                    coarser[0].cells()
                ),
            },
        )
    }

    fn sampling(&self, sequence: &Sequence) -> Sampling {
        Sampling {
            sequence: sequence.clone(),
            separation: self.options.separation,
            memory: memory_left(self.options.load.memory_limit, self.held),
        }
    }

    /// About how many bytes the blob will have.
    fn foreseen_bytes(&self, sequence: &Sequence) -> u64 {
        /// Of a blob of nothing: header, directory, page table, origin, a material, a grid.
        const FIXED: f64 = 450.0;
        let leaves = self.sampling(sequence).expected_leaves(self.geometry);
        let word = f64::from(self.layout().word_bytes);
        let mut level = leaves as f64;
        let mut bytes = FIXED + level * word;
        let mut cone = 0.0;
        if self.layout().offset > 0 {
            bytes += BACKS_BYTES as f64;
            cone = 2.0;
        }
        for &rho in sequence.as_slice().iter().rev() {
            level = (level / f64::from(rho).powi(2)).max(1.0);
            let mask = f64::from(4 * mask_words(rho, 4) as u32) / 4.0;
            let sample = match self.options.samples {
                SampleChoice::All => word,
                SampleChoice::Leaves => 0.0,
            };
            bytes += level * (sample + mask + cone + 2.0);
        }
        bytes as u64
    }

    fn layout(&self) -> Layout {
        self.options.layout.layout(self.options.separation)
    }

    /// Samples the grids and encodes them.
    fn all(&self, sequences: &[Sequence], seconds: &mut Seconds) -> Outcome<Made> {
        let trees = self.sample(sequences, seconds)?;
        Ok(self.encode(sequences, &trees, seconds))
    }

    /// Samples the grids, side by side.
    fn sample(&self, sequences: &[Sequence], seconds: &mut Seconds) -> Outcome<Vec<Tree>> {
        let started = Instant::now();
        let mut samplings: Vec<Sampling> = sequences.iter().map(|s| self.sampling(s)).collect();
        let needs: Vec<u64> = samplings
            .iter()
            .map(|sampling| sampling.expected_memory(self.geometry))
            .collect();
        let all: u64 = needs.iter().sum();
        // Each has the part of the memory that it is foreseen to need.
        for (sampling, need) in samplings.iter_mut().zip(needs) {
            sampling.memory = (sampling.memory as f64 * need as f64 / all.max(1) as f64) as u64;
        }
        self.progress.leaves.store(0, Ordering::Relaxed);
        let expected = samplings
            .iter()
            .map(|sampling| sampling.expected_leaves(self.geometry))
            .sum();
        self.progress.expected.store(expected, Ordering::Relaxed);
        let rims = self.geometry.rims();
        let trees = samplings
            .par_iter()
            .map(|sampling| {
                let mut tree = sampling
                    .sample(self.geometry, &self.progress.leaves)
                    .map_err(|failure| Failure {
                        message: format!("{}: {}", self.model.name, failure.message),
                        ..failure
                    })?;
                tree.rims.clone_from(&rims);
                if self.options.samples == SampleChoice::Leaves {
                    tree.drop_intermediate_samples();
                }
                Ok(tree)
            })
            .collect::<Outcome<Vec<Tree>>>()?;
        let trees = self.shaded(trees);
        seconds.sample += started.elapsed().as_secs_f64();
        Ok(trees)
    }

    /// With the shadows that are to be baked.
    fn shaded(&self, mut trees: Vec<Tree>) -> Vec<Tree> {
        if let Some(towards) = self.options.shadows {
            let mesh = self.model.mesh();
            let caster = Caster::new(&mesh);
            for tree in &mut trees {
                shadows::shade(tree, &caster, towards.normalize());
            }
        }
        trees
    }

    /// Writes a grid a tree.
    fn encode(&self, sequences: &[Sequence], trees: &[Tree], seconds: &mut Seconds) -> Made {
        let started = Instant::now();
        let shaded = self.options.shadows.is_some();
        let most = if shaded {
            MAX_MATERIALS / 2
        } else {
            MAX_MATERIALS
        };
        let (palette, warning) = if self.model.white {
            (Palette::of(std::iter::empty()), None)
        } else {
            palette(trees, self.layout(), most)
        };
        let palette = if shaded { palette.shaded() } else { palette };
        let encoding = Encoding {
            layout: self.layout(),
            palette,
            origin: self.origin(sequences),
        };
        let bytes = encode_all(trees, &encoding);
        seconds.encode += started.elapsed().as_secs_f64();
        let memory = sequences
            .iter()
            .map(|sequence| self.sampling(sequence).expected_memory(self.geometry));
        Made {
            bytes,
            warnings: warning.into_iter().collect(),
            bakes: 1,
            memory: self.held + memory.sum::<u64>(),
        }
    }

    /// Where the blob comes from. The options are written as flags that bake it again.
    fn origin(&self, sequences: &[Sequence]) -> String {
        let BakeOptions {
            separation,
            layout,
            samples,
            shadows,
            load,
            ..
        } = self.options;
        let thin = match separation {
            Separation::TwentySix => "",
            Separation::Six => "--thin ",
        };
        let samples = match samples {
            SampleChoice::All => "",
            SampleChoice::Leaves => " --samples leaves",
        };
        let up = match load.up {
            Up::Y => "y",
            Up::Z => "z",
        };
        let shadows = shadows.map_or_else(String::new, |light| {
            format!(" --bake-shadows {},{},{}", light.x, light.y, light.z)
        });
        let white = if load.white { " --white" } else { "" };
        let rho: String = sequences
            .iter()
            .map(|sequence| format!("--rho {sequence} "))
            .collect();
        let mut origin = format!(
            "generator=rho {}\noptions={rho}{thin}--layout {}{samples} --up {up}{white}{shadows}\n\
             source={}\n",
            env!("CARGO_PKG_VERSION"),
            layout.name(),
            // A line's end in a name would begin another line.
            self.model.name.replace(char::is_control, "?"),
        );
        if let Some(triangles) = self.model.triangles() {
            origin += &format!("triangles={triangles}\n");
        }
        origin
    }
}

/// The colours of the leaves as so many materials at most, and what is lost by that.
fn palette(trees: &[Tree], layout: Layout, most: usize) -> (Palette, Option<String>) {
    let leaves = || {
        let leaves = trees.iter().filter_map(|tree| tree.levels.last());
        leaves.flat_map(|level| &level.samples)
    };
    let palette = Palette::of_at_most(most, leaves().map(|sample| sample.colour));
    if layout.colour > 0 {
        // Samples have their own; tones are sought among these.
        return (palette, None);
    }
    if layout.material == 0 && palette.colours().len() > 1 {
        let mut sum = [0_u64; 3];
        for sample in leaves() {
            for (sum, channel) in sum.iter_mut().zip(sample.colour) {
                *sum += u64::from(channel);
            }
        }
        let n = (leaves().count() as u64).max(1);
        let mean = sum.map(|sum| ((sum + n / 2) / n) as u8);
        let warning = "this layout has no room for colours: all became their mean";
        return (Palette::of(std::iter::once(mean)), Some(warning.to_owned()));
    }
    let kept = leaves().all(|sample| palette.colours().contains(&sample.colour));
    let warning = (!kept).then(|| {
        format!(
            "the model's colours were gathered into {} materials",
            palette.colours().len()
        )
    });
    (palette, warning)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::LoadOptions;
    use crate::sampling::{TreeLevel, TreeSample};

    const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0.3\nf 1 2 3\n";

    fn bake_triangle(name: &str, options: &BakeOptions) -> Outcome<Baked> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), TRIANGLE).unwrap();
        let options = BakeOptions {
            models: Some(folder.path().to_owned()),
            ..options.clone()
        };
        bake(name, &options, &Progress::default())
    }

    #[test]
    fn the_origin_tells_how_to_bake_it_again_and_names_no_folder() {
        let options = BakeOptions {
            grid: GridChoice::Finest(None, 2000),
            separation: Separation::Six,
            layout: LayoutChoice::Offset,
            ..BakeOptions::default()
        };
        let baked = bake_triangle("a\nb.obj", &options).unwrap();
        let origin = &baked.report.contents.origin;
        let sequence = baked.report.contents.grids[0].sequence();
        assert_eq!(
            origin["options"],
            format!("--rho {sequence} --thin --layout offset --up y")
        );
        assert_eq!(
            (&*origin["source"], &*origin["triangles"]),
            ("a?b.obj", "1")
        );
        assert_eq!(origin.len(), 4);
    }

    #[test]
    fn sizes_are_foreseen_to_a_fourth_and_fine_ones_to_a_tenth() {
        let model = source::open("teapot", None, &LoadOptions::default()).unwrap();
        let Shape::Procedural(object) = &model.shape else {
            panic!("no file");
        };
        let (options, progress) = (BakeOptions::default(), Progress::default());
        let baker = Baker::new(&model, &**object, 0, &options, &progress);
        for (sequence, within) in [
            (&[4, 3, 3][..], 0.25),
            (&[5, 5, 3], 0.1),
            (&[2; 6], 0.25),
            (&[2, 3, 3, 3, 3], 0.1),
        ] {
            let sequence = Sequence::new(sequence).unwrap();
            let truth = baker
                .all(std::slice::from_ref(&sequence), &mut Seconds::default())
                .unwrap();
            let ratio = baker.foreseen_bytes(&sequence) as f64 / truth.bytes.len() as f64;
            assert!((ratio - 1.0).abs() < within, "{sequence} {ratio}");
        }
    }

    #[test]
    fn colours_are_kept_gathered_or_averaged() {
        let coloured = |n: usize| {
            let mut tree = Tree {
                sequence: vec![2],
                separation: Separation::TwentySix,
                rims: None,
                levels: vec![TreeLevel::default(); 2],
            };
            tree.levels[1].samples = (0..n)
                .map(|i| TreeSample {
                    normal: glam::Vec3::Y,
                    offset: 0.0,
                    colour: [20 * i as u8, 0, 0],
                    mean: [20 * i as u8, 0, 0],
                    two_sided: false,
                    shaded: false,
                })
                .collect();
            tree
        };
        let (palette_8, warning) = palette(&[coloured(8)], Layout::MATERIAL, 8);
        assert_eq!((palette_8.colours().len(), warning), (8, None));
        let (palette_9, warning) = palette(&[coloured(9)], Layout::MATERIAL, 8);
        assert_eq!(palette_9.colours().len(), 8);
        assert!(warning.unwrap().contains("8 materials"));
        let (mean, warning) = palette(&[coloured(9)], Layout::OFFSET, 8);
        assert_eq!(mean.colours(), [[80, 0, 0]]);
        assert!(warning.is_some());
    }
}
