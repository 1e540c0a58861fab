//! A block of land: fractal noise as a heightfield, with lakes, on a base of earth.
//!
//! Heights are a ridged multifractal (Musgrave, in Ebert et al., *Texturing and Modeling*,
//! chapter 16): octaves of 1 - |noise|, squared, each weighted by the one before, so that
//! ridges are rough and valleys smooth. The noise is Perlin's, of the crate `noise`. What lies
//! below the water's level is a lake.

use glam::{DVec2, DVec3};
use noise::{NoiseFn, Perlin};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Geometry;
use super::procedural::{BadParameter, Parameters, within};
use super::triangles::Triangles;
use crate::colour::Colour;
use crate::mesh::Mesh;

/// How far the block goes on below its lowest point, in cube units.
const BASE: f64 = 0.03;

/// How one octave follows another: finer by this factor, which is not 2, lest the zeros of all
/// octaves meet in one lattice, and turned by an angle whose cosine and sine these are.
const LACUNARITY: f64 = 1.97;
const TURN: DVec2 = DVec2::new(0.8, 0.6);

/// What a terrain is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Terrain {
    /// Which of the lands.
    pub seed: u32,
    /// How many mountains fit along a side.
    pub features: f64,
    /// Octaves of noise.
    pub octaves: u32,
    /// What is left of the height from one octave to the next.
    pub roughness: f64,
    /// From the lowest point to the highest, in sides of the block.
    pub height: f64,
    /// What share of the height is filled with water; 0 is dry.
    pub water_level: f64,
    /// From which share of the height on there is snow; 1 is none.
    pub snow_level: f64,
    /// Squares of two triangles along a side.
    pub resolution: u32,
    /// Of lakes where they are deep.
    pub water: Colour,
    /// By the shore.
    pub sand: Colour,
    /// Where it is flat and low.
    pub grass: Colour,
    /// Where it is flat and higher.
    pub forest: Colour,
    /// Where it is steep.
    pub rock: Colour,
    /// Where it is high and not steep.
    pub snow: Colour,
    /// The block's sides.
    pub earth: Colour,
}

impl Default for Terrain {
    fn default() -> Self {
        Self {
            seed: 1,
            features: 3.0,
            octaves: 8,
            roughness: 0.42,
            height: 0.27,
            water_level: 0.16,
            snow_level: 0.58,
            resolution: 512,
            water: Colour([44, 98, 150]),
            sand: Colour([206, 190, 140]),
            grass: Colour([122, 156, 70]),
            forest: Colour([70, 112, 56]),
            rock: Colour([128, 118, 108]),
            snow: Colour([246, 250, 255]),
            earth: Colour([110, 84, 62]),
        }
    }
}

impl Parameters for Terrain {
    fn check(&self) -> Result<(), BadParameter> {
        within("features", self.features, 0.01..=64.0)?;
        within("octaves", self.octaves, 1..=16)?;
        within("roughness", self.roughness, 0.0..=1.0)?;
        within("height", self.height, 0.0..=0.9)?;
        within("water_level", self.water_level, 0.0..=1.0)?;
        within("snow_level", self.snow_level, 0.0..=1.0)?;
        within("resolution", self.resolution, 1..=2048)
    }

    fn make(&self) -> Box<dyn Geometry> {
        Box::new(Triangles::owning(self.mesh()))
    }
}

/// Heights on a lattice of `n` + 1 points a side.
struct Heights {
    n: usize,
    /// 0 to 1, row by row along x.
    values: Vec<f64>,
}

impl Heights {
    fn at(&self, column: usize, row: usize) -> f64 {
        self.values[row * (self.n + 1) + column]
    }
}

