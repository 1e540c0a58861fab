//! What every reader hands over: vertices and triangles in the file's own units, and how
//! they become a [`Mesh`].

use glam::DVec3;

use super::cloud::{self, Cloud};
use super::input::Input;
use super::{Format, LoadOptions, Loaded, SourceInfo, Up};
use crate::failure::{Failure, Outcome};
use crate::mesh::Mesh;
use crate::text::thousands;

/// Vertices and triangles as the file has them.
#[derive(Debug, Default)]
pub(super) struct Soup {
    /// All of the file, also those in no face; each finite.
    pub(super) positions: Vec<DVec3>,
    /// Empty, or one a vertex; not of length 1, and zero or not finite where there is none.
    pub(super) normals: Vec<DVec3>,
    /// Empty, or one a vertex.
    pub(super) colours: Vec<[u8; 3]>,
    /// Valid indices, with and without area.
    pub(super) triangles: Vec<[u32; 3]>,
    /// One sentence each.
    pub(super) warnings: Vec<String>,
}

impl Soup {
    /// Checks, drops triangles without area, fills in normals, turns up and scales.
    pub(super) fn finish(
        mut self,
        input: &Input,
        format: Format,
        options: &LoadOptions,
    ) -> Outcome<Loaded> {
        let name = &input.name;
        let source = SourceInfo {
            format,
            vertices: self.positions.len(),
            triangles: self.triangles.len(),
            bytes: input.bytes.len() as u64,
        };
        if self.positions.is_empty() {
            return Err(Failure::input(format!("{name} has no vertices"))
                .help("export the model with its geometry"));
        }
        let (centre, side) = self.bounding_cube(name)?;
        let points = self.triangles.is_empty();
        if !points {
            // In the file's own numbers, where collinear points are so exactly.
            self.drop_without_area(name)?;
        }
        for p in &mut self.positions {
            *p = (*p - centre) / side;
        }
        if options.up == Up::Z {
            for v in self.positions.iter_mut().chain(&mut self.normals) {
                *v = DVec3::new(v.x, v.z, -v.y);
            }
        }
        if options.white {
            self.colours = Vec::new();
        }
        if points {
            let mesh = self.discs(input)?;
            return Ok(Loaded {
                mesh,
                warnings: self.warnings,
                source,
            });
        }
        self.complete_normals();
        Ok(Loaded {
            mesh: Mesh {
                positions: self.positions,
                normals: self.normals,
                colours: self.colours,
                triangles: self.triangles,
            },
            warnings: self.warnings,
            source,
        })
    }

    /// The surface of points without faces.
    fn discs(&mut self, input: &Input) -> Outcome<Mesh> {
        let points = self.positions.len() as u64;
        input.reserve(
            points * cloud::CORNERS as u64,
            points * (cloud::CORNERS as u64 - 2),
        )?;
        let usable = |n: &DVec3| n.try_normalize();
        let normals: Option<Vec<DVec3>> = self.normals.iter().map(usable).collect();
        let cloud = Cloud {
            positions: std::mem::take(&mut self.positions),
            // One that cannot be used, and all are made anew: they must agree.
            normals: normals.unwrap_or_default(),
            colours: std::mem::take(&mut self.colours),
        };
        self.warnings.push(format!(
            "{}: no faces; its {} points became discs{}",
            input.name,
            thousands(points),
            if cloud.normals.is_empty() {
                ", their normals guessed from their neighbours"
            } else {
                ""
            }
        ));
        cloud.surface(&input.name)
    }

