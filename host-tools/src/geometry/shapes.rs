//! Simple shapes, set together and grown into each other.
//!
//! Each shape is the exact distance to its surface outside of it and a bound inside (Quilez,
//! *Distance functions*). Scaled by s, distances are s times as large, so the bound stays one.
//! Shapes are joined by the smaller value, or over a width k by the polynomial smooth minimum:
//! its slope is a mean of both slopes, weighted, so never more than one unit a unit, and it lies
//! at most k/4 below the smaller.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::Geometry;
use super::field::Field;
use super::implicit::Implicit;
use super::procedural::{BadParameter, Parameters, within};
use crate::colour::Colour;

/// Shapes in units of one's own; together they are brought into the cube.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shapes {
    /// Joined in this order.
    pub parts: Vec<Part>,
}

/// A shape at its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// What it is.
    pub shape: Shape,
    /// Where its middle is.
    #[serde(default)]
    pub at: [f64; 3],
    /// How many times as large.
    #[serde(default = "one")]
    pub scale: f64,
    /// Over what width it is grown together with the parts before it.
    #[serde(default)]
    pub smooth: f64,
    /// Its colour.
    #[serde(default = "white")]
    pub colour: Colour,
}

fn one() -> f64 {
    1.0
}

fn white() -> Colour {
    Colour(super::WHITE)
}

/// A shape about the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// From its middle.
        radius: f64,
    },
    /// A box of these sides, its edges rounded.
    Box {
        /// Along x, y, z.
        size: [f64; 3],
        /// Of the edges; at most half the shortest side.
        #[serde(default)]
        round: f64,
    },
    /// A ring about the y axis.
    Torus {
        /// From the axis to the middle of the tube.
        ring: f64,
        /// Of the tube.
        tube: f64,
    },
    /// A cylinder about the y axis, its edges rounded.
    Cylinder {
        /// From the axis.
        radius: f64,
        /// Along the axis.
        height: f64,
        /// Of the edges.
        #[serde(default)]
        round: f64,
    },
    /// A ball drawn along a line from the origin.
    Capsule {
        /// The other end of the line.
        to: [f64; 3],
        /// About the line.
        radius: f64,
    },
    /// All that lies below a plane; the cube cuts it off.
    Plane {
        /// Away from the shape, of any length.
        normal: [f64; 3],
    },
}

impl Shape {
    /// The distance from a place to the surface, or a bound of it.
    fn value(&self, at: DVec3) -> f64 {
        let rounded =
            |beyond: DVec2| beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0);
        let flat = |at: DVec3| DVec2::new(at.x, at.z).length();
        match *self {
            Self::Sphere { radius } => at.length() - radius,
            Self::Box { size, round } => {
                let beyond = at.abs() - 0.5 * DVec3::from_array(size) + round;
                beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0) - round
            }
            Self::Torus { ring, tube } => DVec2::new(flat(at) - ring, at.y).length() - tube,
            Self::Cylinder {
                radius,
                height,
                round,
            } => {
                let beyond = DVec2::new(flat(at) - radius, at.y.abs() - 0.5 * height);
                rounded(beyond + round) - round
            }
            Self::Capsule { to, radius } => {
                let line = DVec3::from_array(to);
                let share = at.dot(line) / line.length_squared().max(f64::MIN_POSITIVE);
                at.distance(line * share.clamp(0.0, 1.0)) - radius
            }
            Self::Plane { normal } => at.dot(DVec3::from_array(normal).normalize_or(DVec3::Y)),
        }
    }

    /// The lowest and highest corner of its bounding box; `None` if it has none.
    fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let about = |half: DVec3| Some((-half, half));
        match *self {
            Self::Sphere { radius } => about(DVec3::splat(radius)),
            Self::Box { size, .. } => about(0.5 * DVec3::from_array(size)),
            Self::Torus { ring, tube } => about(DVec3::new(ring + tube, tube, ring + tube)),
            Self::Cylinder { radius, height, .. } => {
                about(DVec3::new(radius, 0.5 * height, radius))
            }
            Self::Capsule { to, radius } => {
                let to = DVec3::from_array(to);
                Some((to.min(DVec3::ZERO) - radius, to.max(DVec3::ZERO) + radius))
            }
            Self::Plane { .. } => None,
        }
    }

    fn check(&self) -> Result<(), BadParameter> {
        /// Lengths that can be told from nothing, and squared.
        const LENGTHS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
        let edge = |round: f64, least: f64| within("parts round", round, 0.0..=0.5 * least);
        match *self {
            Self::Sphere { radius } => within("parts radius", radius, LENGTHS),
            Self::Box { size, round } => {
                for side in size {
                    within("parts size", side, LENGTHS)?;
                }
                edge(round, DVec3::from_array(size).min_element())
            }
            Self::Torus { ring, tube } => {
                within("parts ring", ring, LENGTHS)?;
                within("parts tube", tube, LENGTHS)
            }
            Self::Cylinder {
                radius,
                height,
                round,
            } => {
                within("parts radius", radius, LENGTHS)?;
                within("parts height", height, LENGTHS)?;
                edge(round, height.min(2.0 * radius))
            }
            Self::Capsule { to, radius } => {
                for end in to {
                    within("parts to", end, -1e6..=1e6)?;
                }
                within("parts radius", radius, LENGTHS)
            }
            Self::Plane { normal } => {
                let length = DVec3::from_array(normal).length();
                within("parts normal", length, LENGTHS)
            }
        }
    }
}