impl Terrain {
    /// The land and the block's sides and bottom.
    fn mesh(&self) -> Mesh {
        let land = self.heights();
        let n = land.n;
        let level = self.water_level;
        // The lowest and highest point of what is seen stand at the cube's middle alike.
        let lowest = if level > 0.0 { level } else { 0.0 };
        let middle = 0.5 * ((lowest + 1.0) * self.height - BASE);
        let place = |column: usize, row: usize, height: f64| {
            let along = |i: usize| i as f64 / n as f64 - 0.5;
            DVec3::new(along(column), height * self.height - middle, along(row))
        };
        let mut mesh = Mesh::default();
        for row in 0..=n {
            for column in 0..=n {
                let height = land.at(column, row);
                mesh.positions.push(place(column, row, height.max(lowest)));
                let slope = self.normal(&land, column, row);
                let wet = height < level;
                mesh.normals.push(if wet { DVec3::Y } else { slope });
                let Colour(rgb) = self.colour(height, slope.y, column * 7 + row * 13);
                mesh.colours.push(rgb);
            }
        }
        for row in 0..n {
            for column in 0..n {
                let a = (row * (n + 1) + column) as u32;
                let (b, c) = (a + 1, a + n as u32 + 1);
                let d = c + 1;
                // The shorter diagonal, so that ridges are not cut into teeth.
                let height = |vertex: u32| mesh.positions[vertex as usize].y;
                let pair = if (height(a) - height(d)).abs() < (height(b) - height(c)).abs() {
                    [[a, c, d], [a, d, b]]
                } else {
                    [[a, c, b], [b, c, d]]
                };
                mesh.triangles.extend(pair);
            }
        }
        let floor = lowest * self.height - middle - BASE;
        self.sides(&mut mesh, n, floor);
        mesh
    }

    /// Walls from the land's rim down to `floor`, and the bottom.
    fn sides(&self, mesh: &mut Mesh, n: usize, floor: f64) {
        let at = |column: usize, row: usize| row * (n + 1) + column;
        let push = |mesh: &mut Mesh, position: DVec3, normal: DVec3| {
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.colours.push(self.earth.0);
            mesh.positions.len() as u32 - 1
        };
        // Each rim runs so that the outside is on its right.
        let rims: [(DVec3, Vec<usize>); 4] = [
            (DVec3::Z, (0..=n).map(|i| at(i, n)).collect()),
            (DVec3::X, (0..=n).rev().map(|i| at(n, i)).collect()),
            (DVec3::NEG_Z, (0..=n).rev().map(|i| at(i, 0)).collect()),
            (DVec3::NEG_X, (0..=n).map(|i| at(0, i)).collect()),
        ];
        for (normal, rim) in rims {
            let mut last = None;
            for vertex in rim {
                let top = mesh.positions[vertex];
                let upper = push(mesh, top, normal);
                let lower = push(mesh, top.with_y(floor), normal);
                if let Some((before, below)) = last.replace((upper, lower)) {
                    mesh.triangles.push([before, below, lower]);
                    mesh.triangles.push([before, lower, upper]);
                }
            }
        }
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        let [a, b, c, d] = corners.map(|(x, z)| push(mesh, DVec3::new(x, floor, z), DVec3::NEG_Y));
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }

    fn heights(&self) -> Heights {
        let n = self.resolution as usize;
        let sources: Vec<Perlin> = (0..=self.octaves)
            .map(|octave| Perlin::new(self.seed.wrapping_mul(0x9e37_79b9).wrapping_add(octave)))
            .collect();
        let mut values: Vec<f64> = (0..(n + 1) * (n + 1))
            .into_par_iter()
            .map(|i| {
                let at = DVec2::new((i % (n + 1)) as f64, (i / (n + 1)) as f64) / n as f64;
                // Mountains are not cut by the block's sides if it can be helped.
                let inside = at * (1.0 - at) * 4.0;
                let rim = (inside.x * inside.y).sqrt();
                self.raw(&sources, self.features * at) * (0.35 + 0.65 * rim)
            })
            .collect();
        // From 0 to 1, whatever the noise reached.
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let span = high - low;
        for value in &mut values {
            *value = if span > 0.0 {
                (*value - low) / span
            } else {
                0.0
            };
        }
        Heights { n, values }
    }

    /// The height at a place, in mountains from a corner; of no particular scale.
    fn raw(&self, sources: &[Perlin], place: DVec2) -> f64 {
        let at = |source: &Perlin, p: DVec2| source.get(p.to_array());
        // Broad hills and plains that the ridges stand on.
        let broad = 0.5 + 0.5 * at(&sources[0], 0.5 * place + DVec2::splat(17.3));
        let (mut sum, mut weight, mut share) = (0.0, 1.0, 1.0);
        let mut p = place;
        for source in &sources[1..] {
            let ridge = 1.0 - at(source, p).abs().min(1.0);
            let ridge = ridge * ridge * weight;
            sum += share * ridge;
            weight = (1.4 * ridge).min(1.0);
            share *= self.roughness;
            p = LACUNARITY * TURN.rotate(p) + DVec2::splat(3.7);
        }
        // Low land is flattened more than high land.
        sum * (0.35 + 1.3 * broad * broad)
    }

