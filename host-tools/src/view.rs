//! The standard scene: where the eye stands, in f64, and as the integers a device takes.

use std::str::FromStr;

use clap::Args;
use fixed::traits::ToFixed;
use glam::{DMat3, DVec3};
use rho_grid::blob::Blob;
use rho_grid::camera::Camera;
use rho_grid::q::{Focal, Length, Rotation, Unit};

use crate::failure::{Failure, Outcome};
use crate::render;

/// The light of the standard scene: towards it, not normalised.
pub const STANDARD_LIGHT: DVec3 = DVec3::new(0.4, 0.6, 0.7);

/// A named view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum StandardView {
    /// The front face of the bounding cube is 216 pixels wide.
    Near,
    /// Four times as far away.
    Far,
    /// `near` with yaw 30, pitch 20.
    NearTurned,
    /// `far` with yaw 30, pitch 20.
    FarTurned,
}

impl StandardView {
    /// All four, in the order in which tables list them.
    pub const ALL: [Self; 4] = [Self::Near, Self::Far, Self::NearTurned, Self::FarTurned];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Near => "near",
            Self::Far => "far",
            Self::NearTurned => "near-turned",
            Self::FarTurned => "far-turned",
        }
    }
}

/// An eye that looks at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Degrees about y; the eye moves towards +x.
    pub yaw: f64,
    /// Degrees above the horizon.
    pub pitch: f64,
    /// From the origin to the eye, in cube units.
    pub distance: f64,
    /// Divides tan(fov / 2).
    pub zoom: f64,
    /// Vertical field of view in degrees.
    pub fov: f64,
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
}

impl From<StandardView> for View {
    fn from(view: StandardView) -> Self {
        let (distance, yaw, pitch) = match view {
            StandardView::Near => (2.2883, 0.0, 0.0),
            StandardView::Far => (9.1532, 0.0, 0.0),
            StandardView::NearTurned => (2.2883, 30.0, 20.0),
            StandardView::FarTurned => (9.1532, 30.0, 20.0),
        };
        Self {
            yaw,
            pitch,
            distance,
            zoom: 1.0,
            fov: 45.0,
            width: 240,
            height: 320,
        }
    }
}

impl View {
    /// What a device's camera sees that looks at the origin.
    #[must_use]
    pub fn of(camera: &Camera) -> Self {
        let [_, _, back] = camera.rotation.map(|row| row.map(Rotation::to_num::<f64>));
        let [_, _, z] = camera.translation.map(Length::to_num::<f64>);
        let half = f64::from(camera.height) / 2.0 / camera.focal.to_num::<f64>();
        Self {
            yaw: libm::atan2(back[0], back[2]).to_degrees(),
            pitch: libm::asin(back[1].clamp(-1.0, 1.0)).to_degrees(),
            distance: -z,
            zoom: 1.0,
            fov: 2.0 * libm::atan(half).to_degrees(),
            width: camera.width,
            height: camera.height,
        }
    }

    /// Where the eye stands.
    #[must_use]
    pub fn eye(&self) -> DVec3 {
        self.distance * self.back()
    }

    /// From the origin towards the eye; the camera's z axis.
    #[must_use]
    pub fn back(&self) -> DVec3 {
        let (yaw, pitch) = (self.yaw.to_radians(), self.pitch.to_radians());
        DVec3::new(
            yaw.sin() * pitch.cos(),
            pitch.sin(),
            yaw.cos() * pitch.cos(),
        )
    }

    /// World to eye: the rows are right, up and back.
    #[must_use]
    pub fn rotation(&self) -> DMat3 {
        let yaw = self.yaw.to_radians();
        let right = DVec3::new(yaw.cos(), 0.0, -yaw.sin());
        let back = self.back();
        DMat3::from_cols(right, back.cross(right), back).transpose()
    }

    /// Focal length in pixels.
    #[must_use]
    pub fn focal(&self) -> f64 {
        f64::from(self.height) / 2.0 / (self.fov.to_radians() / 2.0).tan() * self.zoom
    }

