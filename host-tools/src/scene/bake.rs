//! A scene to one blob: every source once, in the grids that its instances want.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering;
use std::time::Instant;

use fixed::traits::ToFixed;
use glam::DVec3;
use rho_grid::blob::format::MAX_SCENE_MATERIALS;
use rho_grid::blob::{self, Layout};
use rho_grid::camera::Camera;
use rho_grid::mode::Preset;
use rho_grid::q::{Length, Rotation, Unit};

use super::fit::{Fitted, bounds, fit, square};
use super::{Scene, Transform};
use crate::bake::{
    BakeOptions, Baked, GridChoice, LayoutChoice, Progress, Report, SampleChoice, Seconds,
};
use crate::blob_file::BlobFile;
use crate::colour::Colour;
use crate::contents::Contents;
use crate::encode::{ObjectEncoding, SceneEncoding, encode_scene};
use crate::failure::{Failure, Outcome};
use crate::geometry::Geometry;
use crate::geometry::triangles::Triangles;
use crate::mesh::Mesh;
use crate::palette::Palette;
use crate::peak::peak_memory;
use crate::picture::rgb565;
use crate::sampling::{Sampling, Separation, Sequence, Tree};
use crate::source::{Model, Shape};
use crate::text::thousands;
use crate::view::{StandardView, View};

/// The grids among which instances choose, in cells an axis: 9 to 243. Each ends in 3, where discs are
/// stamped.
const LADDER: [&[u8]; 9] = [
    &[3, 3],
    &[2, 3, 3],
    &[3, 3, 3],
    &[4, 3, 3],
    &[2, 3, 3, 3],
    &[3, 3, 3, 3],
    &[2, 3, 2, 3, 3],
    &[2, 3, 3, 3, 3],
    &[3, 3, 3, 3, 3],
];

/// The height of the ground in its cube, in sides: not on the faces between cells of any grid of the
/// ladder, but a quarter of a 972nd, their common measure, above.
const GROUND: f64 = 0.25 / 972.0;

/// A source that was read, or the ground.
struct Part {
    model: Option<Model>,
    mesh: Mesh,
    /// As the scene says.
    sequence: Option<Sequence>,
    separation: Separation,
    /// From its cube into the scene's, each instance.
    places: Vec<Transform>,
    /// Some instance shows its own colours, and it has some.
    is_coloured: bool,
}

/// Bakes a scene; `name` is what it is called.
///
/// # Errors
/// Exit 2: a source cannot be read, has no surface in a grid, or the blob does not fit into the flash.
pub fn bake(
    scene: &Scene,
    name: &str,
    options: &BakeOptions,
    progress: &Progress,
) -> Outcome<Baked> {
    let started = Instant::now();
    let (parts, fitted) = read(scene, options)?;
    let mut seconds = Seconds {
        read: started.elapsed().as_secs_f64(),
        ..Seconds::default()
    };
    let camera = scene.camera.camera()?;
    let mut grids: Vec<Vec<Sequence>> = parts
        .iter()
        .map(|part| part.sequences(&camera, options))
        .collect::<Outcome<_>>()?;
    let mut trees = sample(&parts, &grids, options, progress, &mut seconds)?;
    let limit = match options.grid {
        GridChoice::Standard(flash) => flash,
        GridChoice::Fits(_, flash) | GridChoice::Finest(_, flash) => Some(flash),
        GridChoice::Fixed(_) => None,
    };
    let mut warnings: Vec<String> = parts
        .iter()
        .filter_map(|part| part.model.as_ref())
        .flat_map(|model| model.warnings.iter().cloned())
        .collect();
    let mut bakes = 0;
    let bytes = loop {
        bakes += 1;
        let encoding = Instant::now();
        let bytes = encode(scene, name, &camera, &parts, &fitted, &trees, options);
        seconds.encode += encoding.elapsed().as_secs_f64();
        let over = limit.map_or(0, |limit| (bytes.len() as u64).saturating_sub(limit));
        if over == 0 {
            break bytes;
        }
        let (part, grid) = finest(&trees).ok_or_else(|| {
            Failure::input(format!(
                "{name}: the blob has {} bytes and does not fit by {} bytes, with one grid an object",
                thousands(bytes.len() as u64),
                thousands(over)
            ))
            .help(format!(
                "raise --flash to {}, or give objects coarser grids with rho",
                bytes.len().next_multiple_of(1024)
            ))
        })?;
        let sequence = grids[part].remove(grid);
        trees[part].remove(grid);
        warnings.push(format!(
            "{} of {} cells was left out: the blob was {} bytes larger than --flash allows",
            parts[part].name(),
            sequence.cells(),
            thousands(over)
        ));
    };
    let file = BlobFile::from_bytes(&bytes, name);
    let contents = Contents::of(&file.blob()?);
    seconds.total = started.elapsed().as_secs_f64();
    let triangles = parts
        .iter()
        .filter_map(|part| part.model.as_ref()?.triangles());
    Ok(Baked {
        bytes,
        report: Report {
            model: name.to_owned(),
            format: "scene".to_owned(),
            triangles: Some(triangles.sum()).filter(|n| *n > 0),
            contents,
            bakes,
            peak_memory_bytes: peak_memory().unwrap_or(0),
            warnings,
            seconds,
        },
    })
}

