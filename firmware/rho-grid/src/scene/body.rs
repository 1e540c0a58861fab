//! The box of an instance in eye space, and which of two boxes is in front.

use crate::blob::{Instance, Object};
use crate::camera::Camera;
use crate::q::Place;

/// Where a point of the scene is in eye space, Q40.
pub(super) fn place(camera: &Camera, point: &[Place; 3]) -> [i64; 3] {
    let mut eye = [0; 3];
    for ((eye, row), t) in eye.iter_mut().zip(&camera.rotation).zip(camera.translation) {
        let along = row.iter().zip(point);
        // Q60 to Q40 before they are added.
        let sum: i64 = along
            .map(|(r, p)| (i64::from(r.to_bits()) * i64::from(p.to_bits())) >> 20)
            .sum();
        *eye = sum + (i64::from(t.to_bits()) << 20);
    }
    eye
}

/// How many cells an axis an instance needs for those nearest to the eye to be at most four and a half
/// pixels large: from four on they are drawn as ellipses, which cost ten times what stamps do, but little
/// of a box is as near as its nearest corner. Of what is nearer than a fourth of its farthest point
/// only a small part is near.
pub(super) fn cells(camera: &Camera, object: &Object, instance: &Instance) -> u32 {
    // In eighths of a pixel.
    const LARGEST: i64 = 36;
    let Some(body) = Body::new(camera, object, instance) else {
        return 0;
    };
    let (near, far) = body.depths();
    let near = near.max(far / 4).max(1);
    // Pixels Q12 times Q20 over Q20: a side at that depth.
    let side = i64::from(camera.focal.to_bits()) * (i64::from(instance.scale.to_bits()) >> 10);
    u32::try_from((side / near) / (LARGEST << 9)).unwrap_or(u32::MAX)
}

/// How far boxes may reach into each other and still count as apart, Q20: a thousandth of the
/// scene, which is less than half a pixel where the whole scene is in view.
const TOUCH: i64 = 1 << 10;

/// A box in eye space. Lengths are sides of the scene's cube, Q20.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    centre: [i32; 3],
    /// Its own x, y, z in eye space, of length 1, Q14.
    axes: [[i16; 3]; 3],
    /// Half its extents along them.
    half: [i32; 3],
    /// First and last column and row that it may reach, in 2^-16 of the focal length from the axis.
    window: [i32; 4],
}

/// How two boxes stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// The first hides the second, if any does.
    First,
    /// The second hides the first, if any does.
    Second,
    /// Neither.
    Either,
    /// No plane was found between them.
    Tangled,
}

impl Body {
    pub(super) const NONE: Self = Self {
        centre: [0; 3],
        axes: [[0; 3]; 3],
        half: [0; 3],
        window: [0; 4],
    };

    /// The box of an instance, if some of it may be in the frame.
    pub(super) fn new(camera: &Camera, object: &Object, instance: &Instance) -> Option<Self> {
        let turned = super::turned(&camera.rotation, &instance.rotation);
        let scale = i64::from(instance.scale.to_bits());
        let [low, high] = object
            .bounds
            .map(|corner| corner.map(|v| i64::from(v.to_bits())));
        let mut centre = place(camera, &instance.translation);
        let mut body = Self::NONE;
        for (k, ((low, high), half)) in low.iter().zip(&high).zip(&mut body.half).enumerate() {
            // Twice the middle, Q16, times the scale: Q46.
            let middle = ((low + high) * scale) >> 16;
            for (centre, row) in centre.iter_mut().zip(&turned) {
                let entry = row.get(k).map_or(0, |v| i64::from(v.to_bits()));
                // Q30 and Q30 to Q40.
                *centre += (middle * entry) >> 20;
            }
            *half = (((high - low) * scale) >> 26) as i32 + 1;
        }
        for (axis, k) in body.axes.iter_mut().zip(0..) {
            for (to, row) in axis.iter_mut().zip(&turned) {
                *to = row
                    .get(k)
                    .map_or(0, |v: &crate::q::Rotation| (v.to_bits() >> 16) as i16);
            }
        }
        for (to, from) in body.centre.iter_mut().zip(centre) {
            *to = i32::try_from(from >> 20).ok()?;
        }
        body.window = body.window(camera)?;
        Some(body)
    }

