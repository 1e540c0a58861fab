//! Ground truth of a scene: rays against every instance, its materials, lights and shadows.
//!
//! What is seen at a place is
//!
//! ```text
//! ambient + sum over lights of colour * (diffuse * max(0, n.l) + phong * max(0, r.e)^exponent)
//! ```
//!
//! as the display value, cut at white: n the normal, l towards the light, r its mirror image
//! about n, e towards the eye. A light that casts shadows counts only where nothing lies
//! between. An object without a material has its own colour c, as 0.1 c ambient and 0.9 c
//! diffuse. Rays are turned into each object's own cube, so that instances share one hierarchy.

use glam::DVec3;

use super::bvh::Bvh;
use super::ray::Ray;
use super::{AMBIENT, DIFFUSE, Rays, Shot, Truth, mix, off_surface, take};
use crate::colour::Colour;
use crate::failure::Outcome;
use crate::mesh::Mesh;
use crate::model::LoadOptions;
use crate::scene::fit::{Fitted, fit, square};
use crate::scene::{Scene, Transform};

/// A mesh made ready for rays.
struct Original {
    mesh: Mesh,
    bvh: Bvh,
}

impl Original {
    fn new(mesh: Mesh) -> Self {
        Self {
            bvh: Bvh::new(&mesh),
            mesh,
        }
    }
}

/// One object in the scene's cube.
struct Placed {
    original: usize,
    /// From the object's cube into the scene's.
    transform: Transform,
    material: Option<usize>,
}

/// What a ray met.
struct Seen<'a> {
    at: f64,
    placed: &'a Placed,
    triangle: u32,
    weights: super::Hit,
}

/// A scene made ready for rays.
pub struct SceneCaster<'a> {
    scene: &'a Scene,
    originals: Vec<Original>,
    placed: Vec<Placed>,
    warnings: Vec<String>,
}