/// Reads all sources and places them.
fn read(scene: &Scene, options: &BakeOptions) -> Outcome<(Vec<Part>, Fitted)> {
    let mut parts = Vec::new();
    for (number, source) in scene.sources.iter().enumerate() {
        let model = scene.open(number, &options.load)?;
        let own = scene.instances.iter().filter(|i| i.source == number);
        let shows_own = own.clone().any(|i| i.material.is_none());
        parts.push(Part {
            is_coloured: shows_own && !model.white && !model.mesh().colours.is_empty(),
            mesh: model.mesh().into_owned(),
            sequence: source.sequence.clone(),
            separation: source.separation,
            places: Vec::new(),
            model: Some(model),
        });
    }
    let meshes: Vec<&Mesh> = parts.iter().map(|part| &part.mesh).collect();
    let fitted = fit(scene, &meshes);
    for (instance, place) in scene.instances.iter().zip(&fitted.instances) {
        parts[instance.source].places.push(*place);
    }
    if let (Some(ground), Some(place)) = (&scene.ground, fitted.ground) {
        parts.push(Part {
            model: None,
            mesh: square(GROUND),
            sequence: ground.sequence.clone(),
            separation: Separation::Six,
            places: vec![Transform {
                translation: place.translation - place.scale * GROUND * DVec3::Y,
                ..place
            }],
            is_coloured: false,
        });
    }
    Ok((parts, fitted))
}

impl Part {
    fn name(&self) -> &str {
        self.model
            .as_ref()
            .map_or("the ground", |model| &model.name)
    }

    /// How it is cut: as the options say, or the scene, or as the presets want it for `camera` and the
    /// distances of the standard views.
    fn sequences(&self, camera: &Camera, options: &BakeOptions) -> Outcome<Vec<Sequence>> {
        if let GridChoice::Fixed(given) | GridChoice::Fits(given, _) = &options.grid {
            return Ok(given.clone());
        }
        if let Some(sequence) = &self.sequence {
            return Ok(vec![sequence.clone()]);
        }
        let ladder: Vec<Sequence> = LADDER
            .iter()
            .map(|s| Sequence::new(s))
            .collect::<Outcome<_>>()?;
        let mut cameras = vec![*camera];
        for view in StandardView::ALL {
            cameras.push(View::from(view).camera()?);
        }
        let mut wanted = BTreeSet::new();
        for camera in &cameras {
            for place in &self.places {
                let Some(seen) = place.seen(camera) else {
                    continue;
                };
                for preset in Preset::ALL {
                    // What reaches from near to far is wanted finer than its middle asks for.
                    let finer = if place.scale > 0.5 { 3 } else { 2 };
                    let cells = preset.cells(&seen) * finer / 2;
                    let fine = ladder.iter().position(|s| s.cells() >= cells);
                    wanted.insert(fine.unwrap_or(ladder.len() - 1));
                }
            }
        }
        let chosen: Vec<Sequence> = wanted.into_iter().map(|at| ladder[at].clone()).collect();
        Ok(if chosen.is_empty() {
            ladder[..1].to_vec()
        } else {
            chosen
        })
    }

