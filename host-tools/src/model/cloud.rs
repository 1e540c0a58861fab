//! Points without faces become a surface of small discs.
//!
//! Each point's plane is fitted to its neighbours: its normal is the direction in which they
//! spread least. Which of both ways a normal points is passed on from neighbour to neighbour,
//! first where planes are most alike, along a minimal spanning tree (Hoppe, DeRose, Duchamp,
//! McDonald & Stuetzle 1992, section 3.3); each connected part then faces outward at its
//! extremes. Each point becomes a hexagon in its plane, large enough to overlap its neighbours,
//! so that the surface is closed where the points are dense.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use crate::failure::{Failure, Outcome};
use crate::mesh::Mesh;

/// Neighbours to which a plane is fitted and along which normals are passed on.
const NEIGHBOURS: usize = 18;

/// A disc reaches so far towards the neighbour of this number: of points on a square lattice,
/// 1.2 steps, where 0.71 would just close it.
const REACH: (usize, f64) = (8, 0.75);

/// Discs are at most so many times as large as the middle one: a lone point is no wall.
const LARGEST: f64 = 3.0;

/// Corners of what stands for a disc.
pub(super) const CORNERS: usize = 6;

/// The fewest different points that have a surface.
const FEWEST: usize = 4;

/// Points in cube units.
#[derive(Debug, Default)]
pub(super) struct Cloud {
    pub(super) positions: Vec<DVec3>,
    /// Of length 1, or empty.
    pub(super) normals: Vec<DVec3>,
    /// Empty, or one a point.
    pub(super) colours: Vec<[u8; 3]>,
}

type Point = GeomWithData<[f64; 3], u32>;

impl Cloud {
    /// The surface; `name` stands in messages.
    pub(super) fn surface(mut self, name: &str) -> Outcome<Mesh> {
        self.merge();
        let count = self.positions.len();
        if count < FEWEST {
            return Err(Failure::input(format!(
                "{name} has no faces and {count} different points, too few for a surface"
            ))
            .help(format!("give a mesh, or {FEWEST} points or more")));
        }
        let neighbours = self.neighbours();
        if self.normals.is_empty() {
            self.normals = (0..count)
                .into_par_iter()
                .map(|i| self.plane(i, &neighbours))
                .collect();
            self.orient(&neighbours);
        }
        Ok(self.discs(&neighbours))
    }

    /// Makes one of all points at the same place, with the mean of their colours.
    fn merge(&mut self) {
        let mut order: Vec<usize> = (0..self.positions.len()).collect();
        let place = |i: usize| self.positions[i].to_array();
        let compare = |a: &usize, b: &usize| {
            let (a, b) = (place(*a), place(*b));
            a.partial_cmp(&b).unwrap_or(Ordering::Equal)
        };
        order.sort_by(compare);
        let mut merged = Self::default();
        for same in order.chunk_by(|a, b| compare(a, b) == Ordering::Equal) {
            merged.positions.push(self.positions[same[0]]);
            if !self.normals.is_empty() {
                merged.normals.push(self.normals[same[0]]);
            }
            if !self.colours.is_empty() {
                let sum: DVec3 = same
                    .iter()
                    .map(|&i| DVec3::from_array(self.colours[i].map(f64::from)))
                    .sum();
                let mean = (sum / same.len() as f64).round();
                merged.colours.push(mean.to_array().map(|c| c as u8));
            }
        }
        *self = merged;
    }

