//! How near a picture comes to the ground truth.
//!
//! Which pixels count is said by the two silhouettes: that of the reference is where its
//! coverage is half or more, that of a picture where its coverage is half or more or, without
//! coverage, where it differs from the background. *Union* is either, *inside* is the
//! reference's silhouette eroded by 3x3 pixels, the border of the picture counting as outside.

use glam::DVec3;
use serde::Serialize;

use crate::depth::Depth;
use crate::failure::{Failure, Outcome};
use crate::picture::Picture;

/// What PSNR says of equal pictures, in decibels.
pub const EQUAL: f64 = 120.0;
/// The standard deviation of the SSIM window, in pixels.
const SIGMA: f64 = 1.5;
/// The SSIM window reaches this many pixels to each side: 11x11.
const REACH: i64 = 5;
/// A pixel leaks when its depth is off by more than this many cells.
const LEAK: f64 = 2.0;

/// Depths that tell leaks.
#[derive(Clone, Copy, Debug)]
pub struct Depths<'a> {
    /// Of the picture.
    pub picture: &'a Depth,
    /// Of the reference.
    pub reference: &'a Depth,
    /// The side of a cell, in cube units.
    pub cell: f64,
}

/// How near a picture comes to its reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Peak signal to noise over the union, in decibels: RGB 0 to 255, both before the background;
    /// [`EQUAL`] at most. `None` when there is no such pixel.
    pub psnr_union: Option<f64>,
    /// The same over the inside.
    pub psnr_inside: Option<f64>,
    /// Mean structural similarity of luma, 1 for equal pictures; see [`ssim`]. `None` when
    /// nothing is covered.
    pub ssim: Option<f64>,
    /// Intersection over union of the silhouettes, 1 when both are empty.
    pub iou: f64,
    /// Pixels of the inside that the picture leaves uncovered.
    pub holes: usize,
    /// Covered pixels of the inside whose depth is off by more than two cells; `None` when
    /// the depths are not known.
    pub leaks: Option<usize>,
    /// Pixels by set.
    pub pixels: Pixels,
}

/// How many pixels each set has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Pixels {
    /// In the picture's silhouette.
    pub picture: usize,
    /// In the reference's silhouette.
    pub reference: usize,
    /// In either.
    pub union: usize,
    /// In both.
    pub intersection: usize,
    /// In the reference's silhouette, eroded.
    pub inside: usize,
}

/// Compares a picture with its reference before a background.
///
/// # Errors
/// Exit 2 when the sizes differ, or the reference has no coverage.
pub fn compare(
    picture: &Picture,
    reference: &Picture,
    background: [u8; 3],
    depths: Option<Depths<'_>>,
) -> Outcome<Comparison> {
    let (width, height) = (reference.width, reference.height);
    let same = |what: &str, w: u32, h: u32| {
        if (w, h) == (width, height) {
            return Ok(());
        }
        Err(Failure::input(format!(
            "{what} has {w}x{h} pixels and the reference {width}x{height}"
        ))
        .help("draw both with the same --size"))
    };
    same("the picture", picture.width, picture.height)?;
    if let Some(depths) = &depths {
        same(
            "the depth of the picture",
            depths.picture.width,
            depths.picture.height,
        )?;
        same(
            "the depth of the reference",
            depths.reference.width,
            depths.reference.height,
        )?;
    }
    let theirs = silhouette(reference, background);
    let ours = silhouette(picture, background);
    let inside = eroded(&theirs, width as usize, height as usize);
    let union: Vec<bool> = theirs.iter().zip(&ours).map(|(a, b)| a | b).collect();
    let count = |set: &[bool]| set.iter().filter(|&&x| x).count();
    let both = theirs.iter().zip(&ours).filter(|(a, b)| **a && **b).count();
    let pixels = Pixels {
        picture: count(&ours),
        reference: count(&theirs),
        union: count(&union),
        intersection: both,
        inside: count(&inside),
    };
    let ours_rgb = before(picture, background);
    let theirs_rgb = &before(reference, background);
    let leaks = depths.map(|depths| {
        let values = depths.picture.values.iter().zip(&depths.reference.values);
        values
            .zip(inside.iter().zip(&ours))
            .filter(|((a, b), (inside, covered))| {
                let known = a.is_finite() && b.is_finite();
                **inside && **covered && known && (*a - *b).abs() > LEAK * depths.cell
            })
            .count()
    });
    Ok(Comparison {
        psnr_union: psnr(&ours_rgb, theirs_rgb, &union),
        psnr_inside: psnr(&ours_rgb, theirs_rgb, &inside),
        ssim: bounding_box(&union, width as usize)
            .map(|region| ssim(&ours_rgb, theirs_rgb, width as usize, region)),
        iou: if pixels.union == 0 {
            1.0
        } else {
            both as f64 / pixels.union as f64
        },
        holes: inside
            .iter()
            .zip(&ours)
            .filter(|(i, o)| **i && !**o)
            .count(),
        leaks,
        pixels,
    })
}