    fn separation(&self, options: &BakeOptions) -> Separation {
        match options.grid {
            GridChoice::Standard(_) => self.separation,
            _ => options.separation,
        }
    }

    fn layout(&self, options: &BakeOptions) -> Layout {
        let choice = match options.grid {
            GridChoice::Standard(_) if self.is_coloured => LayoutChoice::Both,
            GridChoice::Standard(_) => LayoutChoice::Offset,
            _ => options.layout,
        };
        choice.layout(self.separation(options))
    }
}

/// Samples all parts by their sequences.
fn sample(
    parts: &[Part],
    grids: &[Vec<Sequence>],
    options: &BakeOptions,
    progress: &Progress,
    seconds: &mut Seconds,
) -> Outcome<Vec<Vec<Tree>>> {
    let started = Instant::now();
    let is_standard = matches!(options.grid, GridChoice::Standard(_));
    let samples = if is_standard {
        SampleChoice::Leaves
    } else {
        options.samples
    };
    let mut all = Vec::new();
    for (part, sequences) in parts.iter().zip(grids) {
        let of = |sequence: &Sequence| Sampling {
            sequence: sequence.clone(),
            separation: part.separation(options),
            memory: options.load.memory_limit,
        };
        let grow = |geometry: &dyn Geometry| -> Outcome<Vec<Tree>> {
            let expected = sequences
                .iter()
                .map(|s| of(s).expected_leaves(geometry))
                .sum();
            progress.leaves.store(0, Ordering::Relaxed);
            progress.expected.store(expected, Ordering::Relaxed);
            let mut trees = Vec::new();
            let rims = geometry.rims();
            for sequence in sequences {
                // Finer ones would never be chosen (`rho_grid::mode::choose`).
                let most = sequences.iter().map(Sequence::cells).max().unwrap_or(0);
                let dense = |tree: &Tree| tree.leaves() as u64 >= 2 * u64::from(most).pow(2);
                if is_standard && part.sequence.is_none() && trees.last().is_some_and(dense) {
                    break;
                }
                let mut tree =
                    of(sequence)
                        .sample(geometry, &progress.leaves)
                        .map_err(|failure| Failure {
                            message: format!("{}: {}", part.name(), failure.message),
                            ..failure
                        })?;
                tree.rims.clone_from(&rims);
                if samples == SampleChoice::Leaves {
                    tree.drop_intermediate_samples();
                }
                trees.push(tree);
            }
            Ok(trees)
        };
        let trees = match part.model.as_ref().map(|model| &model.shape) {
            Some(Shape::Procedural(object)) => grow(&**object)?,
            Some(Shape::Mesh(mesh, _)) => grow(&Triangles::new(mesh))?,
            None => grow(&Triangles::new(&part.mesh))?,
        };
        all.push(trees);
    }
    seconds.sample = started.elapsed().as_secs_f64();
    Ok(all)
}

/// The grid with the most leaves among those that are not their object's last.
fn finest(trees: &[Vec<Tree>]) -> Option<(usize, usize)> {
    let several = trees
        .iter()
        .enumerate()
        .filter(|(_, trees)| trees.len() > 1);
    let grids = several.flat_map(|(part, trees)| {
        let leaves = trees.iter().map(Tree::leaves).enumerate();
        leaves.map(move |(grid, leaves)| (leaves, part, grid))
    });
    grids.max().map(|(_, part, grid)| (part, grid))
}