    /// The centre and the side of the bounding cube of all vertices.
    fn bounding_cube(&self, name: &str) -> Outcome<(DVec3, f64)> {
        /// Sides beyond these lose precision to overflow or to denormals on the way.
        const SIDES: std::ops::RangeInclusive<f64> = 1e-60..=1e60;
        let first = self.positions[0];
        let (min, max) = self
            .positions
            .iter()
            .fold((first, first), |(min, max), &p| (min.min(p), max.max(p)));
        let side = (max - min).max_element();
        if side == 0.0 {
            let what = match self.positions.len() {
                1 => format!("{name} has 1 point, which is no surface"),
                n => format!("{name}: all {n} vertices are the same point"),
            };
            return Err(Failure::input(what).help("export the model again; its size is zero"));
        }
        if !SIDES.contains(&side) {
            return Err(Failure::input(format!(
                "{name}: the model is {side:e} units long, which is beyond what can be scaled"
            ))
            .help("export it in other units"));
        }
        // Halved before they are added, so that the sum cannot overflow.
        Ok((0.5 * min + 0.5 * max, side))
    }

    fn drop_without_area(&mut self, name: &str) -> Outcome {
        let before = self.triangles.len();
        let positions = &self.positions;
        self.triangles
            .retain(|&triangle| area_normal(positions, triangle) != DVec3::ZERO);
        if self.triangles.is_empty() {
            return Err(
                Failure::input(format!("{name}: all {before} triangles have zero area"))
                    .help("export the model again; its faces are collapsed"),
            );
        }
        let dropped = before - self.triangles.len();
        if dropped > 0 {
            let what = if dropped == 1 {
                "triangle"
            } else {
                "triangles"
            };
            self.warnings
                .push(format!("{name}: {dropped} {what} of zero area dropped"));
        }
        Ok(())
    }

    /// Scales the file's normals to length 1; where there is none, the faces round the vertex
    /// are summed, each by its area.
    fn complete_normals(&mut self) {
        let given = !self.normals.is_empty();
        self.normals.resize(self.positions.len(), DVec3::ZERO);
        let mut missing = vec![false; self.positions.len()];
        for (normal, missing) in self.normals.iter_mut().zip(&mut missing) {
            *normal = normal.try_normalize().unwrap_or(DVec3::ZERO);
            *missing = *normal == DVec3::ZERO;
        }
        if !missing.contains(&true) {
            return;
        }
        let mut used = vec![false; if given { self.positions.len() } else { 0 }];
        for &triangle in &self.triangles {
            let normal = area_normal(&self.positions, triangle);
            for i in triangle.map(|i| i as usize) {
                if missing[i] {
                    self.normals[i] += normal;
                }
                if given {
                    used[i] = true;
                }
            }
        }
        // Faces that cancel out leave nothing: the first face decides. A vertex in no face
        // is never shaded; it still gets a direction.
        let mut open = vec![false; self.positions.len()];
        for ((normal, &missing), open) in self.normals.iter_mut().zip(&missing).zip(&mut open) {
            if missing {
                *normal = normal.try_normalize().unwrap_or_else(|| {
                    *open = true;
                    DVec3::Y
                });
            }
        }
        if open.contains(&true) {
            for &triangle in &self.triangles {
                for i in triangle.map(|i| i as usize) {
                    if open[i] {
                        let normal = area_normal(&self.positions, triangle);
                        self.normals[i] = normal.try_normalize().unwrap_or(DVec3::Y);
                        open[i] = false;
                    }
                }
            }
        }
        let replaced = missing
            .iter()
            .zip(&used)
            .filter(|(m, u)| **m && **u)
            .count();
        if given && replaced > 0 {
            self.warnings.push(format!(
                "{replaced} vertices had no usable normal; theirs were made from the faces"
            ));
        }
    }
}