    /// Of the land, also below water.
    fn normal(&self, land: &Heights, column: usize, row: usize) -> DVec3 {
        let n = land.n;
        let slope = |low: f64, high: f64, steps: usize| {
            (high - low) * self.height * n as f64 / steps as f64
        };
        let (left, right) = (column.saturating_sub(1), (column + 1).min(n));
        let (back, front) = (row.saturating_sub(1), (row + 1).min(n));
        let x = slope(land.at(left, row), land.at(right, row), right - left);
        let z = slope(land.at(column, back), land.at(column, front), front - back);
        DVec3::new(-x, 1.0, -z).normalize()
    }

    /// By height and slope; `upright` is the normal's y.
    fn colour(&self, height: f64, upright: f64, place: usize) -> Colour {
        /// Shores are so much of the height broad.
        const SHORE: f64 = 0.015;
        // A little disorder, so that borders are not contour lines.
        let disorder = (place.wrapping_mul(2_654_435_761) >> 7) % 1024;
        let height = height + 0.02 * (disorder as f64 / 1024.0 - 0.5);
        let level = self.water_level;
        if level > 0.0 && height < level {
            let depth = (level - height) / level.max(0.01);
            return self
                .water
                .mix(self.sand, 0.4 * (1.0 - 6.0 * depth).max(0.0));
        }
        if height > self.snow_level && upright > 0.55 {
            return self.snow;
        }
        if upright < 0.66 {
            return self.rock;
        }
        if level > 0.0 && height < level + SHORE {
            return self.sand;
        }
        // From grass to forest half-way up to the snow.
        let up = (height - level) / (self.snow_level - level).max(0.01);
        if up > 0.85 {
            self.rock
        } else if up > 0.3 {
            self.forest
        } else {
            self.grass
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::triangle;
    use super::*;

    fn small() -> Terrain {
        Terrain {
            resolution: 40,
            ..Terrain::default()
        }
    }

    #[test]
    fn the_land_fills_the_cube_sideways_and_is_as_high_as_asked() {
        for (level, height) in [(0.0, 0.5), (0.3, 0.35)] {
            let mesh = Terrain {
                height: 0.5,
                water_level: level,
                ..small()
            }
            .mesh();
            let low = mesh.positions.iter().copied().reduce(DVec3::min).unwrap();
            let high = mesh.positions.iter().copied().reduce(DVec3::max).unwrap();
            let half = DVec3::new(0.5, 0.5 * (height + BASE), 0.5);
            assert!((high - half).length() < 1e-12, "{high}");
            assert!((low + half).length() < 1e-12, "{low}");
        }
    }

    #[test]
    fn the_block_is_closed_and_faces_outward() {
        let mesh = small().mesh();
        let mut edges = std::collections::BTreeMap::new();
        let key = |v: u32| mesh.positions[v as usize].to_array().map(f64::to_bits);
        let mut volume = 0.0;
        for triangle in &mesh.triangles {
            let corners = triangle.map(|v| mesh.positions[v as usize]);
            volume += triangle::area_normal(&corners).dot(corners[0]) / 6.0;
            for i in 0..3 {
                let (from, to) = (key(triangle[i]), key(triangle[(i + 1) % 3]));
                *edges.entry((from.min(to), from.max(to))).or_insert(0) +=
                    if from < to { 1 } else { -1 };
            }
        }
        assert!(volume > 0.0, "{volume}");
        // The bottom's four edges have no vertices between their ends, the walls' have.
        let open = edges.values().filter(|&&sum| sum != 0).count();
        assert_eq!(open, 4 + 4 * 40);
    }

    #[test]
    fn the_same_seed_gives_the_same_land_and_another_another() {
        let mesh = small().mesh();
        assert_eq!(mesh, small().mesh());
        assert_ne!(mesh, Terrain { seed: 2, ..small() }.mesh());
    }

    #[test]
    fn lakes_are_level_and_blue() {
        let terrain = small();
        let (land, mesh) = (terrain.heights(), terrain.mesh());
        let wet: Vec<usize> = (0..land.values.len())
            .filter(|&i| land.values[i] < terrain.water_level - 0.1)
            .collect();
        assert!(wet.len() > 10);
        for &i in &wet {
            assert_eq!(mesh.positions[i].y, mesh.positions[wet[0]].y);
            assert_eq!(mesh.normals[i], DVec3::Y);
            assert_eq!(mesh.colours[i], terrain.water.0);
        }
    }
}