impl Default for Shapes {
    /// A rubber duck in a swimming ring.
    fn default() -> Self {
        let yellow = Colour([250, 204, 52]);
        let orange = Colour([238, 116, 36]);
        let part = |shape, at, smooth, colour| Part {
            shape,
            at,
            scale: 1.0,
            smooth,
            colour,
        };
        let ball = |radius| Shape::Sphere { radius };
        let mut parts = vec![
            // Body, breast, tail, neck, head.
            part(ball(0.56), [-0.1, 0.0, 0.0], 0.0, yellow),
            part(ball(0.44), [0.22, 0.06, 0.0], 0.25, yellow),
            part(
                Shape::Capsule {
                    to: [-0.36, 0.3, 0.0],
                    radius: 0.07,
                },
                [-0.46, 0.2, 0.0],
                0.36,
                yellow,
            ),
            part(ball(0.2), [0.26, 0.44, 0.0], 0.3, yellow),
            part(ball(0.36), [0.32, 0.76, 0.0], 0.12, yellow),
        ];
        for side in [-1.0, 1.0] {
            let wing = Shape::Capsule {
                to: [-0.34, 0.1, 0.06 * side],
                radius: 0.13,
            };
            parts.push(part(wing, [0.02, 0.08, 0.47 * side], 0.08, yellow));
            parts.push(part(
                ball(0.07),
                [0.56, 0.9, 0.19 * side],
                0.0,
                Colour([24, 22, 30]),
            ));
            parts.push(part(
                ball(0.024),
                [0.602, 0.925, 0.224 * side],
                0.0,
                Colour([255, 255, 255]),
            ));
        }
        let lip = |y: f64| Shape::Capsule {
            to: [0.2, y, 0.0],
            radius: 0.075,
        };
        parts.push(part(lip(0.03), [0.62, 0.71, 0.0], 0.05, orange));
        parts.push(part(lip(-0.03), [0.6, 0.66, 0.0], 0.03, orange));
        parts.push(part(
            Shape::Torus {
                ring: 0.78,
                tube: 0.2,
            },
            [0.0, -0.22, 0.0],
            0.0,
            Colour([214, 50, 56]),
        ));
        Self { parts }
    }
}

