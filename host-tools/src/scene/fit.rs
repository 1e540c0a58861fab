//! A scene brought into its bounding cube.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{Pivot, Scene, Transform};
use crate::mesh::Mesh;

/// Where all stands in the scene's cube: that of all vertices, centred, of side 1.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// From each instance's cube into the scene's, in the scene's order.
    pub instances: Vec<Transform>,
    /// The same for the ground, as [`square`] has it.
    pub ground: Option<Transform>,
}

/// Fits a scene whose sources have these meshes.
#[must_use]
pub fn fit(scene: &Scene, meshes: &[&Mesh]) -> Fitted {
    let feet: Vec<DVec3> = meshes.iter().map(|mesh| foot(mesh)).collect();
    let place = |instance: &super::Instance| {
        let mut transform = instance.transform;
        if instance.pivot == Pivot::Foot {
            transform.translation = transform.place(-feet[instance.source]);
        }
        transform
    };
    let mut all: Vec<Transform> = scene.instances.iter().map(place).collect();
    let square = square(0.0);
    if let Some(ground) = &scene.ground {
        all.push(Transform {
            scale: ground.size,
            rotation: DMat3::IDENTITY,
            translation: ground.height * DVec3::Y,
        });
    }
    let sources = scene.instances.iter().map(|i| meshes[i.source]);
    let placed: Vec<(&Mesh, &Transform)> = sources.chain([&square]).zip(&all).collect();
    let points = || {
        placed
            .par_iter()
            .flat_map_iter(|(mesh, transform)| mesh.positions.iter().map(|&p| transform.place(p)))
    };
    let low = points().reduce(|| DVec3::INFINITY, DVec3::min);
    let high = points().reduce(|| DVec3::NEG_INFINITY, DVec3::max);
    let (middle, side) = (0.5 * (low + high), (high - low).max_element());
    for transform in &mut all {
        transform.scale /= side;
        transform.translation = (transform.translation - middle) / side;
    }
    let ground = scene.ground.as_ref().and_then(|_| all.pop());
    Fitted {
        instances: all,
        ground,
    }
}

/// The box that holds a mesh: low and high corner.
#[must_use]
pub fn bounds(mesh: &Mesh) -> [DVec3; 2] {
    let places = || mesh.positions.iter().copied();
    let low = places().reduce(DVec3::min).unwrap_or(DVec3::ZERO);
    let high = places().reduce(DVec3::max).unwrap_or(DVec3::ZERO);
    [low, high]
}

/// The middle of the lower face of its bounding box.
fn foot(mesh: &Mesh) -> DVec3 {
    let [low, high] = bounds(mesh);
    (0.5 * (low + high)).with_y(low.y)
}

/// The ground: side 1, about the vertical axis at this height, facing up.
#[must_use]
pub fn square(height: f64) -> Mesh {
    let corner = |x: f64, z: f64| DVec3::new(x, height, z);
    Mesh {
        positions: vec![
            corner(-0.5, -0.5),
            corner(-0.5, 0.5),
            corner(0.5, 0.5),
            corner(0.5, -0.5),
        ],
        normals: vec![DVec3::Y; 4],
        colours: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}