fn encode(
    scene: &Scene,
    name: &str,
    camera: &Camera,
    parts: &[Part],
    fitted: &Fitted,
    trees: &[Vec<Tree>],
    options: &BakeOptions,
) -> Vec<u8> {
    let mut materials: Vec<blob::Material> = scene.materials.iter().map(material).collect();
    let coloured = parts.iter().filter(|part| part.is_coloured).count();
    // One for all that has neither colours nor a material.
    let left = MAX_SCENE_MATERIALS - materials.len() - 1;
    let most = (left / coloured.max(1)).clamp(1, 8);
    let mut white = None;
    let mut objects = Vec::new();
    for (part, trees) in parts.iter().zip(trees) {
        let layout = part.layout(options);
        let has_own = part.is_coloured && layout.material + layout.colour > 0;
        let palette = if part.is_coloured {
            let leaves = trees.iter().filter_map(|tree| tree.levels.last());
            let colours = leaves.flat_map(|level| &level.samples).map(|s| s.colour);
            Palette::of_at_most(if has_own { most } else { 1 }, colours)
        } else {
            Palette::of(std::iter::empty())
        };
        let own = palette.materials();
        let first = match white {
            Some(first) if !part.is_coloured => first,
            _ => {
                let first = materials.len();
                materials.extend(&own);
                if !part.is_coloured {
                    white = Some(first);
                }
                first
            }
        };
        objects.push(ObjectEncoding {
            trees: trees.clone(),
            layout,
            first_material: first as u16,
            materials: own.len() as u16,
            bounds: bounds(&part.mesh),
            palette,
        });
    }
    let mut instances = Vec::new();
    let transforms = scene.instances.iter().zip(&fitted.instances);
    for (instance, place) in transforms {
        instances.push(place.instance(instance.source, instance.material));
    }
    if let (Some(ground), Some(part)) = (&scene.ground, parts.last()) {
        let last = parts.len() - 1;
        instances.extend(
            part.places
                .iter()
                .map(|p| p.instance(last, Some(ground.material))),
        );
    }
    let Colour(background) = scene.background;
    encode_scene(&SceneEncoding {
        objects: &objects,
        materials,
        instances,
        lights: scene.lights.iter().map(light).collect(),
        camera: *camera,
        background: rgb565(background),
        origin: format!(
            "generator=rho {}\nsource={}\n",
            env!("CARGO_PKG_VERSION"),
            name.replace(char::is_control, "?")
        ),
    })
}

impl Transform {
    fn instance(&self, object: usize, material: Option<usize>) -> blob::Instance {
        let rows = self.rotation.transpose();
        let row = |v: DVec3| v.to_array().map(ToFixed::to_fixed::<Rotation>);
        blob::Instance {
            object: object as u16,
            material: material.map(|m| m as u16),
            rotation: [row(rows.x_axis), row(rows.y_axis), row(rows.z_axis)],
            scale: self.scale.to_fixed(),
            translation: self.translation.to_array().map(ToFixed::to_fixed),
        }
    }

    /// A camera of which only focal length and distance are asked: how large the cube is seen.
    fn seen(&self, camera: &Camera) -> Option<Camera> {
        let [.., back] = camera
            .rotation
            .map(|row| DVec3::from_array(row.map(Rotation::to_num)));
        let [.., z] = camera.translation.map(Length::to_num::<f64>);
        let depth = (z + back.dot(self.translation)) / self.scale;
        Some(Camera {
            translation: [Length::ZERO, Length::ZERO, Length::checked_from_num(depth)?],
            ..*camera
        })
    }
}

/// 32768 = 1.
fn q15(Colour(channels): Colour) -> [u16; 3] {
    channels.map(|c| (f64::from(c) / 255.0 * 32768.0).round() as u16)
}

fn material(material: &super::Material) -> blob::Material {
    blob::Material {
        ambient: q15(material.ambient),
        diffuse: q15(material.diffuse),
        specular: q15(material.phong),
        exponent: material.exponent as u16,
    }
}

fn light(light: &super::Light) -> blob::Light {
    blob::Light {
        towards: light.direction.to_array().map(ToFixed::to_fixed::<Unit>),
        colour: q15(light.colour),
        casts_shadows: light.shadows,
    }
}