/// Twice the area, as a vector along the normal.
fn area_normal(positions: &[DVec3], triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize]);
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input() -> Input {
        Input::from_bytes("soup", vec![0], 1 << 20).unwrap()
    }

    fn soup(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Soup {
        Soup {
            positions: positions.iter().copied().map(DVec3::from).collect(),
            triangles: triangles.to_vec(),
            ..Soup::default()
        }
    }

    fn finish(soup: Soup) -> Outcome<Loaded> {
        soup.finish(&input(), Format::Ply, &LoadOptions::default())
    }

    #[test]
    fn the_bounding_cube_of_all_vertices_is_centred_with_side_one() {
        // The last vertex is in no face and still counts.
        let mesh = finish(soup(
            &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [4., -1., 2.]],
            &[[0, 1, 2]],
        ))
        .unwrap()
        .mesh;
        let max = mesh.positions.iter().copied().reduce(DVec3::max).unwrap();
        let min = mesh.positions.iter().copied().reduce(DVec3::min).unwrap();
        assert_eq!(
            (min, max),
            (DVec3::new(-0.5, -0.25, -0.25), DVec3::new(0.5, 0.25, 0.25))
        );
    }

    #[test]
    fn normals_are_weighted_by_area() {
        // Two faces share an edge: one in the xy plane of area 2, one in the xz plane of area 1.
        let mesh = finish(soup(
            &[[0., 0., 0.], [2., 0., 0.], [0., 2., 0.], [0., 0., 1.]],
            &[[0, 1, 2], [0, 3, 1]],
        ))
        .unwrap()
        .mesh;
        let expected = DVec3::new(0.0, 1.0, 2.0).normalize();
        assert!((mesh.normals[0] - expected).length() < 1e-12);
        assert!((mesh.normals[2] - DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn faces_that_cancel_out_take_the_first_ones_normal() {
        let mesh = finish(soup(
            &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]],
            &[[0, 1, 2], [0, 2, 1]],
        ))
        .unwrap()
        .mesh;
        assert!(mesh.normals.iter().all(|&n| n == DVec3::Z));
    }

    #[test]
    fn triangles_without_area_are_dropped_and_counted() {
        let loaded = finish(soup(
            &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0.5, 0., 0.]],
            &[[0, 1, 2], [0, 1, 3], [1, 1, 2]],
        ))
        .unwrap();
        assert_eq!(loaded.mesh.triangles, [[0, 1, 2]]);
        assert_eq!(loaded.source.triangles, 3);
        assert!(loaded.warnings[0].contains("2 triangles of zero area"));
    }

    #[test]
    fn a_model_without_any_area_or_extent_is_refused() {
        let line = soup(&[[0., 0., 0.], [1., 0., 0.], [2., 0., 0.]], &[[0, 1, 2]]);
        assert!(finish(line).unwrap_err().message.contains("zero area"));
        let point = soup(&[[3., 1., 2.]; 3], &[[0, 1, 2]]);
        assert!(finish(point).unwrap_err().message.contains("same point"));
        let cloud = soup(&[[3., 1., 2.]; 3], &[]);
        assert!(finish(cloud).unwrap_err().message.contains("same point"));
        let point = soup(&[[3., 1., 2.]], &[]);
        assert!(finish(point).unwrap_err().message.contains("1 point"));
        let huge = soup(
            &[[-1e308, 0., 0.], [1e308, 0., 0.], [0., 1., 0.]],
            &[[0, 1, 2]],
        );
        assert!(finish(huge).unwrap_err().message.contains("beyond"));
    }

    #[test]
    fn z_up_becomes_y_up() {
        let mut soup = soup(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], &[[0, 1, 2]]);
        soup.normals = vec![DVec3::Z; 3];
        let options = LoadOptions {
            up: Up::Z,
            ..LoadOptions::default()
        };
        let mesh = soup.finish(&input(), Format::Ply, &options).unwrap().mesh;
        assert_eq!(mesh.normals[0], DVec3::Y);
        assert_eq!(
            area_normal(&mesh.positions, [0, 1, 2]).normalize(),
            DVec3::Y
        );
    }

    #[test]
    fn unusable_normals_of_the_file_are_made_anew_with_a_warning() {
        let mut soup = soup(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], &[[0, 1, 2]]);
        soup.normals = vec![DVec3::X * 2.0, DVec3::ZERO, DVec3::NAN];
        let loaded = finish(soup).unwrap();
        assert_eq!(loaded.mesh.normals, [DVec3::X, DVec3::Z, DVec3::Z]);
        assert!(loaded.warnings[0].starts_with("2 vertices"));
    }
}
