//! A model's triangles, drawn by the crate embedded-3dgfx.
//!
//! As its documentation advises for a microcontroller: the slim features with 16-bit depth, face
//! normals made before and kept in flash, flat shading by a directional light, near and far plane
//! close to the model, no telemetry, no caps, record and execute with a buffer of commands. Its
//! feature `fixed-raster`, meant for cores without a floating-point unit, takes more instructions
//! on this one and is left out.

use core::convert::Infallible;

use embedded_3dgfx::engine::K3dengine;
use embedded_3dgfx::pipeline::command_buffer::CommandBuffer;
use embedded_3dgfx::pipeline::renderer::FrameCtx;
use embedded_3dgfx::pipeline::vertex::mesh::{Geometry, K3dMesh, RenderMode};
use embedded_graphics_core::Pixel;
use embedded_graphics_core::draw_target::DrawTarget;
use embedded_graphics_core::geometry::{OriginDimensions, Size};
use embedded_graphics_core::pixelcolor::raw::{RawData, RawU16};
use embedded_graphics_core::pixelcolor::{Rgb565, RgbColor};
use nalgebra::{Point3, Vector3};
use rho_mps2_an385::Clock;
use rho_viewer::count::{Phase, Stopwatch};
use rho_viewer::request::Scene;
use rho_viewer::size::{HEIGHT, PIXELS, WIDTH};

use crate::{Buffer, pixels};

/// The first word of the data: `MESH`.
pub const MAGIC: u32 = u32::from_le_bytes(*b"MESH");

/// What drawing needs beside the frame, for at most `N` commands.
pub struct Memory<const N: usize> {
    depth: Buffer,
    commands: CommandBuffer<N>,
}

impl<const N: usize> Memory<N> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            depth: crate::empty(),
            commands: CommandBuffer::new(),
        }
    }
}

impl<const N: usize> Default for Memory<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// The mesh in the model's memory: the magic number, how many vertices and faces there are, the
/// vertices, the faces and a normal for each face.
#[must_use]
pub fn mesh(memory: &[u8]) -> Option<K3dMesh<'_>> {
    let words: &[u32] = bytemuck::try_cast_slice(memory).ok()?;
    let [magic, vertices, faces, rest @ ..] = words else {
        return None;
    };
    let counts = [*vertices, *faces].map(usize::try_from);
    let [Ok(vertices), Ok(faces)] = counts else {
        return None;
    };
    if *magic != MAGIC {
        return None;
    }
    let (vertices, rest) = rest.as_chunks::<3>().0.split_at_checked(vertices)?;
    let (faces, rest) = rest.split_at_checked(faces)?;
    let normals = rest.get(..faces.len())?;
    let mut mesh = K3dMesh::new(Geometry {
        vertices: bytemuck::cast_slice(vertices),
        faces: bytemuck::cast_slice(faces),
        normals: bytemuck::cast_slice(normals),
        ..Geometry::default()
    });
    mesh.set_color(Rgb565::WHITE);
    Some(mesh)
}

/// Draws it.
///
/// # Errors
/// When there is none, or too many of its triangles are seen.
pub fn draw<const N: usize>(
    mesh: Option<&mut K3dMesh<'_>>,
    scene: &Scene,
    frame: &mut Buffer,
    memory: &mut Memory<N>,
    watch: &mut Stopwatch<'_, Clock>,
) -> Result<(), &'static str> {
    let mesh = mesh.ok_or("there is no mesh here")?;
    let Memory { depth, commands } = memory;
    let engine = watch.time(Phase::Setup, || {
        let [x, y, z] = scene.light.map(|l| l.to_num::<f32>());
        // Its light shines along z where ours comes from there; 0.1 of the colour is ambient.
        mesh.set_render_mode(RenderMode::SolidLightDir(Vector3::new(x, y, -z) * 0.9));
        engine(scene)
    });
    watch.time(Phase::Clear, || frame.fill([0; 8]));
    watch.time(Phase::Draw, || {
        // Clears the depths by itself.
        let mut context = FrameCtx {
            zbuffer: pixels(depth),
            width: WIDTH.into(),
            height: HEIGHT.into(),
        };
        let mut target = Target(pixels(frame));
        engine
            .record(core::iter::once(&*mesh), commands, None)
            .and_then(|()| engine.execute(&mut target, &mut context, commands, None))
            .map(|_| ())
            .map_err(|_| "more triangles are seen than commands fit")
    })
}

/// The engine with the scene's camera.
fn engine(scene: &Scene) -> K3dengine {
    let mut engine = K3dengine::new(WIDTH, HEIGHT);
    let rows = scene
        .camera
        .rotation
        .map(|row| row.map(|r| r.to_num::<f32>()));
    let t = scene.camera.translation.map(|t| t.to_num::<f32>());
    // The eye is where the transform gives 0.
    let eye = |k: usize| -(0..3).map(|i| rows[i][k] * t[i]).sum::<f32>();
    let position = Point3::new(eye(0), eye(1), eye(2));
    let distance = position.coords.norm();
    // tan(fov / 2) is half the height over the focal length; the standard scene's is 45 degrees.
    let half = f32::from(HEIGHT) / 2.0 / scene.camera.focal.to_num::<f32>();
    engine
        .camera
        .set_fovy(2.0 * nalgebra::ComplexField::atan(half));
    engine.camera.set_position(position);
    engine.camera.set_target(Point3::origin());
    // The cube reaches 0.87 from its centre.
    engine
        .camera
        .set_near_far((distance - 0.9).max(0.1), distance + 0.9);
    engine
}

/// The frame as the engine's target.
struct Target<'a>(&'a mut [u16; PIXELS]);

impl OriginDimensions for Target<'_> {
    fn size(&self) -> Size {
        Size::new(WIDTH.into(), HEIGHT.into())
    }
}

impl DrawTarget for Target<'_> {
    type Color = Rgb565;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb565>>>(
        &mut self,
        all: I,
    ) -> Result<(), Infallible> {
        for Pixel(at, colour) in all {
            let (x, y) = (at.x as u32, at.y as u32);
            if x < u32::from(WIDTH) && y < u32::from(HEIGHT) {
                let at = y as usize * usize::from(WIDTH) + x as usize;
                if let Some(pixel) = self.0.get_mut(at) {
                    *pixel = RawU16::from(colour).into_inner();
                }
            }
        }
        Ok(())
    }
}