impl<'a> SceneCaster<'a> {
    /// Reads and makes all sources, and brings the scene into its bounding cube: that of all
    /// vertices, centred, of side 1.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn new(scene: &'a Scene, options: &LoadOptions) -> Outcome<Self> {
        let mut originals: Vec<Original> = Vec::new();
        let mut warnings = Vec::new();
        // Sources that differ in their sequence alone are one here.
        let mut which = Vec::new();
        for (i, source) in scene.sources.iter().enumerate() {
            let same = |other: &crate::scene::Source| {
                other.object == source.object && other.up == source.up
            };
            if let Some(known) = scene.sources[..i].iter().position(same) {
                which.push(which[known]);
                continue;
            }
            let model = scene.open(i, options)?;
            warnings.extend(model.warnings.iter().cloned());
            which.push(originals.len());
            originals.push(Original::new(model.mesh().into_owned()));
        }
        let meshes: Vec<&Mesh> = which.iter().map(|&i: &usize| &originals[i].mesh).collect();
        let Fitted { instances, ground } = fit(scene, &meshes);
        let places = scene.instances.iter().zip(instances);
        let mut placed: Vec<Placed> = places
            .map(|(instance, transform)| Placed {
                original: which[instance.source],
                transform,
                material: instance.material,
            })
            .collect();
        if let (Some(ground), Some(transform)) = (&scene.ground, ground) {
            placed.push(Placed {
                original: originals.len(),
                transform,
                material: Some(ground.material),
            });
            originals.push(Original::new(square(0.0)));
        }
        Ok(Self {
            scene,
            originals,
            placed,
            warnings,
        })
    }

    /// Takes a picture; `row_done` is called once for each row, from any thread. The shot's own
    /// light does not count.
    ///
    /// # Errors
    /// As [`Shot::check`].
    pub fn render(&self, shot: &Shot, row_done: &(dyn Fn() + Sync)) -> Outcome<Truth> {
        let background = channels(self.scene.background);
        take(shot, background, row_done, |camera, x, y| {
            self.cast(camera, x, y)
        })
    }

    /// Vertices and triangles, those of every instance counted.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.placed.iter().fold((0, 0), |(vertices, triangles), p| {
            let mesh = &self.originals[p.original].mesh;
            (
                vertices + mesh.positions.len(),
                triangles + mesh.triangles.len(),
            )
        })
    }

    /// What the user should know about the sources, one sentence each.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The nearest object on a ray.
    fn nearest(&self, origin: DVec3, direction: DVec3) -> Option<Seen<'_>> {
        let mut best: Option<Seen<'_>> = None;
        for placed in &self.placed {
            let Transform {
                scale,
                rotation,
                translation,
            } = placed.transform;
            let back = rotation.transpose();
            let ray = Ray::new(
                back * (origin - translation) / scale,
                back * direction / scale,
            );
            if let Some((triangle, hit)) = self.originals[placed.original].bvh.nearest(&ray)
                && best.as_ref().is_none_or(|best| hit.t < best.at)
            {
                best = Some(Seen {
                    at: hit.t,
                    placed,
                    triangle,
                    weights: hit,
                });
            }
        }
        best
    }

    /// The colour, 0 to 255, and the depth along the camera's axis.
    fn cast(&self, camera: &Rays<'_>, x: f64, y: f64) -> Option<(DVec3, f64)> {
        let direction = camera.through(x, y);
        let seen = self.nearest(camera.eye, direction)?;
        let mesh = &self.originals[seen.placed.original].mesh;
        let corners = mesh.triangles[seen.triangle as usize].map(|i| i as usize);
        let turn = seen.placed.transform.rotation;
        let [a, b, c] = corners.map(|i| mesh.positions[i]);
        let face = turn * (b - a).cross(c - a).normalize_or(DVec3::Y);
        let mut normal = (turn * mix(&seen.weights, corners.map(|i| mesh.normals[i])))
            .try_normalize()
            .unwrap_or(face);
        if camera.shot.two_sided && normal.dot(direction) > 0.0 {
            normal = -normal;
        }
        let place = camera.eye + seen.at * direction;
        let eye = -direction.normalize();
        let colour = match seen.placed.material {
            Some(material) => {
                let material = &self.scene.materials[material];
                let [diffuse, phong] = [material.diffuse, material.phong].map(channels);
                channels(material.ambient)
                    + self.lit(place, normal, face, |light| {
                        let mirrored = 2.0 * normal.dot(light) * normal - light;
                        let shine = mirrored.dot(eye).max(0.0);
                        let shine = libm::pow(shine, f64::from(material.exponent));
                        diffuse * normal.dot(light) + phong * shine
                    })
            }
            None => {
                let own = if mesh.colours.is_empty() {
                    DVec3::splat(255.0)
                } else {
                    let colours = corners.map(|i| channels(Colour(mesh.colours[i])));
                    mix(&seen.weights, colours)
                };
                let lit = self.lit(place, normal, face, |light| {
                    DIFFUSE * own * normal.dot(light)
                });
                AMBIENT * own + lit
            }
        };
        Some((colour.min(DVec3::splat(255.0)), seen.at))
    }

    /// What the lights add, each by `shade` of its direction: those in front of the surface
    /// whose way is free.
    fn lit(
        &self,
        place: DVec3,
        normal: DVec3,
        face: DVec3,
        shade: impl Fn(DVec3) -> DVec3,
    ) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for light in &self.scene.lights {
            if normal.dot(light.direction) <= 0.0 {
                continue;
            }
            let start = off_surface(place, face, light.direction);
            if light.shadows && self.nearest(start, light.direction).is_some() {
                continue;
            }
            sum += channels(light.colour) / 255.0 * shade(light.direction);
        }
        sum
    }
}

