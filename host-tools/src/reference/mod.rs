//! Ground truth: the mesh itself, ray-cast in f64 in the standard scene.
//!
//! Each pixel is the mean over a regular grid of rays. A ray that meets the mesh counts
//! 0.1 + 0.9 max(0, n.l) times the colour there, as the display value; one that misses counts
//! black. The normal is interpolated between the vertices and made length 1 again.

mod bvh;
mod ray;
pub mod scene;

use glam::DVec3;
use rayon::prelude::*;

use crate::depth::Depth;
use crate::failure::{Failure, Outcome};
use crate::mesh::Mesh;
use crate::picture::Picture;
use crate::view::View;
use bvh::Bvh;
use ray::{Hit, Ray};

/// The light that reaches every face, as a part of white.
pub const AMBIENT: f64 = 0.1;
/// The light that a face turned to the light receives beside [`AMBIENT`].
pub const DIFFUSE: f64 = 0.9;

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Where the eye stands.
    pub view: View,
    /// Towards the light, of length 1.
    pub light: DVec3,
    /// Rays a pixel along each axis, 1 to 64: 5 for the ground truth, 1 for one exact ray
    /// through the pixel's centre.
    pub samples: u32,
    /// Turn a normal that points away from the eye round.
    pub two_sided: bool,
    /// Where the model lies between a place and the light, only [`AMBIENT`] is left.
    pub shadows: bool,
}

impl Shot {
    /// The ground truth of the standard scene: 5x5 rays a pixel.
    #[must_use]
    pub fn standard(view: View) -> Self {
        Self {
            view,
            light: crate::view::STANDARD_LIGHT.normalize(),
            samples: 5,
            two_sided: false,
            shadows: false,
        }
    }
}

impl Shot {
    /// Whether it can be taken.
    ///
    /// # Errors
    /// Exit 2 when the view or the number of samples is out of range; the message names the
    /// flag.
    pub fn check(&self) -> Outcome {
        // The same range as the device's.
        self.view.camera()?;
        if (1..=64).contains(&self.samples) {
            return Ok(());
        }
        Err(
            Failure::input(format!("--samples {} is out of range", self.samples))
                .help("use 1 to 64 rays along each axis of a pixel"),
        )
    }
}

/// What the rays saw.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The mean colour of each pixel, before a model's black or the scene's background, and its
    /// coverage.
    pub picture: Picture,
    /// At the centre of each pixel.
    pub depth: Depth,
}

impl Truth {
    /// Pixels whose centre the mesh covers.
    #[must_use]
    pub fn covered_centres(&self) -> usize {
        self.depth.values.iter().filter(|d| d.is_finite()).count()
    }

    /// Pixels of which the mesh covers half or more.
    #[must_use]
    pub fn covered(&self) -> usize {
        let coverage = self.picture.coverage.iter().flatten();
        coverage.filter(|&&c| c >= 128).count()
    }
}

/// A mesh made ready for rays.
#[derive(Debug)]
pub struct Caster<'a> {
    mesh: &'a Mesh,
    bvh: Bvh,
}

impl<'a> Caster<'a> {
    /// Builds the hierarchy; about a second for a million triangles.
    #[must_use]
    pub fn new(mesh: &'a Mesh) -> Self {
        Self {
            mesh,
            bvh: Bvh::new(mesh),
        }
    }

    /// Whether the mesh lies between `place` and a light towards `towards`.
    #[must_use]
    pub fn is_between(&self, place: DVec3, towards: DVec3) -> bool {
        self.bvh.nearest(&Ray::new(place, towards)).is_some()
    }

    /// Takes a picture; `row_done` is called once for each row, from any thread.
    ///
    /// # Errors
    /// As [`Shot::check`].
    pub fn render(&self, shot: &Shot, row_done: &(dyn Fn() + Sync)) -> Outcome<Truth> {
        take(shot, DVec3::ZERO, row_done, |camera, x, y| {
            self.cast(camera, x, y)
        })
    }

    /// The colour, 0 to 255, and the depth along the camera's axis.
    fn cast(&self, camera: &Rays<'_>, x: f64, y: f64) -> Option<(DVec3, f64)> {
        let direction = camera.through(x, y);
        let (triangle, hit) = self.bvh.nearest(&Ray::new(camera.eye, direction))?;
        let corners = self.mesh.triangles[triangle as usize].map(|i| i as usize);
        let mut normal = mix(&hit, corners.map(|i| self.mesh.normals[i]))
            .try_normalize()
            .unwrap_or_else(|| self.face_normal(corners));
        if camera.shot.two_sided && normal.dot(direction) > 0.0 {
            normal = -normal;
        }
        let mut lit = normal.dot(camera.shot.light).max(0.0);
        if camera.shot.shadows && lit > 0.0 {
            let light = camera.shot.light;
            let face = self.face_normal(corners);
            let start = off_surface(camera.eye + hit.t * direction, face, light);
            if self.bvh.nearest(&Ray::new(start, light)).is_some() {
                lit = 0.0;
            }
        }
        let intensity = AMBIENT + DIFFUSE * lit;
        let colour = if self.mesh.colours.is_empty() {
            DVec3::splat(255.0)
        } else {
            mix(
                &hit,
                corners.map(|i| DVec3::from(self.mesh.colours[i].map(f64::from))),
            )
        };
        // The direction is one long along the axis, so t is the depth.
        Some((intensity * colour, hit.t))
    }

