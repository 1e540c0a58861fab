//! `rho reference`: the ground truth of a model, ray-cast on the PC.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::geometry::procedural;
use crate::reference::scene::SceneCaster;
use crate::reference::{Caster, Shot, Truth};
use crate::scene::{self, Scene};
use crate::source::{self, ModelArgs, Shape};
use crate::view::ViewArgs;

const EXAMPLES: &str = "\
Examples:
  rho reference bunny.ply.gz -o truth.png --view near-turned
  rho reference teapot -o teapot.png
  rho reference host-tools/scenes/big.toml -o big.png --models ../shared/models
  rho reference scan.obj -o truth.png --depth depth.png --up z --size 480x640

The picture is RGBA: coverage is its alpha, and the colour of a pixel that is covered in part
is the mean over the whole pixel with the background black. The depth picture is 16-bit grey
with its range in two texts; it holds the depth at each pixel's centre.";

fn after_help() -> String {
    format!("{EXAMPLES}\n\n{}", procedural::list())
}

/// Draw the ground truth of a model or scene: rays in f64 against its own triangles
#[derive(Args, Clone, Debug)]
#[command(after_help = after_help())]
pub struct Reference {
    /// A mesh or points: .ply, .obj, .stl, .glb or .gltf, or one of them .gz; - for standard
    /// input; or an object that needs no file, with its parameters: teapot, terrain:seed=7;
    /// or a scene: .toml
    pub model: String,
    /// The PNG to write; - for standard output
    #[arg(short, long, value_name = "F.png")]
    pub output: PathBuf,
    /// Also write the depth at each pixel's centre, a 16-bit PNG
    #[arg(long, value_name = "D.png")]
    pub depth: Option<PathBuf>,
    /// One ray through each pixel's centre, as --samples 1
    #[arg(long, conflicts_with = "samples")]
    pub exact: bool,
    /// Rays a pixel along each axis
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub samples: u32,
    /// Light the side that is seen, whichever way its normal points
    #[arg(long)]
    pub two_sided: bool,
    /// Where the model itself lies between a place and the light, the light does not count (of
    /// scenes, the file says which lights cast shadows)
    #[arg(long)]
    pub shadows: bool,
    /// What was measured as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress and no warnings
    #[arg(short, long)]
    pub quiet: bool,
    /// How the model is read.
    #[command(flatten)]
    pub model_args: ModelArgs,
    /// Where the eye stands.
    #[command(flatten)]
    pub view_args: ViewArgs,
}

/// What there is to tell of what was drawn.
struct Original {
    format: String,
    vertices: usize,
    triangles: usize,
    warnings: Vec<String>,
}

impl Reference {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit 2: the model cannot be used, the view is out of range, or a file cannot be written.
    pub fn run(&self) -> Outcome {
        let started = Instant::now();
        let scene = if scene::is_file(&self.model) {
            let path = source::find(&self.model, self.model_args.models.as_deref())?;
            Some(Scene::read(&path, self.model_args.models.as_deref())?)
        } else {
            None
        };
        let view = match &scene {
            Some(scene) => self.view_args.view_over(scene.camera),
            None => self.view_args.view(),
        };
        let shot = Shot {
            view,
            light: self.view_args.light(),
            samples: if self.exact { 1 } else { self.samples },
            two_sided: self.two_sided,
            shadows: self.shadows,
        };
        // Before the model is read: a wrong flag should not cost a second.
        shot.check()?;
        if self.json && self.output == Path::new("-") {
            return Err(
                Failure::input("--json and -o - both write to standard output")
                    .help("name a file for the picture"),
            );
        }
        let (truth, original) = match scene {
            Some(mut scene) => self.scene(&mut scene, &shot)?,
            None => self.model(&shot)?,
        };
        truth.picture.write(&self.output)?;
        if let Some(depth) = &self.depth {
            truth.depth.write(depth)?;
        }
        if !self.quiet {
            for warning in &original.warnings {
                eprintln!("warning: {warning}");
            }
        }
        if self.json {
            println!(
                "{}",
                json!({
                    "model": self.model,
                    "format": original.format,
                    "vertices": original.vertices,
                    "triangles": original.triangles,
                    "warnings": original.warnings,
                    "width": shot.view.width,
                    "height": shot.view.height,
                    "samples": shot.samples,
                    "covered_centres": truth.covered_centres(),
                    "covered": truth.covered(),
                    "seconds": started.elapsed().as_secs_f64(),
                })
            );
        } else if !self.quiet {
            eprintln!(
                "{}: {} pixel centres covered, {:.2} s",
                self.output.display(),
                truth.covered_centres(),
                started.elapsed().as_secs_f64()
            );
        }
        Ok(())
    }

    /// The truth of one model.
    fn model(&self, shot: &Shot) -> Outcome<(Truth, Original)> {
        let model = self.model_args.open(&self.model)?;
        let mesh = model.mesh();
        let bar = self.bar(shot.view.height);
        let truth = Caster::new(&mesh).render(shot, &|| bar.inc(1))?;
        bar.finish_and_clear();
        let (vertices, triangles) = match &model.shape {
            Shape::Mesh(_, source) => (source.vertices, source.triangles),
            Shape::Procedural(_) => (mesh.positions.len(), mesh.triangles.len()),
        };
        let original = Original {
            format: model.format(),
            vertices,
            triangles,
            warnings: model.warnings.clone(),
        };
        Ok((truth, original))
    }

    /// The truth of a scene. `--light` is where its first light stands.
    fn scene(&self, scene: &mut Scene, shot: &Shot) -> Outcome<(Truth, Original)> {
        if self.view_args.light.is_some() {
            scene.lights[0].direction = shot.light;
        }
        let options = self.model_args.options();
        let caster = SceneCaster::new(scene, &options)?;
        let bar = self.bar(shot.view.height);
        let truth = caster.render(shot, &|| bar.inc(1))?;
        bar.finish_and_clear();
        let (vertices, triangles) = caster.size();
        let original = Original {
            format: "scene".to_owned(),
            vertices,
            triangles,
            warnings: caster.warnings().to_vec(),
        };
        Ok((truth, original))
    }

    /// A bar, on a terminal only.
    fn bar(&self, rows: u16) -> ProgressBar {
        if self.quiet || self.json || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("rays {wide_bar} {percent}% {eta}");
        let bar = ProgressBar::new(u64::from(rows));
        bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    }
}