impl Parameters for Shapes {
    fn check(&self) -> Result<(), BadParameter> {
        // Every value asks all of them.
        within("parts count", self.parts.len(), 1..=256)?;
        for part in &self.parts {
            part.shape.check()?;
            within("parts scale", part.scale, 1e-6..=1e6)?;
            within("parts smooth", part.smooth, 0.0..=1e6)?;
            for place in part.at {
                within("parts at", place, -1e6..=1e6)?;
            }
        }
        Ok(())
    }

    fn make(&self) -> Box<dyn Geometry> {
        /// Triangles as fine as the finest cells that are baked by default.
        const DETAIL: u32 = 256;
        Box::new(Implicit::new(Union::new(&self.parts), DETAIL))
    }
}

/// All parts, and where the cube lies among them.
#[derive(Debug)]
struct Union {
    parts: Vec<Part>,
    middle: DVec3,
    side: f64,
}

impl Union {
    fn new(parts: &[Part]) -> Self {
        let mut bounds: Option<(DVec3, DVec3)> = None;
        for part in parts {
            if let Some((low, high)) = part.shape.bounds() {
                let at = DVec3::from_array(part.at);
                // What is grown together bulges by so much.
                let bulge = 0.25 * part.smooth;
                let (low, high) = (
                    low * part.scale + at - bulge,
                    high * part.scale + at + bulge,
                );
                bounds = Some(bounds.map_or((low, high), |(a, b)| (a.min(low), b.max(high))));
            }
        }
        let (low, high) = bounds.unwrap_or((DVec3::splat(-0.5), DVec3::splat(0.5)));
        Self {
            parts: parts.to_vec(),
            middle: 0.5 * (low + high),
            side: (high - low).max_element(),
        }
    }

    fn values(&self, at: DVec3) -> impl Iterator<Item = (f64, &Part)> {
        let place = self.middle + self.side * at;
        self.parts.iter().map(move |part| {
            let within = (place - DVec3::from_array(part.at)) / part.scale;
            (part.scale * part.shape.value(within), part)
        })
    }
}

impl Field for Union {
    fn value(&self, at: DVec3) -> f64 {
        let joined = self.values(at).fold(f64::INFINITY, |sum, (value, part)| {
            smooth_minimum(sum, value, part.smooth)
        });
        joined / self.side
    }

    /// Of the part whose own surface is nearest.
    fn colour(&self, at: DVec3) -> [u8; 3] {
        let nearest = self.values(at).reduce(|a, b| if b.0 < a.0 { b } else { a });
        nearest.map_or(super::WHITE, |(_, part)| part.colour.0)
    }
}

