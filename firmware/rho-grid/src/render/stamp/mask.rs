//! Which pixels a small disc holds, 4 x 4 or four times as many, from tables.
//!
//! A disc in space is an ellipse on the screen: as long as the disc is wide, and as broad as that
//! times the cosine `c` between its normal and the line of sight. Here it is the circle of its radius
//! cut by a strip: by two lines along the ellipse, `c` radii from its centre on either side.
//! That is exact seen from the front and from the edge, where silhouettes are decided, and a little
//! too full at the ellipse's ends between; in return no multiplication depends on the pixel.
//!
//! A mask has a bit a pixel: bit `4 y + x` for column x of row y. A larger disc has a mask for each of four tiles, two
//! beside and below each other.
//!
//! ```text
//! window   ROWS pixels high and wide (2, 3, 4, 8), the disc's centre within half a pixel of its middle
//! strip    half_planes[direction][t + h] and not half_planes[direction][t - h - 1]
//! circle   CIRCLES[level][place of the centre within a pixel]
//! ```

use super::entry;

/// Directions across the strip, half a turn in equal parts.
pub(super) const DIRECTIONS: usize = 16;

/// x and y of each direction in sixteenths; their lengths are 1 to a part in 30.
const AXES: [(i32, i32); DIRECTIONS] = [
    (16, 0),
    (16, 3),
    (15, 6),
    (13, 9),
    (11, 11),
    (9, 13),
    (6, 15),
    (3, 16),
    (0, 16),
    (-3, 16),
    (-6, 15),
    (-9, 13),
    (-11, 11),
    (-13, 9),
    (-15, 6),
    (-16, 3),
];

/// Places of a line, sixteenths of a pixel, of each direction.
const PLACES: usize = 288;
/// The line of place `ORIGIN` passes the first pixel's centre.
const ORIGIN: i32 = 128;

/// `[direction * PLACES + place]`: the pixels on one side of a line, those on it included.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const HALF_PLANES: [u16; DIRECTIONS * PLACES] = {
    let mut masks = [0; DIRECTIONS * PLACES];
    let mut d = 0;
    while d < DIRECTIONS {
        let (ax, ay) = AXES[d];
        let mut place = 0;
        while place < PLACES {
            let mut bit = 0;
            while bit < 16 {
                let along = (bit % 4) * ax + (bit / 4) * ay;
                if along <= place as i32 - ORIGIN {
                    masks[d * PLACES + place] |= 1 << bit;
                }
                bit += 1;
            }
            place += 1;
        }
        d += 1;
    }
    masks
};

/// A direction, ready to find a disc's strip.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Direction {
    /// y and x (the upper half) in sixteenths.
    across: u32,
    /// Index of the place of the window's own origin.
    base: u32,
}

/// Across a direction, of windows with two more pixels than this a row and a column.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const fn across(d: usize, rows: i32) -> Direction {
    let (ax, ay) = AXES[d];
    // The centre lies rows / 2 pixels beyond the first pixel's centre, and the part of a pixel that
    // is added when drawing.
    let base = d as i32 * PLACES as i32 + ORIGIN + (ax + ay) * rows / 2;
    Direction {
        across: (ay as u32).wrapping_add((ax as u32) << 16),
        base: base as u32,
    }
}

/// `[ROWS - 2][direction]`.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const WINDOWS: [[Direction; DIRECTIONS]; 3] = {
    let none = Direction { across: 0, base: 0 };
    let mut windows = [[none; DIRECTIONS]; 3];
    let mut rows = 0;
    while rows < 3 {
        let mut d = 0;
        while d < DIRECTIONS {
            windows[rows][d] = across(d, rows as i32);
            d += 1;
        }
        rows += 1;
    }
    windows
};

/// What finds strips: what is across each direction stands before all half planes.
#[repr(C)]
pub(super) struct Strips {
    pub(super) windows: [[Direction; DIRECTIONS]; 3],
    pub(super) half_planes: [u16; DIRECTIONS * PLACES],
}

pub(super) static STRIPS: Strips = Strips {
    windows: WINDOWS,
    half_planes: HALF_PLANES,
};

/// A direction, ready to find a large disc's strip in each of its tiles.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Wide {
    /// In the first tile.
    first: Direction,
    /// What the place of each tile's own origin is less.
    pub(super) shifts: [i16; TILES],
}