    /// The nearest others of each point, the nearest first; all lists are as long.
    fn neighbours(&self) -> Neighbours {
        let points = self.positions.iter().zip(0..);
        let tree = RTree::bulk_load(
            points
                .map(|(p, i)| Point::new(p.to_array(), i))
                .collect::<Vec<_>>(),
        );
        let each = NEIGHBOURS.min(self.positions.len() - 1);
        let all = (0..self.positions.len())
            .into_par_iter()
            .flat_map_iter(|i| {
                let mut found: Vec<(f64, u32)> = tree
                    .nearest_neighbor_iter_with_distance_2(self.positions[i].to_array())
                    .map(|(point, distance)| (distance, point.data))
                    .filter(|(_, other)| *other as usize != i)
                    .take(each)
                    .collect();
                // Equally near ones in an order of their own, whatever the tree's is.
                found.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
                found.into_iter().map(|(_, other)| other)
            })
            .collect();
        Neighbours { each, all }
    }

    /// The normal of the plane that fits a point and its neighbours best.
    fn plane(&self, i: usize, neighbours: &Neighbours) -> DVec3 {
        let near = || {
            let others = neighbours.of(i).iter();
            others.map(|&j| self.positions[j as usize] - self.positions[i])
        };
        let count = neighbours.each as f64 + 1.0;
        let mean = near().sum::<DVec3>() / count;
        let mut spread = outer(mean);
        for off in near() {
            spread += outer(off - mean);
        }
        least(spread)
    }

    /// Turns normals round until neighbours agree and the whole faces outward.
    fn orient(&mut self, neighbours: &Neighbours) {
        let mut part = vec![u32::MAX; self.positions.len()];
        let mut parts = 0;
        let both_ways = neighbours.both_ways();
        for seed in 0..self.positions.len() {
            if part[seed] != u32::MAX {
                continue;
            }
            // Prim's minimal spanning tree; it takes a point the way that its normal agrees.
            let mut members = Vec::new();
            let mut open = BinaryHeap::new();
            open.push(Edge {
                unlike: 0.0,
                from: seed as u32,
                to: seed as u32,
            });
            while let Some(Edge { from, to, .. }) = open.pop() {
                let (from, at) = (from as usize, to as usize);
                if part[at] != u32::MAX {
                    continue;
                }
                part[at] = parts;
                members.push(at);
                if self.normals[at].dot(self.normals[from]) < 0.0 {
                    self.normals[at] = -self.normals[at];
                }
                for &next in both_ways.of(at) {
                    if part[next as usize] == u32::MAX {
                        let alike = self.normals[at].dot(self.normals[next as usize]).abs();
                        open.push(Edge {
                            unlike: 1.0 - alike,
                            from: to,
                            to: next,
                        });
                    }
                }
            }
            parts += 1;
            self.face_outward(&members);
        }
    }

    /// Turns all of a part if most of its extremes face inward.
    fn face_outward(&mut self, members: &[usize]) {
        let directions = (0..27_i32).filter(|&i| i != 13).map(|i| {
            let part = |i: i32| f64::from(i % 3 - 1);
            DVec3::new(part(i), part(i / 3), part(i / 9)).normalize()
        });
        let mut outward = 0.0;
        for direction in directions {
            let height = |i: &&usize| self.positions[**i].dot(direction);
            let extreme = members
                .iter()
                .max_by(|a, b| height(a).partial_cmp(&height(b)).unwrap_or(Ordering::Equal));
            outward += extreme.map_or(0.0, |&i| self.normals[i].dot(direction));
        }
        if outward < 0.0 {
            for &i in members {
                self.normals[i] = -self.normals[i];
            }
        }
    }