/// The smaller of two values, rounded over a width.
fn smooth_minimum(a: f64, b: f64, width: f64) -> f64 {
    let near = (width - (a - b).abs()).max(0.0);
    if near == 0.0 {
        return a.min(b);
    }
    a.min(b) - near * near / (4.0 * width)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_shape() -> impl Strategy<Value = Shape> {
        let length = 0.05..0.5_f64;
        let three = || prop::array::uniform3(0.1..0.8_f64);
        prop_oneof![
            length.clone().prop_map(|radius| Shape::Sphere { radius }),
            (three(), 0.0..0.05_f64).prop_map(|(size, round)| Shape::Box { size, round }),
            (length.clone(), 0.02..0.2_f64).prop_map(|(ring, tube)| Shape::Torus { ring, tube }),
            (length.clone(), length.clone(), 0.0..0.025_f64).prop_map(|(radius, height, round)| {
                Shape::Cylinder {
                    radius,
                    height,
                    round,
                }
            }),
            (three(), length).prop_map(|(to, radius)| Shape::Capsule { to, radius }),
            three().prop_map(|normal| Shape::Plane { normal }),
        ]
    }

    fn any_union() -> impl Strategy<Value = Union> {
        let part = (
            any_shape(),
            prop::array::uniform3(-0.5..0.5_f64),
            0.5..2.0_f64,
            0.0..0.3_f64,
        );
        prop::collection::vec(part, 1..5).prop_map(|parts| {
            let parts: Vec<Part> = parts
                .into_iter()
                .map(|(shape, at, scale, smooth)| Part {
                    shape,
                    at,
                    scale,
                    smooth,
                    colour: white(),
                })
                .collect();
            Union::new(&parts)
        })
    }

    proptest! {
        #[test]
        fn the_value_never_changes_faster_than_the_place(
            union in any_union(),
            a in prop::array::uniform3(-0.6..0.6_f64), step in prop::array::uniform3(-0.1..0.1_f64)
        ) {
            let (a, step) = (DVec3::from_array(a), DVec3::from_array(step));
            let change = (union.value(a + step) - union.value(a)).abs();
            prop_assert!(change <= step.length() * (1.0 + 1e-9) + 1e-12);
        }

        #[test]
        fn what_has_bounds_lies_within_the_cube(
            union in any_union(), at in prop::array::uniform3(-1.0..1.0_f64)
        ) {
            prop_assume!(union.parts.iter().all(|part| part.shape.bounds().is_some()));
            let at = DVec3::from_array(at);
            if at.abs().max_element() > 0.5 {
                prop_assert!(union.value(at) > 0.0);
            }
        }
    }

    #[test]
    fn each_shape_has_its_surface_where_it_should() {
        for (shape, on) in [
            (Shape::Sphere { radius: 2.0 }, [0.0, 2.0, 0.0]),
            (
                Shape::Box {
                    size: [2.0, 4.0, 6.0],
                    round: 0.5,
                },
                [0.0, 0.0, 3.0],
            ),
            (
                Shape::Torus {
                    ring: 3.0,
                    tube: 1.0,
                },
                [0.0, 1.0, 3.0],
            ),
            (
                Shape::Cylinder {
                    radius: 1.0,
                    height: 4.0,
                    round: 0.1,
                },
                [0.3, 2.0, 0.3],
            ),
            (
                Shape::Capsule {
                    to: [4.0, 0.0, 0.0],
                    radius: 1.0,
                },
                [5.0, 0.0, 0.0],
            ),
            (
                Shape::Plane {
                    normal: [0.0, 5.0, 0.0],
                },
                [7.0, 0.0, 7.0],
            ),
        ] {
            let on = DVec3::from_array(on);
            assert!(shape.value(on).abs() < 1e-12, "{shape:?}");
            let off = on.normalize() * 0.01;
            assert!(
                shape.value(on + off) * shape.value(on - off) <= 0.0,
                "{shape:?}"
            );
        }
    }

    #[test]
    fn parts_are_read_from_a_scene_and_wrong_ones_named() {
        let read = |text: &str| toml::from_str::<Shapes>(text).map_err(|e| e.message().to_owned());
        let shapes = read(
            "parts = [{ shape = { sphere = { radius = 1 } } },\n\
             { shape = { box = { size = [1, 2, 3] } }, at = [0, 1, 0], colour = '#ff0000' }]",
        )
        .unwrap();
        assert_eq!(shapes.parts[1].colour, Colour([255, 0, 0]));
        assert!(shapes.check().is_ok());
        assert!(
            read("parts = [{ shape = { cone = { radius = 1 } } }]")
                .unwrap_err()
                .contains("cone")
        );
        let thin = read("parts = [{ shape = { sphere = { radius = 0 } } }]").unwrap();
        assert_eq!(thin.check().unwrap_err().name, "parts radius");
        assert!(Shapes { parts: Vec::new() }.check().is_err());
    }

    #[test]
    fn a_part_shows_its_own_colour() {
        let duck = Union::new(&Shapes::default().parts);
        let colour =
            |x: f64, y: f64, z: f64| duck.colour((DVec3::new(x, y, z) - duck.middle) / duck.side);
        assert_eq!(colour(0.32, 1.12, 0.0), [250, 204, 52]);
        assert_eq!(colour(0.9, 0.7, 0.0), [238, 116, 36]);
        assert_eq!(colour(0.0, -0.22, 0.98), [214, 50, 56]);
    }
}