/// Tiles of a large disc.
pub(super) const TILES: usize = 4;

/// `[direction]`, of windows of 8 x 8 pixels.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
pub(super) static WIDE: [Wide; DIRECTIONS] = {
    let none = Wide {
        first: Direction { across: 0, base: 0 },
        shifts: [0; TILES],
    };
    let mut wide = [none; DIRECTIONS];
    let mut d = 0;
    while d < DIRECTIONS {
        let (ax, ay) = AXES[d];
        wide[d] = Wide {
            first: across(d, 6),
            shifts: [0, 4 * ax as i16, 4 * ay as i16, 4 * (ax + ay) as i16],
        };
        d += 1;
    }
    wide
};

/// Radii for which there are circles.
const LEVELS: usize = 66;
/// The least radius, 256 to the pixel; each level is a 27th larger than the one before.
const LEAST: u32 = 84;
/// The first level whose circle may hold three pixels a row, the first with four, and the first with eight: half a
/// pixel may be cut from the largest of four.
const THREES: usize = level_above(256);
const FOURS: usize = level_above(384);
const EIGHTS: usize = level_above(650);
/// The largest radius of a disc with one tile.
pub(super) const LARGEST_OF_FOUR: u32 = radius(EIGHTS - 1);
/// The largest radius that has a mask, 256 to the pixel.
pub(super) const LARGEST: u32 = radius(LEVELS - 1);

const fn radius(level: usize) -> u32 {
    // 2^16 to the pixel on the way.
    let mut r = LEAST << 8;
    let mut l = 0;
    while l < level {
        r += r / 27;
        l += 1;
    }
    r >> 8
}

const fn level_above(r: u32) -> usize {
    let mut level = 0;
    while radius(level) < r {
        level += 1;
    }
    level
}

/// Whether the window's pixel is within the circle; all in 2^-9 pixels.
const fn is_within(radius: u32, centre: (i32, i32), pixel: (i32, i32)) -> bool {
    let (dx, dy) = (pixel.0 * 512 - centre.0, pixel.1 * 512 - centre.1);
    dx * dx + dy * dy <= (4 * radius * radius) as i32
}

/// The mask of a circle in a window with so many rows, when its centre is at `place` of `parts` x `parts` within a
/// pixel: of the 4 x 4 pixels that begin at `first`.
const fn circle(radius: u32, rows: i32, parts: i32, place: i32, first: (i32, i32)) -> u16 {
    let step = 512 / parts;
    let centre = (
        (rows - 2) * 256 + place % parts * step + step / 2,
        (rows - 2) * 256 + place / parts * step + step / 2,
    );
    let mut mask = 0;
    let mut bit = 0;
    while bit < 16 {
        let pixel = (first.0 + bit % 4, first.1 + bit / 4);
        if pixel.0 < rows && pixel.1 < rows && is_within(radius, centre, pixel) {
            mask |= 1 << bit;
        }
        bit += 1;
    }
    mask
}

/// Circles of two rows, at 16 x 16 places: their pixels are few, so that places count.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static SMALL: [[u8; 256]; THREES] = {
    let mut masks = [[0; 256]; THREES];
    let mut level = 0;
    while level < THREES {
        let radius = radius(level);
        let mut place = 0;
        while place < 256 {
            masks[level][place] = circle(radius, 2, 16, place as i32, (0, 0)) as u8;
            place += 1;
        }
        level += 1;
    }
    masks
};

/// Larger circles, at 8 x 8 places.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static LARGE: [[u16; 64]; EIGHTS - THREES] = {
    let mut masks = [[0; 64]; EIGHTS - THREES];
    let mut level = THREES;
    while level < EIGHTS {
        let rows = if level < FOURS { 3 } else { 4 };
        let radius = radius(level);
        let mut place = 0;
        while place < 64 {
            masks[level - THREES][place] = circle(radius, rows, 8, place as i32, (0, 0));
            place += 1;
        }
        level += 1;
    }
    masks
};

/// The four tiles of the largest.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static TILED: [[[u16; 64]; TILES]; LEVELS - EIGHTS] = {
    let mut masks = [[[0; 64]; TILES]; LEVELS - EIGHTS];
    let mut level = EIGHTS;
    while level < LEVELS {
        let radius = radius(level);
        let mut tile = 0;
        while tile < TILES {
            let first = (tile as i32 % 2 * 4, tile as i32 / 2 * 4);
            let mut place = 0;
            while place < 64 {
                masks[level - EIGHTS][tile][place] = circle(radius, 8, 8, place as i32, first);
                place += 1;
            }
            tile += 1;
        }
        level += 1;
    }
    masks
};

