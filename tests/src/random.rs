//! Numbers that look random and are the same on every machine, and views made of them.

use host_tools::view::{StandardView, View};

/// A sequence of numbers that its seed decides (Steele, Lea and Flood, Fast Splittable
/// Pseudorandom Number Generators, 2014: SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between two numbers, all equally likely.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Between two positive numbers, every factor equally likely.
    pub fn between_by_factor(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// The standard scene seen from any side, at a distance.
    ///
    /// The distance is rounded to the step in which a device takes it, so that all that look
    /// at the view stand at the same place, however near and large the picture is.
    pub fn side(&mut self, distance: f64) -> View {
        View {
            yaw: self.between(-180.0, 180.0),
            pitch: self.between(-90.0, 90.0),
            distance: (distance * f64::from(1 << 20)).round() / f64::from(1 << 20),
            ..StandardView::Near.into()
        }
    }

    /// Any view: near and far, wide and narrow, large and small.
    pub fn view(&mut self) -> View {
        let distance = self.between_by_factor(0.02, 30.0);
        View {
            zoom: self.between_by_factor(0.3, 200.0),
            fov: self.between(10.0, 120.0),
            width: self.between(1.0, 240.9) as u16,
            height: self.between(1.0, 320.9) as u16,
            ..self.side(distance)
        }
    }
}
