//! Instances from front to back.
//!
//! What stands between the eye and a plane hides what stands beyond it, so a plane between two boxes
//! puts them in order. Where none is found, or where three hide each other in turn, instances are
//! *tangled*: drawn together, against depths.

use super::body::{Body, Order};
use crate::blob::Blob;
use crate::blob::format::MAX_INSTANCES;
use crate::camera::{Camera, ViewError};
use crate::q::Unit;
use crate::render::shadow::LightSpace;

/// A bit an instance.
type Set = u128;

const _: () = assert!(MAX_INSTANCES <= Set::BITS as usize);

/// The order in which a frame draws a blob's instances; about 13 kB.
#[derive(Clone, Debug)]
pub struct Arrangement {
    turns: [Turn; MAX_INSTANCES],
    count: usize,
    /// How many bits a side of the scene's cube has in a depth.
    unit: u32,
    bodies: [Body; MAX_INSTANCES],
    /// What must be drawn before each.
    before: [Set; MAX_INSTANCES],
    /// What each is tangled with.
    tangled: [Set; MAX_INSTANCES],
}

/// An instance's turn to be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// Its number in the blob.
    pub instance: u16,
    /// It is tangled with the ones before or after it, and to be drawn against depths.
    pub is_tangled: bool,
    /// It is the first of those that are tangled: what was drawn before hides them all.
    pub is_first: bool,
    /// It is the last of them, or not tangled.
    pub is_last: bool,
}

impl Turn {
    /// All zeros, so that a board's static costs no flash.
    const NONE: Self = Self {
        instance: 0,
        is_tangled: false,
        is_first: false,
        is_last: false,
    };
    /// Not tangled with others.
    const ALONE: Self = Self {
        is_last: true,
        ..Self::NONE
    };
}

/// The numbers in a set, in ascending order.
fn each(mut set: Set) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let first = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        first
    })
}