    /// The same view as the integers that a device takes, each rounded to nearest.
    ///
    /// # Errors
    /// When a number lies outside the range of its Q format; the message says which.
    pub fn camera(&self) -> Outcome<Camera> {
        let range = |flag: &str, value: f64, allowed: &str| {
            Failure::input(format!("{flag} {value} is out of range")).help(format!("use {allowed}"))
        };
        if !(self.yaw.is_finite() && self.pitch.is_finite()) {
            return Err(range(
                "--yaw or --pitch",
                self.yaw + self.pitch,
                "a number of degrees",
            ));
        }
        if !(self.distance >= 0.0 && self.distance < 2047.0) {
            return Err(range(
                "--distance",
                self.distance,
                "0 to 2047 sides of the cube",
            ));
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return Err(range(
                "--fov",
                self.fov,
                "more than 0 and less than 180 degrees",
            ));
        }
        let sides = 1..=Camera::MAX_SIDE;
        if !(sides.contains(&self.width) && sides.contains(&self.height)) {
            return Err(Failure::input(format!(
                "--size {}x{} is out of range",
                self.width, self.height
            ))
            .help(format!("use 1x1 to {0}x{0} pixels", Camera::MAX_SIDE)));
        }
        let focal = self.focal();
        if !(1.0..1_048_575.0).contains(&focal) {
            return Err(range(
                "--zoom",
                self.zoom,
                "a zoom and a field of view whose focal length is 1 to 1048575 pixels",
            ));
        }
        let rotation = self.rotation().transpose();
        let row = |v: DVec3| v.to_array().map(ToFixed::to_fixed::<Rotation>);
        Ok(Camera {
            rotation: [
                row(rotation.x_axis),
                row(rotation.y_axis),
                row(rotation.z_axis),
            ],
            translation: [
                Length::ZERO,
                Length::ZERO,
                (-self.distance).to_fixed::<Length>(),
            ],
            focal: focal.to_fixed::<Focal>(),
            width: self.width,
            height: self.height,
        })
    }
}

/// `240x320`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
}

impl FromStr for Size {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (w, h) = text.split_once('x')?;
            Some(Self {
                width: w.parse().ok()?,
                height: h.parse().ok()?,
            })
        };
        parse().ok_or_else(|| "expected WIDTHxHEIGHT in pixels, such as 240x320".to_owned())
    }
}

/// Three numbers, `X,Y,Z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction(pub DVec3);

impl FromStr for Direction {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text
            .split(',')
            .filter_map(|n| n.trim().parse().ok())
            .collect();
        let commas = text.matches(',').count();
        match numbers[..] {
            [x, y, z] if commas == 2 => {
                let v = DVec3::new(x, y, z);
                if v.is_finite() && v.length() > 0.0 {
                    Ok(Self(v))
                } else {
                    Err("a light needs a direction: three finite numbers, not all zero".to_owned())
                }
            }
            _ => Err("expected X,Y,Z, such as 0.4,0.6,0.7".to_owned()),
        }
    }
}

/// The flags that choose a view and its light.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "View")]
pub struct ViewArgs {
    /// A standard view; the flags below override its parts
    #[arg(long, value_enum)]
    pub view: Option<StandardView>,
    /// Degrees about the vertical axis
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Degrees above the horizon
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub pitch: Option<f64>,
    /// From the centre of the bounding cube to the eye, in sides of the cube
    #[arg(long, value_name = "D")]
    pub distance: Option<f64>,
    /// Enlarges the picture: divides tan(fov / 2)
    #[arg(long, value_name = "Z")]
    pub zoom: Option<f64>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG")]
    pub fov: Option<f64>,
    /// Towards the light
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub light: Option<Direction>,
    /// Pixels
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
}