/// The covered pixels: those covered by half or more, or that differ from the background.
fn silhouette(picture: &Picture, background: [u8; 3]) -> Vec<bool> {
    match &picture.coverage {
        Some(coverage) => coverage.iter().map(|&c| c >= 128).collect(),
        None => picture.rgb.iter().map(|&c| c != background).collect(),
    }
}

/// The picture before a background, which it has already if it tells one or has no coverage.
fn before(picture: &Picture, background: [u8; 3]) -> Vec<[u8; 3]> {
    let (Some(coverage), None) = (&picture.coverage, picture.background) else {
        return picture.rgb.clone();
    };
    let part = |c: u8, behind: u8, coverage: u8| {
        let part = (u32::from(behind) * u32::from(255 - coverage) + 127) / 255;
        c.saturating_add(part as u8)
    };
    let pixels = picture.rgb.iter().zip(coverage);
    let [r, g, b] = background;
    pixels
        .map(|(&[pr, pg, pb], &a)| [part(pr, r, a), part(pg, g, a), part(pb, b, a)])
        .collect()
}

/// Pixels whose eight neighbours are all in the set too; beyond the border nothing is.
fn eroded(set: &[bool], width: usize, height: usize) -> Vec<bool> {
    let mut out = vec![false; set.len()];
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            out[y * width + x] =
                (y - 1..=y + 1).all(|y| set[y * width + x - 1..=y * width + x + 1] == [true; 3]);
        }
    }
    out
}

fn psnr(a: &[[u8; 3]], b: &[[u8; 3]], set: &[bool]) -> Option<f64> {
    let mut sum = 0u64;
    let mut pixels = 0u64;
    for ((a, b), _) in a.iter().zip(b).zip(set).filter(|(_, set)| **set) {
        pixels += 1;
        for (a, b) in a.iter().zip(b) {
            sum += u64::from(a.abs_diff(*b)).pow(2);
        }
    }
    if pixels == 0 {
        return None;
    }
    if sum == 0 {
        return Some(EQUAL);
    }
    let mean = sum as f64 / (3 * pixels) as f64;
    Some((10.0 * (255.0 * 255.0 / mean).log10()).min(EQUAL))
}

/// The smallest rectangle round the set: first column, first row, one past the last of each.
fn bounding_box(set: &[bool], width: usize) -> Option<[usize; 4]> {
    let covered = || set.iter().enumerate().filter(|(_, s)| **s).map(|(i, _)| i);
    let columns = || covered().map(|i| i % width);
    Some([
        columns().min()?,
        covered().next()? / width,
        columns().max()? + 1,
        covered().next_back()? / width + 1,
    ])
}

/// The mean structural similarity in a region, by the original definition (Wang, Bovik,
/// Sheikh and Simoncelli, 2004): luma (0.299 R + 0.587 G + 0.114 B), a Gaussian window of
/// 11x11 pixels with sigma 1.5, K1 = 0.01, K2 = 0.03, a range of 255.
///
/// There is one window round each pixel of the region `[left, top, right, bottom]` (the last
/// two excluded); windows reach beyond it, and beyond the picture all is black.
#[must_use]
pub fn ssim(a: &[[u8; 3]], b: &[[u8; 3]], width: usize, region: [usize; 4]) -> f64 {
    const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
    const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);
    let [left, top, right, bottom] = region;
    let luma = |c: &[u8; 3]| DVec3::from(c.map(f64::from)).dot(DVec3::new(0.299, 0.587, 0.114));
    let a: Vec<f64> = a.iter().map(luma).collect();
    let b: Vec<f64> = b.iter().map(luma).collect();
    let window = window();
    let height = a.len() / width;
    // The five moments, first weighted along the rows of the region and around it.
    let at = |set: &[f64], x: i64, y: usize| {
        usize::try_from(x)
            .ok()
            .filter(|&x| x < width)
            .map_or(0.0, |x| set[y * width + x])
    };
    let along = |x: usize, y: usize| {
        let mut sum = [0.0; 5];
        for (weight, dx) in window.iter().zip(-REACH..) {
            let column = x as i64 + dx;
            let (p, q) = (at(&a, column, y), at(&b, column, y));
            for (sum, moment) in sum.iter_mut().zip([p, q, p * p, q * q, p * q]) {
                *sum += weight * moment;
            }
        }
        sum
    };
    let first = top.saturating_sub(REACH as usize);
    let last = (bottom + REACH as usize).min(height);
    let columns = right - left;
    let rows: Vec<[f64; 5]> = (first..last)
        .flat_map(|y| (left..right).map(move |x| (x, y)))
        .map(|(x, y)| along(x, y))
        .collect();
    let mut total = 0.0;
    for y in top..bottom {
        for x in 0..columns {
            let mut m = [0.0; 5];
            for (weight, dy) in window.iter().zip(-REACH..) {
                let row = y as i64 + dy - first as i64;
                let Some(row) = usize::try_from(row).ok().filter(|&r| r < last - first) else {
                    continue;
                };
                for (sum, moment) in m.iter_mut().zip(rows[row * columns + x]) {
                    *sum += weight * moment;
                }
            }
            let [p, q, pp, qq, pq] = m;
            let (var_p, var_q, cov) = (pp - p * p, qq - q * q, pq - p * q);
            total += ((2.0 * p * q + C1) * (2.0 * cov + C2))
                / ((p * p + q * q + C1) * (var_p + var_q + C2));
        }
    }
    total / (columns * (bottom - top)) as f64
}