    /// A hexagon a point.
    fn discs(&self, neighbours: &Neighbours) -> Mesh {
        let reach = |i: usize| {
            let others = neighbours.of(i);
            let far = others[REACH.0.min(others.len()) - 1] as usize;
            REACH.1 * self.positions[i].distance(self.positions[far])
        };
        let radii: Vec<f64> = (0..self.positions.len()).map(reach).collect();
        let mut sorted = radii.clone();
        sorted.sort_by(f64::total_cmp);
        let largest = LARGEST * sorted[sorted.len() / 2];
        let mut mesh = Mesh::default();
        for (i, (&position, &normal)) in self.positions.iter().zip(&self.normals).enumerate() {
            let radius = radii[i].min(largest);
            let (across, up) = normal.any_orthonormal_pair();
            let first = mesh.positions.len() as u32;
            // A hexagon's corners, without sines.
            let high = 0.75_f64.sqrt();
            for (x, y) in [
                (1.0, 0.0),
                (0.5, high),
                (-0.5, high),
                (-1.0, 0.0),
                (-0.5, -high),
                (0.5, -high),
            ] {
                let corner = position + radius * (x * across + y * up);
                // What reaches out of the cube would be lost unevenly.
                mesh.positions
                    .push(corner.clamp(DVec3::splat(-0.5), DVec3::splat(0.5)));
                mesh.normals.push(normal);
                if let Some(&colour) = self.colours.get(i) {
                    mesh.colours.push(colour);
                }
            }
            let fan = (1..CORNERS as u32 - 1).map(|c| [first, first + c, first + c + 1]);
            mesh.triangles.extend(fan);
        }
        mesh
    }
}

/// Lists of points, one a point.
struct Neighbours {
    each: usize,
    all: Vec<u32>,
}

impl Neighbours {
    fn of(&self, i: usize) -> &[u32] {
        &self.all[i * self.each..(i + 1) * self.each]
    }