fn channels(colour: Colour) -> DVec3 {
    DVec3::from_array(colour.0.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Caster;
    use crate::view::{StandardView, View};

    fn shot(view: View) -> Shot {
        Shot {
            samples: 1,
            ..Shot::standard(view)
        }
    }

    fn truth(text: &str, view: View) -> Truth {
        let scene = Scene::parse(text, "s.toml", &[]).unwrap();
        let caster = SceneCaster::new(&scene, &LoadOptions::default()).unwrap();
        caster.render(&shot(view), &|| ()).unwrap()
    }

    #[test]
    fn an_object_alone_is_the_model_wherever_it_stands() {
        let view = View::from(StandardView::NearTurned);
        let model = crate::source::open("terrain:resolution=20", None, &LoadOptions::default());
        let model = model.unwrap();
        let mesh = model.mesh();
        let alone = Caster::new(&mesh).render(&shot(view), &|| ()).unwrap();
        let scene = truth(
            "[[object]]\nsource = 'terrain'\nparameters = { resolution = 20 }\n\
             translation = [5, -3, 2]\nscale = 7\n",
            view,
        );
        let off = alone.picture.rgb.iter().zip(&scene.picture.rgb);
        let off = off.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1));
        assert!(off.count() < 20);
        assert_eq!(alone.covered_centres(), scene.covered_centres());
    }

    const BALL: &str = "
        [[material]]
        name = 'floor'
        diffuse = '#808080'
        ambient = '#101010'
        [[material]]
        name = 'ball'
        diffuse = '#800000'
        phong = '#404040'
        exponent = 50
        [[light]]
        direction = [0, 1, 0]
        shadows = true
        [ground]
        size = 4
        material = 'floor'
        [[object]]
        source = 'shapes'
        parameters = { parts = [{ shape = { sphere = { radius = 1 } } }] }
        material = 'ball'
        stand = true
        translation = [0, 1, 0]
        [[object]]
        source = 'shapes'
        parameters = { parts = [{ shape = { sphere = { radius = 1 } } }] }
        material = 'ball'
        stand = true
        scale = 0.5
        translation = [1, 0, 0]
    ";

    /// From above, where the cube's side is 4: pixels 50 a unit at the ground's middle.
    fn above() -> View {
        View {
            pitch: 90.0,
            distance: 1000.0,
            zoom: 400.0,
            width: 200,
            height: 200,
            ..StandardView::Near.into()
        }
    }

    #[test]
    fn shadows_materials_and_places_are_where_they_should_be() {
        let truth = truth(BALL, above());
        let at = |x: f64, z: f64| {
            let focal = above().focal() / 1000.0 / 4.0;
            let pixel = |v: f64| (100.0 + v * focal) as usize;
            truth.picture.rgb[pixel(z) * 200 + pixel(x)]
        };
        // The balls from straight above: red, and the large one's top mirrors the light.
        let ([r, g, b], [small, ..]) = (at(0.0, 0.0), at(1.0, 0.0));
        assert!(r > 180 && g > 40 && g == b, "{r} {g} {b}");
        assert!(small > 142, "{small}");
        // Between them the ground, in the light.
        assert_eq!(at(0.62, 0.0), [0x90; 3]);
    }

    #[test]
    fn a_ball_in_the_air_darkens_the_ground_from_the_side() {
        let scene = Scene::parse(BALL, "s.toml", &[]).unwrap();
        let caster = SceneCaster::new(&scene, &LoadOptions::default()).unwrap();
        let sum = |x: f64| {
            let place = DVec3::new(x, 1e-9, 0.0) / 4.0;
            let ground = caster.placed.last().unwrap().transform.translation;
            caster
                .lit(place.with_y(ground.y), DVec3::Y, DVec3::Y, |_| DVec3::ONE)
                .x
        };
        assert_eq!(sum(0.0), 0.0);
        assert_eq!(sum(0.45), 0.0);
        assert_eq!(sum(0.6), 1.0);
        assert_eq!(sum(1.0), 0.0);
        assert_eq!(sum(-1.0), 1.0);
    }

    #[test]
    fn the_background_shows_where_nothing_is() {
        let text = format!("background = '#112233'\n{BALL}");
        let truth = truth(&text, StandardView::Far.into());
        assert_eq!(truth.picture.rgb[0], [0x11, 0x22, 0x33]);
        assert_eq!(truth.picture.coverage.unwrap()[0], 0);
    }
}