/// `[radius / 4]` (256 to the pixel): the level of the nearest radius.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static LEVEL_OF: [u8; LARGEST as usize / 4 + 1] = {
    let mut levels = [0; LARGEST as usize / 4 + 1];
    let (mut i, mut level) = (0, 0);
    while i < levels.len() {
        let r = i as u32 * 4 + 2;
        while level + 1 < LEVELS && (radius(level) + radius(level + 1)) / 2 < r {
            level += 1;
        }
        levels[i] = level as u8;
        i += 1;
    }
    levels
};

/// The circle of discs of one radius.
#[derive(Clone, Copy, Debug)]
pub(super) enum Circle {
    /// Two rows at most.
    Two(&'static [u8; 256]),
    /// Three.
    Three(&'static [u16; 64]),
    /// Four.
    Four(&'static [u16; 64]),
    /// Eight, in four tiles.
    Eight(&'static [[u16; 64]; TILES]),
}

impl Circle {
    /// The least.
    #[allow(clippy::indexing_slicing, reason = "evaluated by the compiler")]
    pub(super) const LEAST: Self = Self::Two(&SMALL[0]);

    /// Rows and columns of its window: its centre lies half as many pixels from the window's edge, and a
    /// part of a pixel.
    #[inline(always)]
    pub(super) fn rows(self) -> usize {
        match self {
            Self::Two(_) => 2,
            Self::Three(_) => 3,
            Self::Four(_) => 4,
            Self::Eight(_) => 8,
        }
    }

    /// Those of strips in its window, if that is one tile.
    #[inline(always)]
    pub(super) fn directions(self) -> &'static [Direction; DIRECTIONS] {
        let [two, three, four] = &STRIPS.windows;
        match self {
            Self::Two(_) => two,
            Self::Three(_) => three,
            Self::Four(_) | Self::Eight(_) => four,
        }
    }

    /// The mask at the centre `parts`: its part of a pixel beyond that, 1024 to the pixel, x in the
    /// lower half and y in the upper. Of several tiles, that of the first.
    #[inline(always)]
    fn mask(self, parts: u32) -> u32 {
        match self {
            // Four bits of each.
            Self::Two(table) => {
                let place = parts >> 6 & 15 | (parts >> 22 & 15) << 4;
                u32::from(entry(table, place))
            }
            Self::Three(table) | Self::Four(table) | Self::Eight([table, ..]) => {
                u32::from(entry(table, eighths(parts)))
            }
        }
    }

    /// For a radius of `r` (256 to the pixel); `None` when it is above [`LARGEST`].
    pub(super) fn of(r: u32) -> Option<Self> {
        let level = usize::from(*LEVEL_OF.get(r as usize / 4)?);
        if level < THREES {
            return SMALL.get(level).map(Self::Two);
        }
        if level >= EIGHTS {
            return TILED.get(level - EIGHTS).map(Self::Eight);
        }
        let circle = LARGE.get(level - THREES)?;
        Some(if level < FOURS {
            Self::Three(circle)
        } else {
            Self::Four(circle)
        })
    }
}

/// Three bits of each of two parts.
#[inline(always)]
fn eighths(parts: u32) -> u32 {
    parts >> 7 & 7 | (parts >> 23 & 7) << 3
}

impl Direction {
    /// The strip of this half width in sixteenths of a pixel, its place less by `shift`.
    #[inline(always)]
    fn strip(self, parts: u32, half: u32, shift: u32) -> u32 {
        // x ax + y ay in the upper half: the lower one, x ay, is not negative and does not reach it.
        // Rounded to sixteenths.
        let along = parts.wrapping_mul(self.across).wrapping_add(1 << 25) as i32 >> 26;
        let place = self.base.wrapping_add(along as u32).wrapping_sub(shift);
        let beyond = |place: u32| STRIPS.half_planes.get(place as usize).copied().unwrap_or(0);
        u32::from(beyond(place.wrapping_add(half)))
            & !u32::from(beyond(place.wrapping_sub(half).wrapping_sub(1)))
    }
}

/// The mask of a disc of one tile: `parts` as [`Circle::mask`] has them, `direction` that of its normal on the
/// screen, `half` the strip's half width in sixteenths of a pixel.
#[inline(always)]
pub(super) fn disc(circle: Circle, parts: u32, direction: u32, half: u32) -> u32 {
    let direction = entry(circle.directions(), direction);
    circle.mask(parts) & direction.strip(parts, half, 0)
}

/// The masks of a large disc's tiles.
pub(super) fn tiles(
    circles: &[[u16; 64]; TILES],
    parts: u32,
    direction: u32,
    half: u32,
) -> [u32; TILES] {
    let Wide { first, shifts } = entry(&WIDE, direction);
    let [a, b, c, d] = circles;
    let [e, f, g, h] = shifts.map(|shift| i32::from(shift) as u32);
    [(a, e), (b, f), (c, g), (d, h)].map(|(circle, shift)| {
        u32::from(entry(circle, eighths(parts))) & first.strip(parts, half, shift)
    })
}

/// The index of the direction nearest to (x, y) or its opposite; (0, 0) gives one too.
pub(super) const fn direction(x: i32, y: i32) -> u32 {
    let (ax, ay) = (x.unsigned_abs(), y.unsigned_abs());
    let (large, small) = if ax >= ay { (ax, ay) } else { (ay, ax) };
    // The tangents of 1, 3, 5 and 7 sixteenths of a quarter turn, times 256.
    let tangent = (small << 8) / if large == 0 { 1 } else { large };
    let eighth = match tangent {
        0..25 => 0,
        25..78 => 1,
        78..137 => 2,
        137..210 => 3,
        _ => 4,
    };
    let quarter = if ax >= ay { eighth } else { 8 - eighth };
    let opposite = (x ^ y) < 0;
    if opposite {
        (16 - quarter) % 16
    } else {
        quarter
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use proptest::prelude::*;

    /// Whether a disc holds a pixel of its window.
    fn holds(circle: Circle, parts: u32, direction: u32, half: u32, (x, y): (u32, u32)) -> bool {
        let mask = match circle {
            Circle::Eight(circles) => {
                tiles(circles, parts, direction, half)[(x / 4 + y / 4 * 2) as usize]
            }
            _ => disc(circle, parts, direction, half),
        };
        mask >> (x % 4 + y % 4 * 4) & 1 == 1
    }

    #[test]
    fn directions_are_found_to_half_a_step() {
        for degrees in 0..720 {
            let angle = f64::from(degrees).to_radians() / 2.0;
            let found = direction((angle.cos() * 1e4) as i32, (angle.sin() * 1e4) as i32);
            let exact = angle / std::f64::consts::PI * 16.0;
            let off = (exact - f64::from(found)).rem_euclid(16.0);
            assert!(off.min(16.0 - off) < 0.53, "{degrees}: {found} {exact}");
        }
    }

    proptest! {
        #[test]
        fn a_mask_holds_the_pixels_of_circle_and_strip_but_those_near_their_edges(
            r in 80..LARGEST, x in 0..1024u32, y in 0..1024u32,
            d in 0..16u32, part in 0.0..1.0f64
        ) {
            let radius = f64::from(r) / 256.0;
            let half = part * radius;
            let circle = Circle::of(r).unwrap();
            let rows = circle.rows() as u32;
            let angle = f64::from(d) / 16.0 * std::f64::consts::PI;
            for (px, py) in (0..rows).flat_map(|y| (0..rows).map(move |x| (x, y))) {
                // From the disc's centre to the pixel's.
                let middle = (f64::from(rows) - 2.0) / 2.0;
                let dx = f64::from(px) - middle - f64::from(x) / 1024.0;
                let dy = f64::from(py) - middle - f64::from(y) / 1024.0;
                let across = (dx * angle.cos() + dy * angle.sin()).abs();
                let inside = half - across;
                let inside = inside.min(radius - dx.hypot(dy));
                let set = holds(circle, x | y << 16, d, (half * 16.0) as u32, (px, py));
                // A part of a pixel, and a part of the size.
                let near = 0.14 + 0.05 * radius;
                prop_assert!(inside.abs() < near || set == (inside > 0.0),
                    "{px} {py} {set} {inside}");
            }
        }
    }
}