/// The Gaussian weights of one axis; their sum is 1.
fn window() -> [f64; 2 * REACH as usize + 1] {
    let mut window = [0.0; 2 * REACH as usize + 1];
    for (weight, d) in window.iter_mut().zip(-REACH..) {
        *weight = (-((d * d) as f64) / (2.0 * SIGMA * SIGMA)).exp();
    }
    let sum: f64 = window.iter().sum();
    window.map(|w| w / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of a colour on black, 20x20, from `from` to `to` on both axes.
    fn square(from: u32, to: u32, colour: [u8; 3]) -> Picture {
        let mut picture = Picture::filled(20, 20, [0; 3]);
        for y in from..to {
            for x in from..to {
                picture.rgb[(y * 20 + x) as usize] = colour;
            }
        }
        picture
    }

    fn with_coverage(mut picture: Picture) -> Picture {
        let covered = picture
            .rgb
            .iter()
            .map(|c| if *c == [0; 3] { 0 } else { 255 });
        picture.coverage = Some(covered.collect());
        picture
    }

    fn of(picture: &Picture, reference: &Picture) -> Comparison {
        compare(picture, reference, [0; 3], None).unwrap()
    }

    #[test]
    fn equal_pictures_are_equal_in_every_measure() {
        let picture = square(5, 15, [200, 100, 50]);
        let result = of(&picture, &with_coverage(picture.clone()));
        assert_eq!(result.psnr_union, Some(EQUAL));
        assert_eq!(result.psnr_inside, Some(EQUAL));
        assert!((result.ssim.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!((result.iou, result.holes, result.leaks), (1.0, 0, None));
        assert_eq!(result.pixels.inside, 64);
    }

    #[test]
    fn a_constant_difference_has_the_psnr_of_its_square() {
        let result = of(
            &square(5, 15, [110; 3]),
            &with_coverage(square(5, 15, [100; 3])),
        );
        let expected = 20.0 * (255.0f64 / 10.0).log10();
        assert!((result.psnr_union.unwrap() - expected).abs() < 1e-12);
        assert!((result.psnr_inside.unwrap() - expected).abs() < 1e-12);
    }

    #[test]
    fn silhouettes_give_union_and_intersection() {
        let result = of(
            &square(6, 16, [9; 3]),
            &with_coverage(square(5, 15, [9; 3])),
        );
        assert_eq!((result.pixels.union, result.pixels.intersection), (119, 81));
        assert!((result.iou - 81.0 / 119.0).abs() < 1e-12);
        // 64 pixels are inside; the picture lacks the first row and column of the silhouette,
        // which is border, so there is no hole.
        assert_eq!((result.pixels.inside, result.holes), (64, 0));
        assert_eq!(result.psnr_inside, Some(EQUAL));
    }

    #[test]
    fn holes_are_uncovered_pixels_inside_only() {
        let reference = with_coverage(square(5, 15, [200; 3]));
        let mut picture = square(5, 15, [200; 3]);
        picture.rgb[10 * 20 + 10] = [0; 3];
        picture.rgb[5 * 20 + 5] = [0; 3];
        let result = of(&picture, &reference);
        assert_eq!((result.holes, result.pixels.picture), (1, 98));
    }

    #[test]
    fn the_border_of_the_picture_is_outside() {
        let reference = with_coverage(square(0, 20, [1; 3]));
        assert_eq!(of(&reference, &reference).pixels.inside, 18 * 18);
    }

    #[test]
    fn half_coverage_counts_and_less_does_not() {
        let mut reference = with_coverage(square(5, 15, [200; 3]));
        let coverage = reference.coverage.as_mut().unwrap();
        // 13 and 12 of 25 rays, rounded.
        (coverage[105], coverage[106]) = (133, 122);
        assert_eq!(
            of(&square(5, 15, [200; 3]), &reference).pixels.reference,
            99
        );
    }

    #[test]
    fn another_background_is_not_covered_and_counts_as_black() {
        let reference = with_coverage(square(5, 15, [100; 3]));
        let mut picture = square(5, 15, [100; 3]);
        for c in &mut picture.rgb {
            if *c == [0; 3] {
                *c = [0, 0, 255];
            }
        }
        let result = compare(&picture, &reference, [0, 0, 255], None).unwrap();
        assert_eq!((result.psnr_union, result.iou), (Some(EQUAL), 1.0));
    }

    #[test]
    fn leaks_are_depths_off_by_more_than_two_cells() {
        let reference = with_coverage(square(5, 15, [100; 3]));
        let near = Depth {
            width: 20,
            height: 20,
            values: vec![2.0; 400],
        };
        let mut far = near.clone();
        far.values[10 * 20 + 10] = 2.021;
        far.values[10 * 20 + 11] = 2.019;
        far.values[10 * 20 + 12] = f64::INFINITY;
        far.values[5 * 20 + 5] = 9.0;
        let depths = Depths {
            picture: &far,
            reference: &near,
            cell: 0.01,
        };
        let result = compare(&reference, &reference, [0; 3], Some(depths)).unwrap();
        assert_eq!(result.leaks, Some(1));
    }

    #[test]
    fn nothing_at_all_is_not_a_number() {
        let empty = with_coverage(Picture::filled(4, 4, [0; 3]));
        let result = of(&empty, &empty);
        assert_eq!(
            (result.psnr_union, result.ssim, result.iou),
            (None, None, 1.0)
        );
        assert_eq!(
            of(
                &Picture::filled(1, 1, [0; 3]),
                &with_coverage(Picture::filled(1, 1, [9; 3]))
            )
            .iou,
            0.0
        );
    }

    #[test]
    fn different_sizes_are_refused() {
        let failure = compare(
            &Picture::filled(3, 4, [0; 3]),
            &Picture::filled(4, 4, [0; 3]),
            [0; 3],
            None,
        )
        .unwrap_err();
        assert!(failure.message.contains("3x4"), "{failure}");
    }

    #[test]
    fn ssim_of_two_flat_fields_is_that_of_their_means() {
        // Far from the borders only the means differ: (2pq + C1) / (p^2 + q^2 + C1).
        let (a, b) = (vec![[100; 3]; 41 * 41], vec![[120; 3]; 41 * 41]);
        let c1 = 2.55f64 * 2.55;
        let expected = (2.0 * 100.0 * 120.0 + c1) / (100.0 * 100.0 + 120.0 * 120.0 + c1);
        assert!((ssim(&a, &b, 41, [20, 20, 21, 21]) - expected).abs() < 1e-12);
    }

    #[test]
    fn ssim_is_the_plain_sum_over_the_window() {
        // Noise against noise, one window, by the definition with weights in two dimensions.
        let noise = |seed: u32| -> Vec<[u8; 3]> {
            (0..11 * 11u32)
                .map(|i| [((i * 7919 + seed).wrapping_mul(2_654_435_761) >> 24) as u8; 3])
                .collect()
        };
        let (a, b) = (noise(1), noise(1_000_003));
        let mut weights: Vec<f64> = (0..121)
            .map(|i| {
                let (x, y) = (f64::from(i % 11 - 5), f64::from(i / 11 - 5));
                (-(x * x + y * y) / 4.5).exp()
            })
            .collect();
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
        let mean = |f: &dyn Fn(usize) -> f64| -> f64 { (0..121).map(|i| weights[i] * f(i)).sum() };
        let (pa, pb) = (|i: usize| f64::from(a[i][0]), |i: usize| f64::from(b[i][0]));
        let (ma, mb) = (mean(&pa), mean(&pb));
        let va = mean(&|i| (pa(i) - ma).powi(2));
        let vb = mean(&|i| (pb(i) - mb).powi(2));
        let cov = mean(&|i| (pa(i) - ma) * (pb(i) - mb));
        let (c1, c2) = (2.55f64.powi(2), 7.65f64.powi(2));
        let expected =
            (2.0 * ma * mb + c1) * (2.0 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
        assert!((ssim(&a, &b, 11, [5, 5, 6, 6]) - expected).abs() < 1e-9);
    }
}
