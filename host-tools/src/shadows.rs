//! How near the shadows of a picture come to those of its reference.
//!
//! Whether a pixel lies in shadow is seen by comparing two pictures of the same view, with shadows and
//! without: what faces away from the light is dark in both. The reference's are ray-cast against the
//! original geometry.

use serde::Serialize;

use crate::failure::{Failure, Outcome};
use crate::picture::Picture;

/// A pixel lies in shadow when it is darker by more than this, of 255: by more than a step of the
/// panel's green.
const DARKER: u8 = 4;

/// The same view with shadows and without.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// With shadows.
    pub shadowed: &'a Picture,
    /// Without.
    pub lit: &'a Picture,
}

/// How many pixels are shaded wrongly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Wrong {
    /// Pixels that both pictures and references cover.
    pub covered: usize,
    /// Of these, those that lie in shadow in the reference.
    pub shadowed: usize,
    /// Dark, and lit in the reference.
    pub acne: usize,
    /// Lit, and dark in the reference.
    pub leaks: usize,
}

impl Wrong {
    /// Wrong ones of a hundred covered pixels.
    #[must_use]
    pub fn per_cent(&self) -> f64 {
        100.0 * (self.acne + self.leaks) as f64 / self.covered.max(1) as f64
    }
}

/// Compares the shadows of a picture with those of its reference; pixels of the colour `background` are
/// not covered.
///
/// # Errors
/// Exit 2 when the sizes differ.
pub fn compare(ours: Pair<'_>, theirs: Pair<'_>, background: [u8; 3]) -> Outcome<Wrong> {
    let pictures = [ours.shadowed, ours.lit, theirs.shadowed, theirs.lit];
    let size = |picture: &Picture| (picture.width, picture.height);
    if let Some(other) = pictures.iter().find(|p| size(p) != size(ours.shadowed)) {
        let ((w, h), (width, height)) = (size(other), size(ours.shadowed));
        return Err(Failure::input(format!(
            "pictures of {width}x{height} and {w}x{h} pixels cannot be compared"
        ))
        .help("draw all four with the same --size"));
    }
    let covers = |picture: &Picture, i: usize| match &picture.coverage {
        Some(coverage) => coverage[i] >= 128,
        None => picture.rgb[i] != background,
    };
    let dark = |pair: Pair<'_>, i: usize| {
        let channels = pair.lit.rgb[i].into_iter().zip(pair.shadowed.rgb[i]);
        let darker = channels.map(|(lit, shadowed)| lit.saturating_sub(shadowed));
        darker.max().unwrap_or(0) > DARKER
    };
    let mut wrong = Wrong::default();
    for i in 0..ours.shadowed.rgb.len() {
        if !pictures.iter().all(|picture| covers(picture, i)) {
            continue;
        }
        let (ours, theirs) = (dark(ours, i), dark(theirs, i));
        wrong.covered += 1;
        wrong.shadowed += usize::from(theirs);
        wrong.acne += usize::from(ours && !theirs);
        wrong.leaks += usize::from(!ours && theirs);
    }
    Ok(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(greys: [u8; 5]) -> Picture {
        Picture {
            width: 5,
            height: 1,
            rgb: greys.map(|grey| [grey; 3]).to_vec(),
            coverage: None,
            background: None,
        }
    }

    #[test]
    fn acne_is_dark_where_the_reference_is_lit_and_a_leak_the_opposite() {
        let lit = picture([0, 100, 100, 100, 100]);
        let (ours, theirs) = (
            picture([0, 25, 25, 100, 96]),
            picture([0, 25, 100, 25, 100]),
        );
        let pair = |shadowed| Pair {
            shadowed,
            lit: &lit,
        };
        let wrong = compare(pair(&ours), pair(&theirs), [0; 3]).unwrap();
        let expected = Wrong {
            covered: 4,
            shadowed: 2,
            acne: 1,
            leaks: 1,
        };
        assert_eq!(wrong, expected);
        assert!((wrong.per_cent() - 50.0).abs() < 1e-9);
    }

    #[test]
    fn pictures_of_other_sizes_are_refused() {
        let (a, mut b) = (picture([9; 5]), picture([9; 5]));
        b.width = 1;
        b.height = 5;
        let pair = |p| Pair {
            shadowed: p,
            lit: p,
        };
        let failure = compare(pair(&a), pair(&b), [0; 3]).unwrap_err();
        assert!(failure.message.contains("5x1"), "{failure}");
    }
}