impl Arrangement {
    /// Nothing in view.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            turns: [Turn::NONE; MAX_INSTANCES],
            count: 0,
            unit: 0,
            bodies: [Body::NONE; MAX_INSTANCES],
            before: [0; MAX_INSTANCES],
            tangled: [0; MAX_INSTANCES],
        }
    }

    /// Finds what is in view and in which order it is drawn; `in_order` says that it matters.
    ///
    /// # Errors
    /// When the camera is none.
    pub fn arrange(
        &mut self,
        blob: &Blob<'_>,
        camera: &Camera,
        in_order: bool,
    ) -> Result<(), ViewError> {
        camera.check()?;
        self.count = 0;
        self.unit = 0;
        if blob.instance_count() == 1 {
            self.push(0, Turn::ALONE);
            return Ok(());
        }
        let (seen, farthest) = self.see(blob, camera);
        // W has 29 bits where it is largest; Q20 has 20 in a side.
        self.unit = (20 + 29u32)
            .saturating_sub(64 - farthest.leading_zeros())
            .min(30);
        if !in_order {
            for index in each(seen) {
                self.push(index, Turn::ALONE);
            }
            return Ok(());
        }
        self.put_in_order(seen);
        Ok(())
    }

    /// The same in the order in which a light towards `towards` meets all instances, seen by the camera or not, so
    /// that none shades an earlier one. What is tangled there is drawn by its middle: it shades what comes later
    /// alone.
    ///
    /// # Errors
    /// When the camera is none.
    pub fn arrange_in_light(
        &mut self,
        blob: &Blob<'_>,
        camera: &Camera,
        towards: [Unit; 3],
    ) -> Result<(), ViewError> {
        self.arrange(blob, camera, false)?;
        if blob.instance_count() > 1 {
            self.count = 0;
            let (seen, _) = self.see(blob, &LightSpace::towards(towards).eye());
            self.put_in_order(seen);
        }
        Ok(())
    }

    /// Compares these and takes them in their order.
    #[inline(never)]
    fn put_in_order(&mut self, seen: Set) {
        self.compare(seen);
        self.sort(seen);
    }

    /// The boxes of the instances that may be in the frame, and the depth of the farthest, Q20.
    #[inline(never)]
    fn see(&mut self, blob: &Blob<'_>, camera: &Camera) -> (Set, i64) {
        let mut seen: Set = 0;
        let mut farthest = 1;
        for index in 0..blob.instance_count() {
            let instance = blob.instance(index);
            let body = instance.and_then(|instance| {
                let object = blob.object(instance.object)?;
                Body::new(camera, &object, &instance)
            });
            if let (Some(body), Some(slot)) = (body, self.bodies.get_mut(usize::from(index))) {
                *slot = body;
                seen |= 1 << index;
                farthest = farthest.max(body.depths().1);
            }
        }
        (seen, farthest)
    }

    /// What is to be drawn, in this order.
    #[must_use]
    pub fn turns(&self) -> &[Turn] {
        self.turns.get(..self.count).unwrap_or_default()
    }

    /// The unit of all depths, as [`Placed::depth_factor`](super::Placed::depth_factor) takes it;
    /// `None` when there is one instance alone, whose own unit serves.
    #[must_use]
    pub fn unit(&self) -> Option<u32> {
        (self.unit > 0).then_some(self.unit)
    }

    fn push(&mut self, instance: usize, turn: Turn) {
        if let Some(slot) = self.turns.get_mut(self.count) {
            *slot = Turn {
                instance: instance as u16,
                ..turn
            };
            self.count += 1;
        }
    }

    fn body(&self, index: usize) -> &Body {
        self.bodies.get(index).unwrap_or(&Body::NONE)
    }

    /// Compares all that may overlap on the screen.
    fn compare(&mut self, seen: Set) {
        for index in each(seen) {
            if let Some(before) = self.before.get_mut(index) {
                *before = 0;
            }
            if let Some(tangled) = self.tangled.get_mut(index) {
                *tangled = 0;
            }
        }
        fn mark(sets: &mut [Set; MAX_INSTANCES], of: usize, other: usize) {
            if let Some(set) = sets.get_mut(of) {
                *set |= 1 << other;
            }
        }
        for a in each(seen) {
            for b in each(seen & (Set::MAX << a) & !(1 << a)) {
                match self.body(a).order(self.body(b)) {
                    Order::First => mark(&mut self.before, b, a),
                    Order::Second => mark(&mut self.before, a, b),
                    Order::Either => {}
                    Order::Tangled => {
                        mark(&mut self.tangled, a, b);
                        mark(&mut self.tangled, b, a);
                    }
                }
            }
        }
    }

    /// All that `set` is tangled with, directly or through others.
    fn knot(&self, set: Set) -> Set {
        let mut knot = set;
        loop {
            let more = each(knot).fold(knot, |all, i| {
                all | self.tangled.get(i).copied().unwrap_or(0)
            });
            if more == knot {
                return knot;
            }
            knot = more;
        }
    }

    /// Takes what nothing left must come before, again and again.
    fn sort(&mut self, seen: Set) {
        let mut left = seen;
        while left != 0 {
            let mut best: Option<Set> = None;
            let mut looked: Set = 0;
            for index in each(left) {
                if looked >> index & 1 == 1 {
                    continue;
                }
                let knot = self.knot(1 << index) & left;
                looked |= knot;
                let before =
                    each(knot).fold(0, |all, i| all | self.before.get(i).copied().unwrap_or(0));
                if before & left & !knot == 0 {
                    best = Some(knot);
                    break;
                }
            }
            // None: they hide each other in turn.
            let knot = best.unwrap_or(left);
            self.take(knot);
            left &= !knot;
        }
    }

    /// Draws these now, the nearest first.
    fn take(&mut self, knot: Set) {
        let is_tangled = knot.count_ones() > 1;
        let mut left = knot;
        while left != 0 {
            let nearest = each(left).min_by_key(|i| {
                let (near, far) = self.body(*i).depths();
                near + far
            });
            let Some(nearest) = nearest else {
                return;
            };
            let is_first = left == knot;
            left &= !(1 << nearest);
            self.push(
                nearest,
                Turn {
                    is_tangled,
                    is_first,
                    is_last: left == 0,
                    ..Turn::NONE
                },
            );
        }
    }
}