    /// With every point among the neighbours of its own neighbours.
    fn both_ways(&self) -> Graph {
        let count = self.all.len() / self.each;
        let mut ends = vec![self.each; count];
        for &other in &self.all {
            ends[other as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum;
        }
        let mut next = ends.clone();
        let mut all = vec![0; sum];
        let mut put = |at: usize, other: u32| {
            next[at] -= 1;
            all[next[at]] = other;
        };
        for i in 0..count {
            for &other in self.of(i) {
                put(i, other);
                put(other as usize, i as u32);
            }
        }
        Graph { ends, all }
    }
}

/// Lists of different lengths, one after the other.
struct Graph {
    ends: Vec<usize>,
    all: Vec<u32>,
}

impl Graph {
    fn of(&self, i: usize) -> &[u32] {
        let start = i.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.all[start..self.ends[i]]
    }
}

/// A way to a point that has not been taken yet; the greatest is that of least difference, the
/// lowest numbers first among equals.
#[derive(PartialEq)]
struct Edge {
    unlike: f64,
    from: u32,
    to: u32,
}

impl Eq for Edge {}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_number = (other.from, other.to).cmp(&(self.from, self.to));
        other.unlike.total_cmp(&self.unlike).then(by_number)
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// The direction in which a spread is least: the inverse, squared until only that is left.
fn least(spread: DMat3) -> DVec3 {
    const SQUARINGS: u32 = 6;
    let size = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    if size <= 0.0 {
        return DVec3::Y;
    }
    let mut power = (spread * (1.0 / size) + DMat3::from_diagonal(DVec3::splat(1e-6))).inverse();
    for _ in 0..SQUARINGS {
        let trace = power.x_axis.x + power.y_axis.y + power.z_axis.z;
        power *= 1.0 / trace;
        power = power * power;
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    let longest = columns.into_iter().reduce(|a, b| {
        if b.length_squared() > a.length_squared() {
            b
        } else {
            a
        }
    });
    longest.unwrap_or(DVec3::Y).normalize_or(DVec3::Y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points spread evenly over a sphere of radius 0.45.
    fn sphere(count: u32) -> Cloud {
        let positions: Vec<DVec3> = (0..count)
            .map(|i| {
                let y = 1.0 - (f64::from(i) + 0.5) * 2.0 / f64::from(count);
                let (sin, cos) = (f64::from(i) * 2.399_963).sin_cos();
                let flat = (1.0 - y * y).sqrt();
                0.45 * DVec3::new(flat * cos, y, flat * sin)
            })
            .collect();
        Cloud {
            colours: vec![[7, 8, 9]; positions.len()],
            positions,
            ..Cloud::default()
        }
    }

    #[test]
    fn the_normals_of_a_sphere_point_outward_all_of_them() {
        let mesh = sphere(2000).surface("ball").unwrap();
        assert_eq!(mesh.positions.len(), 2000 * CORNERS);
        for disc in 0..2000 {
            let corners = disc * CORNERS..(disc + 1) * CORNERS;
            let middle = mesh.positions[corners.clone()].iter().sum::<DVec3>() / CORNERS as f64;
            let cosine = mesh.normals[corners.start].dot(middle.normalize());
            assert!(cosine > 0.99, "{cosine}");
        }
        assert!(mesh.colours.iter().all(|&colour| colour == [7, 8, 9]));
    }

    #[test]
    fn the_discs_leave_no_gap() {
        let mesh = sphere(500).surface("ball").unwrap();
        let discs: Vec<&[DVec3]> = mesh.positions.chunks(CORNERS).collect();
        for place in sphere(3000).positions {
            let inside = discs
                .iter()
                .zip(mesh.normals.chunks(CORNERS))
                .any(|(disc, normals)| {
                    (0..CORNERS).all(|i| {
                        let (a, b) = (disc[i], disc[(i + 1) % CORNERS]);
                        (b - a).cross(place - a).dot(normals[0]) >= 0.0
                    }) && (place - disc[0]).dot(normals[0]).abs() < 0.05
                });
            assert!(inside, "{place}");
        }
    }

    #[test]
    fn parts_that_do_not_touch_face_outward_each() {
        let mut cloud = sphere(600);
        for p in &mut cloud.positions {
            *p = 0.4 * *p - 0.3 * DVec3::X;
        }
        let other: Vec<DVec3> = cloud
            .positions
            .iter()
            .map(|p| *p + 0.6 * DVec3::X)
            .collect();
        cloud.positions.extend(other);
        cloud.colours.clear();
        let mesh = cloud.surface("balls").unwrap();
        assert!(mesh.colours.is_empty());
        for (disc, normals) in mesh
            .positions
            .chunks(CORNERS)
            .zip(mesh.normals.chunks(CORNERS))
        {
            let middle = disc.iter().sum::<DVec3>() / CORNERS as f64;
            let centre = DVec3::new(0.3 * middle.x.signum(), 0.0, 0.0);
            assert!(normals[0].dot(middle - centre) > 0.0);
        }
    }

    #[test]
    fn points_at_one_place_become_one_of_their_mean_colour() {
        let mut cloud = sphere(10);
        cloud.positions.extend(cloud.positions.clone());
        cloud.colours.extend(vec![[17, 9, 9]; 10]);
        cloud.merge();
        assert_eq!(cloud.positions.len(), 10);
        assert!(cloud.colours.iter().all(|&colour| colour == [12, 9, 9]));
    }

    #[test]
    fn too_few_points_are_refused() {
        for count in 1..FEWEST as u32 {
            let failure = sphere(count).surface("few.ply").unwrap_err();
            assert!(failure.message.contains("few.ply"), "{failure}");
            assert!(failure.help.is_some());
        }
        assert!(sphere(FEWEST as u32).surface("few.ply").is_ok());
    }

    #[test]
    fn points_on_a_line_or_with_normals_of_their_own_do() {
        let line = Cloud {
            positions: (0..9)
                .map(|i| DVec3::X * (f64::from(i) / 8.0 - 0.5))
                .collect(),
            ..Cloud::default()
        };
        let mesh = line.surface("line").unwrap();
        assert!(
            mesh.normals
                .iter()
                .all(|n| n.x.abs() < 1e-3 && (n.length() - 1.0).abs() < 1e-9)
        );
        let given = Cloud {
            normals: vec![DVec3::Z; 50],
            ..sphere(50)
        };
        let mesh = given.surface("given").unwrap();
        assert!(mesh.normals.iter().all(|&n| n == DVec3::Z));
    }
}
