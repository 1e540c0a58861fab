//! Menger's sponge: the fractal that can be looked into without end.
//!
//! A cube is cut into 27 and loses its middle and the middles of its faces, and so does every
//! cube that is left. As a field: the largest of the cube's own distance and, for each level,
//! of how deep a place lies in that level's bars. Each of these changes by at most one unit a
//! unit, and so does the largest of them: the bound that an implicit object asks for is proved, not
//! estimated as it is for Mandelbulbs. On faces it is the distance; opposite an edge or a corner
//! at least 1/sqrt(3) of it.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Geometry;
use super::field::Field;
use super::implicit::Implicit;
use super::procedural::{BadParameter, Parameters, within};
use crate::colour::Colour;

/// Of what a sponge is made and through which window it is seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sponge {
    /// Sizes of holes: those of a third of the window, and so on down.
    pub levels: u32,
    /// By how much the window is smaller than the sponge.
    pub zoom: f64,
    /// The window's middle, in sides of the sponge from its middle.
    pub x: f64,
    /// The same upwards.
    pub y: f64,
    /// The same towards the viewer.
    pub z: f64,
    /// Whether the half towards (1, 1, 1) is cut away.
    pub cut: bool,
    /// Of the outer faces.
    pub outside: Colour,
    /// Of the walls of the smallest holes.
    pub inside: Colour,
    /// Of the face where it is cut.
    pub section: Colour,
}

impl Default for Sponge {
    fn default() -> Self {
        Self {
            levels: 4,
            zoom: 1.0,
            x: 0.0,
            y: 0.0,
            z: 0.0,
            cut: true,
            outside: Colour([236, 214, 170]),
            inside: Colour([150, 44, 40]),
            section: Colour([92, 132, 150]),
        }
    }
}

impl Parameters for Sponge {
    fn check(&self) -> Result<(), BadParameter> {
        within("levels", self.levels, 0..=8)?;
        within("zoom", self.zoom, 1.0..=1e6)?;
        within("x", self.x, -0.5..=0.5)?;
        within("y", self.y, -0.5..=0.5)?;
        within("z", self.z, -0.5..=0.5)
    }

    fn make(&self) -> Box<dyn Geometry> {
        /// Fine enough for holes of four levels.
        const DETAIL: u32 = 384;
        Box::new(Implicit::new(Window::new(self), DETAIL))
    }
}

/// What of the sponge is in the cube.
#[derive(Debug)]
struct Window {
    middle: DVec3,
    /// In sides of the sponge. Somewhat more than the sponge, also that its faces do not lie in
    /// faces of cells.
    side: f64,
    levels: u32,
    cut: bool,
    /// Whether the window ends in faces.
    closed: bool,
    /// Of the outer faces, then of each level's walls.
    walls: Vec<Colour>,
    section: Colour,
}

impl Window {
    fn new(sponge: &Sponge) -> Self {
        const MARGIN: f64 = 1.0171;
        // Levels above the window's own.
        let mut above = 0;
        let mut size = sponge.zoom;
        while size >= 3.0 {
            size /= 3.0;
            above += 1;
        }
        let shades = sponge.levels.clamp(1, 5);
        let wall = |i: u32| {
            sponge
                .outside
                .mix(sponge.inside, f64::from(i) / f64::from(shades))
        };
        let mut walls = vec![sponge.outside; above as usize];
        walls.extend((0..=sponge.levels).map(|i| wall(i.min(shades))));
        Self {
            middle: DVec3::new(sponge.x, sponge.y, sponge.z),
            side: MARGIN / sponge.zoom,
            levels: above + sponge.levels,
            cut: sponge.cut,
            closed: sponge.zoom > 1.0,
            walls,
            section: sponge.section,
        }
    }

