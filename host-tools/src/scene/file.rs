//! A scene as its file writes it, and the checks that make a [`Scene`] of it.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use glam::{DMat3, DVec3};
use rho_grid::blob::format::{MAX_INSTANCES, MAX_LIGHTS, MAX_MATERIALS};
use serde::Deserialize;
use toml::{Spanned, Table, Value};

use super::place::Bad;
use super::{Ground, Instance, Light, Material, Object, Pivot, Scene, Source, Transform};
use crate::colour::Colour;
use crate::geometry::procedural::{PROCEDURAL, Procedural};
use crate::model::Up;
use crate::sampling::{Separation, Sequence};
use crate::view::{STANDARD_LIGHT, StandardView, View};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default = "black")]
    background: Colour,
    camera: Option<Spanned<Camera>>,
    #[serde(default)]
    material: Vec<Spanned<FileMaterial>>,
    #[serde(default)]
    light: Vec<FileLight>,
    ground: Option<FileGround>,
    #[serde(default)]
    object: Vec<Spanned<FileObject>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Camera {
    yaw: Option<f64>,
    pitch: Option<f64>,
    distance: Option<f64>,
    zoom: Option<f64>,
    fov: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileMaterial {
    name: Spanned<String>,
    ambient: Option<Colour>,
    diffuse: Colour,
    #[serde(default = "black")]
    phong: Colour,
    exponent: Option<Spanned<u32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileLight {
    direction: Spanned<[f64; 3]>,
    colour: Option<Colour>,
    shadows: Option<Spanned<bool>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileGround {
    #[serde(default)]
    height: f64,
    size: Spanned<f64>,
    material: Spanned<String>,
    rho: Option<Spanned<Vec<u8>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileObject {
    source: Spanned<String>,
    #[serde(default)]
    parameters: BTreeMap<Spanned<String>, Spanned<Value>>,
    up: Option<Spanned<String>>,
    rho: Option<Spanned<Vec<u8>>>,
    #[serde(default)]
    thin: bool,
    material: Option<Spanned<String>>,
    #[serde(default)]
    stand: bool,
    translation: Option<Spanned<[f64; 3]>>,
    rotation: Option<Spanned<[f64; 3]>>,
    scale: Option<Spanned<f64>>,
    copies: Option<Vec<Copy>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Copy {
    translation: Option<Spanned<[f64; 3]>>,
    rotation: Option<Spanned<[f64; 3]>>,
    scale: Option<Spanned<f64>>,
}

fn black() -> Colour {
    Colour([0; 3])
}

/// Reads and checks; files are looked for here and in `folders`.
pub(super) fn parse(text: &str, folders: &[&Path]) -> Result<Scene, Bad> {
    let file: File = toml::from_str(text)?;
    let camera = camera(file.camera)?;
    let materials = materials(&file.material)?;
    let lights = lights(&file.light)?;
    let ground = file.ground.map(|ground| self::ground(&ground, &materials));
    let mut scene = Scene {
        background: file.background,
        camera,
        lights,
        ground: ground.transpose()?,
        materials,
        sources: Vec::new(),
        instances: Vec::new(),
    };
    let most = MAX_INSTANCES - usize::from(scene.ground.is_some());
    for object in &file.object {
        add(&mut scene, object.get_ref(), folders)?;
        if scene.instances.len() > most {
            let what = format!("there are more than {MAX_INSTANCES} objects, copies and ground");
            return Err(Bad::new(object.span(), what).help("leave some of them out"));
        }
    }
    if scene.instances.is_empty() && scene.ground.is_none() {
        return Err(Bad::new(0..0, "the scene has no object")
            .help("add [[object]] with a source, such as \"teapot\""));
    }
    Ok(scene)
}

fn camera(camera: Option<Spanned<Camera>>) -> Result<View, Bad> {
    let mut view = View::from(StandardView::Near);
    let Some(camera) = camera else {
        return Ok(view);
    };
    let at = camera.span();
    let camera = camera.into_inner();
    view.yaw = camera.yaw.unwrap_or(view.yaw);
    view.pitch = camera.pitch.unwrap_or(view.pitch);
    view.distance = camera.distance.unwrap_or(view.distance);
    view.zoom = camera.zoom.unwrap_or(view.zoom);
    view.fov = camera.fov.unwrap_or(view.fov);
    match view.camera() {
        Ok(_) => Ok(view),
        Err(failure) => {
            let bad = Bad::new(at, failure.message);
            Err(match failure.help {
                Some(help) => bad.help(help),
                None => bad,
            })
        }
    }
}

fn materials(file: &[Spanned<FileMaterial>]) -> Result<Vec<Material>, Bad> {
    let mut materials: Vec<Material> = Vec::new();
    for material in file {
        let at = material.span();
        let material = material.get_ref();
        if materials.len() == MAX_MATERIALS {
            return Err(
                Bad::new(at, format!("there are more than {MAX_MATERIALS} materials"))
                    .help("let objects share materials"),
            );
        }
        let name = material.name.get_ref();
        if materials.iter().any(|other| other.name == *name) {
            let what = format!("there is a material {name:?} already");
            return Err(Bad::new(material.name.span(), what));
        }
        let exponent = material.exponent.as_ref();
        if let Some(e) = exponent.filter(|e| !(1..=255).contains(e.get_ref())) {
            let what = format!("is {}, and may be 1 to 255", e.get_ref());
            return Err(Bad::new(e.span(), what));
        }
        materials.push(Material {
            name: name.clone(),
            // As in the standard scene: 0.1 and 0.9.
            ambient: material
                .ambient
                .unwrap_or(material.diffuse.times(1.0 / 9.0)),
            diffuse: material.diffuse,
            phong: material.phong,
            exponent: exponent.map_or(1, |e| *e.get_ref()),
        });
    }
    Ok(materials)
}

fn lights(file: &[FileLight]) -> Result<Vec<Light>, Bad> {
    let mut lights: Vec<Light> = Vec::new();
    for light in file {
        let direction = vector(&light.direction)?;
        if direction == DVec3::ZERO {
            return Err(Bad::new(light.direction.span(), "has no length")
                .help("give the direction towards the light, such as [0.4, 0.6, 0.7]"));
        }
        let shadows = light.shadows.as_ref();
        let casts = shadows.is_some_and(|casts| *casts.get_ref());
        if let Some(again) = shadows.filter(|_| casts && lights.iter().any(|l| l.shadows)) {
            return Err(
                Bad::new(again.span(), "another light casts shadows already")
                    .help("let one light cast shadows"),
            );
        }
        if lights.len() == MAX_LIGHTS {
            let what = format!("there are more than {MAX_LIGHTS} lights");
            return Err(Bad::new(light.direction.span(), what).help("leave out the faintest"));
        }
        lights.push(Light {
            direction: direction.normalize(),
            colour: light.colour.unwrap_or(Colour([255; 3])),
            shadows: casts,
        });
    }
    if lights.is_empty() {
        lights.push(Light {
            direction: STANDARD_LIGHT.normalize(),
            colour: Colour([255; 3]),
            shadows: false,
        });
    }
    Ok(lights)
}

fn ground(file: &FileGround, materials: &[Material]) -> Result<Ground, Bad> {
    Ok(Ground {
        height: file.height,
        size: positive(&file.size)?,
        material: material(&file.material, materials)?,
        sequence: sequence(file.rho.as_ref())?,
    })
}

/// Adds an object, its source if that is new.
fn add(scene: &mut Scene, file: &FileObject, folders: &[&Path]) -> Result<(), Bad> {
    let source = Source {
        object: object(file, folders)?,
        up: up(file.up.as_ref())?,
        sequence: sequence(file.rho.as_ref())?,
        // Unless it says otherwise, it is cut as the presets want it.
        separation: if file.thin || file.rho.is_none() {
            Separation::Six
        } else {
            Separation::TwentySix
        },
    };
    let known = scene.sources.iter().position(|other| *other == source);
    let number = known.unwrap_or_else(|| {
        scene.sources.push(source);
        scene.sources.len() - 1
    });
    let own = file.material.as_ref();
    let own = own
        .map(|name| material(name, &scene.materials))
        .transpose()?;
    let whole = transform(
        file.translation.as_ref(),
        file.rotation.as_ref(),
        file.scale.as_ref(),
    )?;
    let mut put = |transform| {
        scene.instances.push(Instance {
            source: number,
            material: own,
            pivot: if file.stand {
                Pivot::Foot
            } else {
                Pivot::Middle
            },
            transform,
        });
    };
    let Some(copies) = &file.copies else {
        put(whole);
        return Ok(());
    };
    for copy in copies {
        let part = transform(
            copy.translation.as_ref(),
            copy.rotation.as_ref(),
            copy.scale.as_ref(),
        )?;
        put(Transform {
            scale: whole.scale * part.scale,
            rotation: whole.rotation * part.rotation,
            translation: whole.place(part.translation),
        });
    }
    Ok(())
}

fn object(file: &FileObject, folders: &[&Path]) -> Result<Object, Bad> {
    let name = file.source.get_ref();
    if let Some(object) = Procedural::named(name) {
        let given: Table = file
            .parameters
            .iter()
            .map(|(name, value)| (name.get_ref().clone(), value.get_ref().clone()))
            .collect();
        return match object.check(&given) {
            Ok(()) => Ok(Object::Procedural(object, given)),
            Err(bad) => {
                // A part of a parameter is named after it.
                let whole = |name: &str| bad.name.split(' ').next() == Some(name);
                let at = file.parameters.keys().find(|name| whole(name.get_ref()));
                Err(Bad::new(
                    at.map_or_else(|| file.source.span(), Spanned::span),
                    bad.to_string(),
                ))
            }
        };
    }
    let here = Path::new(name);
    let places = folders.iter().map(|folder| folder.join(name));
    let found = std::iter::once(here.to_owned())
        .chain(places)
        .find(|p| p.is_file());
    let found = found.ok_or_else(|| {
        let what = if name.contains('.') {
            format!("there is no file {name}")
        } else {
            format!("there is no object {name:?}")
        };
        let objects = PROCEDURAL.each_ref().map(|object| object.name).join(", ");
        Bad::new(file.source.span(), what).help(format!(
            "name a file here, beside the scene or in --models DIR, or one of {objects}"
        ))
    })?;
    match file.parameters.first_key_value() {
        Some((parameter, _)) => Err(Bad::new(parameter.span(), "a file has no parameters")),
        None => Ok(Object::File(found)),
    }
}

fn up(file: Option<&Spanned<String>>) -> Result<Up, Bad> {
    match file.map(|up| (up.get_ref().as_str(), up.span())) {
        None | Some(("y", _)) => Ok(Up::Y),
        Some(("z", _)) => Ok(Up::Z),
        Some((_, at)) => Err(Bad::new(at, "is neither \"y\" nor \"z\"")),
    }
}

fn sequence(file: Option<&Spanned<Vec<u8>>>) -> Result<Option<Sequence>, Bad> {
    let sequence = file.map(|rho| {
        Sequence::new(rho.get_ref()).map_err(|failure| Bad::new(rho.span(), failure.message))
    });
    sequence.transpose()
}

fn material(name: &Spanned<String>, materials: &[Material]) -> Result<usize, Bad> {
    let found = materials.iter().position(|m| m.name == *name.get_ref());
    found.ok_or_else(|| {
        let known: Vec<&str> = materials.iter().map(|m| &*m.name).collect();
        Bad::new(
            name.span(),
            format!("there is no material {:?}", name.get_ref()),
        )
        .help(if known.is_empty() {
            "add it with [[material]]".to_owned()
        } else {
            format!("there are {}", known.join(", "))
        })
    })
}

fn transform(
    translation: Option<&Spanned<[f64; 3]>>,
    rotation: Option<&Spanned<[f64; 3]>>,
    scale: Option<&Spanned<f64>>,
) -> Result<Transform, Bad> {
    let vector_or_zero = |v: Option<&Spanned<[f64; 3]>>| v.map_or(Ok(DVec3::ZERO), vector);
    let turns = vector_or_zero(rotation)?.map(f64::to_radians);
    Ok(Transform {
        scale: scale.map_or(Ok(1.0), positive)?,
        // About x, then y, then z.
        rotation: DMat3::from_rotation_z(turns.z)
            * DMat3::from_rotation_y(turns.y)
            * DMat3::from_rotation_x(turns.x),
        translation: vector_or_zero(translation)?,
    })
}

fn vector(file: &Spanned<[f64; 3]>) -> Result<DVec3, Bad> {
    /// Beyond these, sums lose what the scene is made of.
    const LENGTHS: f64 = 1e9;
    let vector = DVec3::from_array(*file.get_ref());
    if vector.abs().cmple(DVec3::splat(LENGTHS)).all() {
        return Ok(vector);
    }
    Err(Bad::new(file.span(), "must be three numbers up to 1e9"))
}

fn positive(file: &Spanned<f64>) -> Result<f64, Bad> {
    const SCALES: std::ops::RangeInclusive<f64> = 1e-9..=1e9;
    let (value, at): (f64, Range<usize>) = (*file.get_ref(), file.span());
    if SCALES.contains(&value) {
        return Ok(value);
    }
    Err(Bad::new(
        at,
        format!("is {value}, and must be more than 0, 1e-9 to 1e9"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Outcome;

    const SCENE: &str = r##"
background = "#102030"

[camera]
yaw = 30
distance = 3

[[material]]
name = "bronze"
diffuse = "#906030"
phong = "#ffffff"
exponent = 20

[[light]]
direction = [0, 2, 0]
shadows = true

[ground]
size = 4
material = "bronze"

[[object]]
source = "terrain"
parameters = { seed = 3, resolution = 8 }
rho = [2, 3, 3]
material = "bronze"
translation = [1, 2, 3]
rotation = [0, 90, 0]
scale = 2
copies = [{ translation = [1, 0, 0] }, { scale = 0.5 }]

[[object]]
source = "terrain"
parameters = { resolution = 8, seed = 3 }
rho = [2, 3, 3]
stand = true
"##;

    fn parsed(text: &str) -> Outcome<Scene> {
        Scene::parse(text, "s.toml", &[])
    }

    #[test]
    fn a_scene_says_what_its_file_says() {
        let scene = parsed(SCENE).unwrap();
        assert_eq!(scene.background, Colour([16, 32, 48]));
        assert_eq!((scene.camera.yaw, scene.camera.distance), (30.0, 3.0));
        assert_eq!(scene.camera.fov, 45.0);
        assert_eq!(scene.lights[0].direction, DVec3::Y);
        assert!(scene.lights[0].shadows);
        let bronze = &scene.materials[0];
        assert_eq!(bronze.ambient, Colour([16, 11, 5]));
        assert_eq!((bronze.phong, bronze.exponent), (Colour([255; 3]), 20));
        assert_eq!(scene.ground.unwrap().material, 0);
    }

    #[test]
    fn objects_of_one_source_and_sequence_share_it() {
        let scene = parsed(SCENE).unwrap();
        assert_eq!((scene.sources.len(), scene.instances.len()), (1, 3));
        let other = parsed(&SCENE.replacen("rho = [2, 3, 3]", "rho = [3, 3, 3]", 1)).unwrap();
        assert_eq!(other.sources.len(), 2);
        assert_eq!(scene.instances[2].pivot, Pivot::Foot);
    }

    #[test]
    fn a_copy_is_placed_within_its_object() {
        let scene = parsed(SCENE).unwrap();
        let place = |i: usize, point: DVec3| scene.instances[i].transform.place(point);
        // Doubled, x turned to -z, moved.
        let expected = DVec3::new(1.0, 2.0, 3.0) - 2.0 * DVec3::Z;
        assert!((place(0, DVec3::ZERO) - expected).length() < 1e-12);
        assert!((place(1, DVec3::X) - DVec3::new(1.0, 2.0, 2.0)).length() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_named_with_file_line_and_field() {
        for (from, to, place, what) in [
            (
                "\"terrain\"",
                "\"dragn.ply\"",
                "line 23, source",
                "no file dragn.ply",
            ),
            (
                "\"terrain\"",
                "\"terain\"",
                "line 23, source",
                "no object \"terain\"",
            ),
            (
                "material = \"bronze\"\ntrans",
                "material = \"gold\"\ntrans",
                "line 26, material",
                "no material",
            ),
            ("scale = 2", "scale = 0", "line 29, scale", "is 0"),
            ("scale = 0.5", "scale = -1", "line 30, scale", "is -1"),
            ("[0, 2, 0]", "[0, 0, 0]", "line 15, direction", "no length"),
            (
                "[0, 2, 0]",
                "[0, nan, 0]",
                "line 15, direction",
                "three numbers",
            ),
            (
                "[0, 2, 0]",
                "[0, 2]",
                "line 15, direction",
                "invalid length",
            ),
            ("yaw = 30", "jaw = 30", "line 5, jaw", "unknown field"),
            (
                "distance = 3",
                "distance = -3",
                "line 4, camera",
                "--distance",
            ),
            (
                "exponent = 20",
                "exponent = 0",
                "line 12, exponent",
                "1 to 255",
            ),
            ("\"#906030\"", "\"brown\"", "line 10, diffuse", "no colour"),
            (
                "seed = 3, res",
                "sed = 3, res",
                "line 24, sed",
                "is not known",
            ),
            (
                "resolution = 8 }",
                "resolution = 0 }",
                "line 24, resolution",
                "may be",
            ),
            ("[2, 3, 3]", "[2, 7, 3]", "line 25, rho", ""),
            (
                "stand = true",
                "stand = 1",
                "line 36, stand",
                "expected a boolean",
            ),
            ("size = 4", "size = ", "line 19", ""),
        ] {
            assert!(SCENE.contains(from), "{from}");
            let failure = parsed(&SCENE.replacen(from, to, 1)).unwrap_err();
            assert!(
                failure.message.starts_with(&format!("s.toml, {place}")),
                "{failure}"
            );
            assert!(failure.message.contains(what), "{failure}");
            assert_eq!(failure.exit, crate::failure::Exit::Input);
        }
    }

    #[test]
    fn a_ninth_material_a_second_shadow_and_an_empty_scene_are_refused() {
        let more: String = (0..8)
            .map(|i| format!("[[material]]\nname = \"m{i}\"\ndiffuse = \"#000000\"\n"))
            .collect();
        let failure = parsed(&format!("{SCENE}{more}")).unwrap_err();
        assert!(
            failure.message.contains("more than 8 materials"),
            "{failure}"
        );
        assert!(failure.message.contains("line 58, material"), "{failure}");
        let twice = "[[light]]\ndirection = [1, 0, 0]\nshadows = true\n";
        let failure = parsed(&format!("{SCENE}{twice}")).unwrap_err();
        assert!(failure.message.contains("line 39, shadows"), "{failure}");
        let again = "[[material]]\nname = \"bronze\"\ndiffuse = \"#000000\"\n";
        let failure = parsed(&format!("{SCENE}{again}")).unwrap_err();
        assert!(failure.message.contains("already"), "{failure}");
        assert!(parsed("").unwrap_err().message.contains("no object"));
    }
}