impl ViewArgs {
    /// The camera: that of `blob` where it has one and no flag says otherwise, else as
    /// [`Self::view_over`] its view, or `near`.
    ///
    /// # Errors
    /// As [`View::camera`].
    pub fn camera(&self, blob: Option<&Blob<'_>>) -> Outcome<Camera> {
        let own = blob.and_then(Blob::camera);
        let untouched = self.view.is_none()
            && self.size.is_none()
            && [self.yaw, self.pitch, self.distance, self.zoom, self.fov] == [None; 5];
        match own {
            Some(camera) if untouched => Ok(camera),
            Some(camera) => self.view_over(View::of(&camera)).camera(),
            None => self.view().camera(),
        }
    }

    /// Towards the light, or the first light, as a device takes it: that of `blob` where it has one
    /// and no flag says otherwise.
    #[must_use]
    pub fn towards(&self, blob: Option<&Blob<'_>>) -> [Unit; 3] {
        let own = blob.and_then(|blob| blob.lights().next());
        match own {
            Some(light) if self.light.is_none() => light.towards,
            _ => render::light(self.light()),
        }
    }

    /// The view: `near` unless one is named, then each flag over it.
    #[must_use]
    pub fn view(&self) -> View {
        self.view_over(StandardView::Near.into())
    }

    /// The view: `unnamed` unless one is named, then each flag over it.
    #[must_use]
    pub fn view_over(&self, unnamed: View) -> View {
        let mut view = self.view.map_or(unnamed, View::from);
        view.yaw = self.yaw.unwrap_or(view.yaw);
        view.pitch = self.pitch.unwrap_or(view.pitch);
        view.distance = self.distance.unwrap_or(view.distance);
        view.zoom = self.zoom.unwrap_or(view.zoom);
        view.fov = self.fov.unwrap_or(view.fov);
        if let Some(size) = self.size {
            (view.width, view.height) = (size.width, size.height);
        }
        view
    }

    /// Towards the light, normalised.
    #[must_use]
    pub fn light(&self) -> DVec3 {
        self.light.map_or(STANDARD_LIGHT, |d| d.0).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_face_of_the_cube_is_216_pixels_wide_near() {
        let view = View::from(StandardView::Near);
        let width = view.focal() / (view.distance - 0.5);
        assert!((width - 216.0).abs() < 0.01, "{width}");
    }

    #[test]
    fn the_focal_length_is_that_of_the_standard_scene() {
        assert!((View::from(StandardView::Far).focal() - 386.27).abs() < 0.005);
    }

    #[test]
    fn the_turned_eye_stands_where_the_standard_scene_says() {
        let view = View::from(StandardView::NearTurned);
        let eye = view.eye() / view.distance;
        assert!((eye.x - 0.5 * 20f64.to_radians().cos()).abs() < 1e-12);
        assert!((eye.y - 20f64.to_radians().sin()).abs() < 1e-12);
        // The eye sees the origin on its axis, and up is up.
        let r = view.rotation();
        assert!((r * view.eye() - DVec3::new(0.0, 0.0, view.distance)).length() < 1e-12);
        assert!((r * DVec3::Y).y > 0.9);
    }

    #[test]
    fn a_view_is_read_back_from_its_camera() {
        for standard in StandardView::ALL {
            let view = View::from(standard);
            let back = View::of(&view.camera().unwrap());
            for (a, b) in [
                (view.yaw, back.yaw),
                (view.pitch, back.pitch),
                (view.distance, back.distance),
                (view.fov, back.fov),
            ] {
                assert!((a - b).abs() < 1e-4, "{view:?} {back:?}");
            }
        }
    }

    #[test]
    fn a_view_out_of_range_names_the_flag() {
        let mut view = View::from(StandardView::Near);
        view.distance = -1.0;
        assert!(view.camera().unwrap_err().message.contains("--distance"));
        view = View::from(StandardView::Near);
        view.zoom = 1e9;
        assert!(view.camera().unwrap_err().message.contains("--zoom"));
    }
}