    /// Its distance along the optical axis, nearest and farthest.
    pub(super) fn depths(&self) -> (i64, i64) {
        let [.., z] = self.centre;
        let reach = self.reach([0, 0, 1 << 14]) >> 14;
        (-i64::from(z) - reach, -i64::from(z) + reach)
    }

    /// Half its extent along a direction of Q14, Q34.
    fn reach(&self, direction: [i32; 3]) -> i64 {
        let axes = self.axes.iter().zip(self.half);
        axes.map(|(axis, half)| {
            let [x, y, z] = axis.map(i64::from);
            let [dx, dy, dz] = direction.map(i64::from);
            // Q28 to Q14, rounded up.
            let along = ((x * dx + y * dy + z * dz).abs() >> 14) + 1;
            along * i64::from(half)
        })
        .sum()
    }

    /// Where its centre is along a direction of Q14, Q34.
    fn along(&self, direction: [i32; 3]) -> i64 {
        let parts = self.centre.iter().zip(direction);
        parts.map(|(c, d)| i64::from(*c) * i64::from(d)).sum()
    }

    /// The columns and rows that it may reach; `None` when they are outside the frame.
    ///
    /// Discs reach beyond the surface: an eighth of the box's extent and two pixels are added.
    fn window(&self, camera: &Camera) -> Option<[i32; 4]> {
        let (near, far) = self.depths();
        if far <= 0 {
            return None;
        }
        let [x, y, _] = self.centre.map(i64::from);
        let extent = |direction| {
            let reach = self.reach(direction) >> 14;
            reach + (reach >> 3)
        };
        let near = near - ((far - near) >> 4);
        let over = |v: i64| {
            let limit = 1 << 30;
            let of = |depth: i64| ((v << 16) / depth.max(1)).clamp(-limit, limit);
            let (a, b) = (of(near.max(1)), of(far));
            (a.min(b) as i32, a.max(b) as i32)
        };
        let span = |at: i64, reach: i64| (over(at - reach).0, over(at + reach).1);
        let (left, right) = span(x, extent([1 << 14, 0, 0]));
        let (top, bottom) = span(-y, extent([0, 1 << 14, 0]));
        // Pixels over the focal length, Q16: Q28 over Q12.
        let focal = i64::from(camera.focal.to_bits()).max(1);
        let edge = |side: u16| ((i64::from(side) / 2 + 3) << 28) / focal;
        let (w, h) = (edge(camera.width), edge(camera.height));
        let inside =
            |low: i32, high: i32, edge: i64| i64::from(low) <= edge && i64::from(high) >= -edge;
        (inside(left, right, w) && inside(top, bottom, h)).then_some([left, right, top, bottom])
    }

    /// Which of the two is in front.
    ///
    /// A plane between two boxes, if there is one, is nearly always parallel to a face of one of
    /// them: those are tried, and planes across the optical axis. What is on the eye's side of it
    /// hides what is beyond. (Planes through two edges are not tried.)
    pub(super) fn order(&self, other: &Self) -> Order {
        let [l, r, t, b] = self.window;
        let [ol, or, ot, ob] = other.window;
        if r < ol || or < l || b < ot || ob < t {
            return Order::Either;
        }
        let axes = self.axes.iter().chain(&other.axes);
        let across = [0, 0, 1 << 14];
        for direction in axes.map(|a| a.map(i32::from)).chain([across]) {
            let (here, there) = (self.along(direction), other.along(direction));
            let reach = self.reach(direction) + other.reach(direction);
            if (here - there).abs() + (TOUCH << 14) < reach {
                continue;
            }
            // The plane halfway between the two faces; the eye is at 0.
            let (low, high) = if here < there {
                (self, other)
            } else {
                (other, self)
            };
            let upper = low.along(direction) + low.reach(direction);
            let lower = high.along(direction) - high.reach(direction);
            let low_is_first = upper.midpoint(lower) > 0;
            return if low_is_first == (here < there) {
                Order::First
            } else {
                Order::Second
            };
        }
        Order::Tangled
    }
}