    fn face_normal(&self, corners: [usize; 3]) -> DVec3 {
        let [a, b, c] = corners.map(|i| self.mesh.positions[i]);
        (b - a).cross(c - a).normalize_or(DVec3::Y)
    }
}

/// How far from a surface a shadow's ray begins, in sides of the cube: beyond the rounding of a hit,
/// below a pixel at any zoom in use.
const LIFT: f64 = 1e-6;

/// Where the ray towards `light` begins at `place` of a triangle with the normal `face`: off its side
/// that faces the light.
fn off_surface(place: DVec3, face: DVec3, light: DVec3) -> DVec3 {
    let up = face * face.dot(light).signum();
    place + LIFT * (up + light)
}

/// Takes a picture of what `cast` sees: the colour, 0 to 255, and the depth at a place of the
/// picture, or nothing but the background.
fn take(
    shot: &Shot,
    background: DVec3,
    row_done: &(dyn Fn() + Sync),
    cast: impl Fn(&Rays<'_>, f64, f64) -> Option<(DVec3, f64)> + Sync,
) -> Outcome<Truth> {
    shot.check()?;
    let (width, height) = (u32::from(shot.view.width), u32::from(shot.view.height));
    let camera = Rays::new(shot);
    let rows: Vec<Vec<Pixel>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let pixel = |x| Pixel::of(&camera, background, &cast, x, y);
            let row = (0..width).map(pixel).collect();
            row_done();
            row
        })
        .collect();
    let pixels = || rows.iter().flatten();
    Ok(Truth {
        picture: Picture {
            width,
            height,
            rgb: pixels().map(|p| p.rgb).collect(),
            coverage: Some(pixels().map(|p| p.coverage).collect()),
            background: Some(background.round().to_array().map(|c| c as u8))
                .filter(|c| *c != [0; 3]),
        },
        depth: Depth {
            width,
            height,
            values: pixels().map(|p| p.depth).collect(),
        },
    })
}

fn mix(hit: &Hit, corners: [DVec3; 3]) -> DVec3 {
    hit.weights[0] * corners[0] + hit.weights[1] * corners[1] + hit.weights[2] * corners[2]
}

struct Pixel {
    rgb: [u8; 3],
    coverage: u8,
    depth: f64,
}

impl Pixel {
    fn of(
        camera: &Rays<'_>,
        background: DVec3,
        cast: impl Fn(&Rays<'_>, f64, f64) -> Option<(DVec3, f64)>,
        x: u32,
        y: u32,
    ) -> Self {
        let n = camera.shot.samples;
        let mut sum = DVec3::ZERO;
        let mut hits = 0;
        let mut depth = None;
        for j in 0..n {
            for i in 0..n {
                let at = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
                let found = cast(camera, f64::from(x) + at(i), f64::from(y) + at(j));
                sum += found.map_or(background, |(colour, _)| colour);
                hits += u32::from(found.is_some());
                if 2 * i + 1 == n && 2 * j + 1 == n {
                    depth = Some(found.map_or(f64::INFINITY, |(_, depth)| depth));
                }
            }
        }
        let rays = f64::from(n * n);
        let centre = |k: u32| f64::from(k) + 0.5;
        Self {
            rgb: (sum / rays).to_array().map(|c| c.round() as u8),
            coverage: (255.0 * f64::from(hits) / rays).round() as u8,
            // An even grid has no ray through the centre.
            depth: depth.unwrap_or_else(|| {
                cast(camera, centre(x), centre(y)).map_or(f64::INFINITY, |(_, depth)| depth)
            }),
        }
    }
}

/// The rays of a shot.
struct Rays<'a> {
    shot: &'a Shot,
    eye: DVec3,
    /// Per pixel to the right, per pixel down, and to the picture's upper left corner, one
    /// unit in front of the eye.
    right: DVec3,
    down: DVec3,
    corner: DVec3,
}

impl<'a> Rays<'a> {
    fn new(shot: &'a Shot) -> Self {
        let view = &shot.view;
        let axes = view.rotation().transpose();
        let right = axes.x_axis / view.focal();
        let down = -axes.y_axis / view.focal();
        let corner = -axes.z_axis
            - right * (f64::from(view.width) / 2.0)
            - down * (f64::from(view.height) / 2.0);
        Self {
            shot,
            eye: view.eye(),
            right,
            down,
            corner,
        }
    }

    /// Towards a point of the picture, in pixels from its upper left corner; one unit long
    /// along the camera's axis.
    fn through(&self, x: f64, y: f64) -> DVec3 {
        self.corner + self.right * x + self.down * y
    }
}

#[cfg(test)]
mod tests;