    /// The value, and the colour of what has it.
    fn look(&self, at: DVec3) -> (f64, Colour) {
        let place = self.middle + self.side * at;
        // In cubes from -1 to 1.
        let mut best = ((2.0 * place).abs().max_element() - 1.0, self.walls[0]);
        let mut scale = 2.0;
        for wall in &self.walls[1..=self.levels as usize] {
            let turns = 0.5 * scale * place + 0.5;
            let within = (2.0 * (turns - turns.floor()) - 1.0).abs();
            let [x, y, z] = within.to_array();
            let bar = x.max(y).min(y.max(z)).min(z.max(x));
            let depth = (1.0 / 3.0 - bar) * 2.0 / scale;
            if depth > best.0 {
                best = (depth, *wall);
            }
            scale *= 3.0;
        }
        // A little off the middle: there the plane would pass through corners of the cubes.
        let above = (place.element_sum() - 0.0013) * (2.0 / 3.0_f64.sqrt());
        if self.cut && above > best.0 {
            best = (above, self.section);
        }
        let value = best.0 * 0.5 / self.side;
        // A window is closed where it cuts the sponge, just within the cube.
        let beyond = at.abs().max_element() - 0.4971;
        if self.closed && beyond > value {
            return (beyond, self.section);
        }
        (value, best.1)
    }
}

impl Field for Window {
    fn value(&self, at: DVec3) -> f64 {
        self.look(at).0
    }

    fn colour(&self, at: DVec3) -> [u8; 3] {
        self.look(at).1.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::contour::contour;
    use super::*;

    fn whole(levels: u32) -> Window {
        Window::new(&Sponge {
            levels,
            cut: false,
            ..Sponge::default()
        })
    }

    /// The naive twin: digits in base 3, of which no two may be 1 at one place.
    fn solid(place: DVec3, levels: u32) -> bool {
        let mut digits = place + 0.5;
        if digits.min_element() < 0.0 || digits.max_element() > 1.0 {
            return false;
        }
        (0..levels).all(|_| {
            digits *= 3.0;
            let ones = digits
                .to_array()
                .iter()
                .filter(|d| d.floor() == 1.0)
                .count();
            digits -= digits.floor();
            ones < 2
        })
    }

    proptest! {
        #[test]
        fn a_place_is_inside_where_its_digits_say(
            place in prop::array::uniform3(-0.55..0.55_f64), levels in 0..=5_u32
        ) {
            let (window, place) = (whole(levels), DVec3::from_array(place));
            let value = window.value(place / window.side);
            prop_assume!(value.abs() > 1e-12);
            prop_assert_eq!(value < 0.0, solid(place, levels));
        }

        #[test]
        fn the_value_never_changes_faster_than_the_place(
            a in prop::array::uniform3(-0.5..0.5_f64), step in prop::array::uniform3(-0.05..0.05_f64),
            levels in 0..=5_u32, cut in any::<bool>(), zoom in 1.0..20.0_f64
        ) {
            let (window, a, step) = (Window::new(&Sponge { levels, cut, zoom, ..Sponge::default() }), DVec3::from_array(a), DVec3::from_array(step));
            let change = (window.value(a + step) - window.value(a)).abs();
            prop_assert!(change <= step.length() * (1.0 + 1e-12) + 1e-15);
        }
    }

    #[test]
    fn a_window_on_a_corner_shows_the_whole_sponge_again() {
        let all = Window {
            side: 1.0,
            ..whole(3)
        };
        let part = Window {
            middle: DVec3::splat(-1.0 / 3.0),
            side: 1.0 / 3.0,
            levels: 4,
            walls: vec![Colour([0; 3]); 5],
            ..whole(3)
        };
        for i in 0..200 {
            let place =
                DVec3::new(f64::from(i % 7), f64::from(i % 11), f64::from(i % 13)) / 13.0 - 0.5;
            assert_eq!(
                all.value(place) < -1e-9,
                part.value(place) < -1e-9,
                "{place}"
            );
        }
    }

    #[test]
    fn a_deep_window_has_as_many_levels_as_the_whole() {
        let deep = Sponge {
            zoom: 100.0,
            x: -0.4,
            y: 0.4,
            z: 0.4,
            cut: false,
            ..Sponge::default()
        };
        assert_eq!(Window::new(&deep).levels, 4 + 4);
        let mesh = contour(&Window::new(&deep), 48);
        assert!(mesh.triangles.len() > 10_000);
    }
}
