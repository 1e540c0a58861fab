//! A surface as the zeros of a function: what an implicit object has to tell.

use glam::DVec3;

/// A function of space, negative inside, positive outside, zero on the surface.
///
/// It is a bound on distances: nowhere does it change faster than one unit a unit (its
/// Lipschitz constant is 1), so a ball of radius |value| about a place holds no zero (Hart
/// 1996, *Sphere tracing*, theorem 1). Everything asked of an implicit object rests on that,
/// and on nothing else.
pub(super) trait Field: Sync {
    /// The value at a place; both in cube units.
    fn value(&self, at: DVec3) -> f64;

    /// The colour of the surface near a place.
    fn colour(&self, at: DVec3) -> [u8; 3];

    /// How the value rises: its direction is the normal, its length at most 1.
    ///
    /// By four differences (along the corners of a tetrahedron), whose error is the step times
    /// the curvature.
    fn gradient(&self, at: DVec3) -> DVec3 {
        /// Far below a cell, far above the rounding of values.
        const STEP: f64 = 1e-7;
        const CORNERS: [DVec3; 4] = [
            DVec3::new(1.0, -1.0, -1.0),
            DVec3::new(-1.0, -1.0, 1.0),
            DVec3::new(-1.0, 1.0, -1.0),
            DVec3::new(1.0, 1.0, 1.0),
        ];
        let rise = |corner: DVec3| corner * self.value(at + STEP * corner);
        CORNERS.map(rise).into_iter().sum::<DVec3>() / (4.0 * STEP)
    }

    /// The direction in which the value rises, of length 1: on the surface, its normal.
    fn normal(&self, at: DVec3) -> DVec3 {
        self.gradient(at).normalize_or(DVec3::Y)
    }

    /// A zero near a place: where the value is the distance, the nearest. `None` if none is
    /// found.
    ///
    /// Newton's steps along the gradient; where that is short, the value's own length, by which
    /// no zero is stepped over.
    fn zero_near(&self, from: DVec3) -> Option<DVec3> {
        const STEPS: u32 = 64;
        /// A millionth of a cell at 1,000 cells an axis.
        const ON: f64 = 1e-9;
        let mut at = from;
        for _ in 0..STEPS {
            let value = self.value(at);
            if value.abs() <= ON {
                return Some(at);
            }
            let gradient = self.gradient(at);
            let length = gradient.length();
            at -= value * gradient
                / if length > 0.5 {
                    length * length
                } else {
                    length.max(1e-9)
                };
        }
        None
    }
}
