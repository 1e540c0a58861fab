//! Where cells of the walk are on the screen.

use super::Walk;
use crate::reciprocal::Reciprocal;
use crate::render::footprint::Pixels;
use crate::render::project::{Bounds, Homogeneous, OverW};
use crate::render::view::{Half, LevelView};
use crate::render::visibility::{Rect, Visibility};
use crate::shading::Shade;

impl<V: Visibility, S: Shade> Walk<'_, '_, V, S> {
    /// Q8 from the optical axis.
    #[inline(always)]
    pub(super) fn on_screen<R: Reciprocal>(&self, p: Homogeneous) -> (i32, i32) {
        let over = OverW::new::<R>(p.w, self.view.k);
        (over.times(p.x), over.times(p.y))
    }

    /// Where the optical axis meets the frame, Q8.
    #[inline(always)]
    pub(super) fn middle(&self) -> (i32, i32) {
        (self.view.width << 7, self.view.height << 7)
    }

    #[inline(always)]
    pub(super) fn bounds(&self, x: i32, y: i32, half: Half) -> Bounds {
        let (mx, my) = self.middle();
        Bounds {
            x: x + mx,
            y: y + my,
            half_x: half.x,
            half_y: half.y,
        }
    }

    /// Whether no stamp of `block`, whose half extents are below 2^16, has pixels beyond the frame's edge, if
    /// discs reach `beyond` it (Q8) at most.
    pub(super) fn is_within_frame(&self, block: &Bounds, beyond: i32) -> bool {
        let within = |centre: i32, half: i32, side: i32| {
            // A window ends three pixels beyond its disc's centre.
            let reach = half + beyond + (3 << 8);
            centre >= reach && reach < (side << 8) - centre
        };
        within(block.x, block.half_x, self.view.width)
            && within(block.y, block.half_y, self.view.height)
    }

    /// Whether no sample of these half extents within `block` reaches the frame's edge or beyond
    /// `rows`, with two pixels to spare for the largest splat's rounding.
    pub(super) fn is_inside(&self, block: &Bounds, samples: Half, rows: (i32, i32)) -> bool {
        let within = |centre: i32, half: i32, (first, end): (i32, i32)| {
            let reach = half + 4 * samples.x.max(samples.y) + 512;
            centre - reach >= first << 8 && centre + reach < end << 8
        };
        within(block.x, block.half_x, (0, self.view.width)) && within(block.y, block.half_y, rows)
    }

    /// The part of `pixels` within the rows of the frame that are drawn.
    #[inline(always)]
    pub(super) fn clip(&self, pixels: Pixels) -> Option<Rect> {
        let (x0, x1) = (pixels.x.0.max(0), pixels.x.1.min(self.view.width - 1));
        let (first, end) = self.view.rows;
        let (y0, y1) = (pixels.y.0.max(first), pixels.y.1.min(end - 1));
        Pixels {
            x: (x0, x1),
            y: (y0, y1),
        }
        .rect()
    }

    /// Bounds of a cell near the eye, which may be in it; `None` when it is behind.
    ///
    /// Where the whole cell can be projected, its own extent bounds it. Nearer than that X and W range
    /// independently, W from the eye's plane on: wider than exact, and never too narrow.
    #[cold]
    pub(super) fn near_bounds<R: Reciprocal>(
        &self,
        centre: Homogeneous,
        level: &LevelView,
    ) -> Option<Bounds> {
        let w = (centre.w - level.half.w, centre.w + level.half.w);
        if w.1 < 1 {
            return None;
        }
        let nearest = w.0;
        let w = (w.0.max(1), w.1);
        let exact = (nearest >= self.view.near).then(|| {
            let (x, y) = self.on_screen::<R>(centre);
            let half = self.view.half::<R>(level, [x, y], Half::default(), nearest);
            (x, y, half)
        });
        if let Some((x, y, half)) = exact
            && nearest >= 3 * level.half.w
        {
            return Some(self.bounds(x, y, half));
        }
        let mut x = self.interval(centre.x, level.half.x, w);
        let mut y = self.interval(centre.y, level.half.y, w);
        if let Some((at_x, at_y, half)) = exact {
            let both = |a: (i32, i32), at: i32, half: i32| (a.0.max(at - half), a.1.min(at + half));
            x = both(x, at_x, half.x);
            y = both(y, at_y, half.y);
        }
        let middle = |(low, high): (i32, i32)| (low + high) >> 1;
        let (mx, my) = (middle(x), middle(y));
        let half = Half {
            x: x.1 - mx,
            y: y.1 - my,
        };
        Some(self.bounds(mx, my, half))
    }

    /// First and last, Q8, of (v - half ..= v + half) / w, cut at 2^20 pixels.
    pub(super) fn interval(&self, v: i32, half: i32, w: (i32, i32)) -> (i32, i32) {
        let over = |v: i32, w: i32| {
            // Q8 = X / W * 2^(30 - k)
            let k = self.view.k;
            let v = i64::from(v) << 30u32.saturating_sub(k);
            let w = i64::from(w) << k.saturating_sub(30);
            (v / w.max(1)).clamp(-(1 << 28), 1 << 28) as i32
        };
        let (low, high) = (v - half, v + half);
        (
            over(low, if low < 0 { w.0 } else { w.1 }) - 1,
            over(high, if high > 0 { w.0 } else { w.1 }) + 1,
        )
    }
}
