//! `rho compare`: how near a picture comes to the ground truth.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use crate::compare::{self, Comparison, Depths};
use crate::depth::Depth;
use crate::failure::{Failure, Outcome};
use crate::picture::Picture;
use crate::shadows::{self, Pair, Wrong};

const EXAMPLES: &str = "\
Examples:
  rho compare frame.png truth.png
  rho compare frame.png truth.png --min-iou 0.98 --min-psnr-inside 30 --max-holes 0
  rho compare frame.png truth.png --depth d.png --reference-depth t.png --cells 243 --json
  rho compare shadowed.png shadowed-truth.png --lit frame.png --reference-lit truth.png

A pixel of REFERENCE is covered when its alpha is half or more; a pixel of PICTURE too, or,
when it has no alpha, when it differs from the background. SSIM is that of 2004: Gaussian
windows of 11x11 with sigma 1.5 over luma. Exit code 1 when a limit is broken.";

/// Compare a picture with its reference
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Compare {
    /// A PNG, such as one that `rho render` or `rho run` wrote
    pub picture: PathBuf,
    /// A PNG that `rho reference` wrote
    pub reference: PathBuf,
    /// What an uncovered pixel of PICTURE looks like; without it, what its PNG says, or black
    #[arg(long, value_name = "RRGGBB")]
    pub background: Option<Colour>,
    /// The depth of PICTURE, to count leaks
    #[arg(long, value_name = "P.png", requires_all = ["reference_depth", "cells"])]
    pub depth: Option<PathBuf>,
    /// The depth of REFERENCE
    #[arg(long, value_name = "R.png", requires = "depth")]
    pub reference_depth: Option<PathBuf>,
    /// Cells along a side of the model's cube
    #[arg(long, value_name = "N", requires = "depth", value_parser = clap::value_parser!(u32).range(1..))]
    pub cells: Option<u32>,
    /// PICTURE without shadows, to count pixels in a shadow where there is none, and the opposite
    #[arg(long, value_name = "P.png", requires = "reference_lit")]
    pub lit: Option<PathBuf>,
    /// REFERENCE without shadows
    #[arg(long, value_name = "R.png", requires = "lit")]
    pub reference_lit: Option<PathBuf>,
    /// Fail below this intersection over union
    #[arg(long, value_name = "X", help_heading = "Limits")]
    pub min_iou: Option<f64>,
    /// Fail below this PSNR inside, in decibels
    #[arg(long, value_name = "DB", help_heading = "Limits")]
    pub min_psnr_inside: Option<f64>,
    /// Fail below this PSNR over the union, in decibels
    #[arg(long, value_name = "DB", help_heading = "Limits")]
    pub min_psnr_union: Option<f64>,
    /// Fail above this number of holes
    #[arg(long, value_name = "N", help_heading = "Limits")]
    pub max_holes: Option<usize>,
    /// Fail when more than so many of a hundred covered pixels are shaded wrongly
    #[arg(
        long,
        value_name = "PERCENT",
        help_heading = "Limits",
        requires = "lit"
    )]
    pub max_wrong_shadows: Option<f64>,
    /// What was measured as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// `RRGGBB`, with or without a `#`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub [u8; 3]);

impl FromStr for Colour {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.strip_prefix('#').unwrap_or(text);
        let valid = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
        u32::from_str_radix(digits, 16)
            .ok()
            .filter(|_| valid)
            .map(|word| {
                let [_, r, g, b] = word.to_be_bytes();
                Self([r, g, b])
            })
            .ok_or_else(|| "expected RRGGBB, such as 000000".to_owned())
    }
}

impl Compare {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit 2 when a file cannot be read or the sizes differ, exit 1 when a limit is broken.
    pub fn run(&self) -> Outcome {
        let picture = Picture::read(&self.picture)?;
        let reference = Picture::read(&self.reference)?;
        if reference.coverage.is_none() {
            eprintln!(
                "warning: {} has no alpha; its silhouette is what differs from the background",
                self.reference.display()
            );
        }
        let depths = match (&self.depth, &self.reference_depth, self.cells) {
            (Some(picture), Some(reference), Some(cells)) => {
                Some((Depth::read(picture)?, Depth::read(reference)?, cells))
            }
            _ => None,
        };
        let depths = depths.as_ref().map(|(picture, reference, cells)| Depths {
            picture,
            reference,
            cell: 1.0 / f64::from(*cells),
        });
        let told = picture.background.unwrap_or_default();
        let background = self.background.map_or(told, |colour| colour.0);
        let result = compare::compare(&picture, &reference, background, depths)?;
        let shadows = match (&self.lit, &self.reference_lit) {
            (Some(lit), Some(reference_lit)) => {
                let (lit, reference_lit) = (Picture::read(lit)?, Picture::read(reference_lit)?);
                let pair = |shadowed, lit| Pair { shadowed, lit };
                let (ours, theirs) = (pair(&picture, &lit), pair(&reference, &reference_lit));
                Some(shadows::compare(ours, theirs, background)?)
            }
            _ => None,
        };
        if self.json {
            let mut object = serde_json::json!(result);
            if let Some(wrong) = &shadows {
                object["shadows"] = serde_json::json!(wrong);
            }
            println!("{object}");
        } else {
            print(&result);
            if let Some(wrong) = &shadows {
                print_shadows(wrong);
            }
        }
        self.limits(&result, shadows.as_ref())
    }

    /// Fails when a limit is broken or what it limits could not be measured.
    fn limits(&self, result: &Comparison, shadows: Option<&Wrong>) -> Outcome {
        let mut broken = Vec::new();
        let mut least = |what: &str, value: Option<f64>, limit: Option<f64>| {
            if let Some(limit) = limit {
                match value {
                    // A limit that is not a number is never reached.
                    Some(value) if value >= limit => (),
                    Some(value) => broken.push(format!("{what} {value:.4} is below {limit}")),
                    None => broken.push(format!("{what} is not known: no such pixel")),
                }
            }
        };
        least("IoU", Some(result.iou), self.min_iou);
        least("PSNR inside", result.psnr_inside, self.min_psnr_inside);
        least(
            "PSNR over the union",
            result.psnr_union,
            self.min_psnr_union,
        );
        if let Some(limit) = self.max_holes
            && result.holes > limit
        {
            broken.push(format!("{} holes are more than {limit}", result.holes));
        }
        if let (Some(limit), Some(wrong)) = (self.max_wrong_shadows, shadows)
            && (wrong.per_cent() > limit || wrong.per_cent().is_nan())
        {
            let wrong = wrong.per_cent();
            broken.push(format!("{wrong:.2} % wrong shadows are more than {limit}"));
        }
        if broken.is_empty() {
            return Ok(());
        }
        Err(Failure::limit(format!(
            "{}: {}",
            self.picture.display(),
            broken.join("; ")
        )))
    }
}

fn print(result: &Comparison) {
    let decibels = |value: Option<f64>| {
        value.map_or_else(|| "not known".to_owned(), |value| format!("{value:.2} dB"))
    };
    println!("PSNR union   {}", decibels(result.psnr_union));
    println!("PSNR inside  {}", decibels(result.psnr_inside));
    match result.ssim {
        Some(ssim) => println!("SSIM         {ssim:.4}  (Gaussian 11x11, luma)"),
        None => println!("SSIM         not known"),
    }
    println!(
        "IoU          {:.4}  ({} of {} pixels)",
        result.iou, result.pixels.intersection, result.pixels.union
    );
    println!("holes        {}", result.holes);
    if let Some(leaks) = result.leaks {
        println!("leaks        {leaks}");
    }
}

fn print_shadows(wrong: &Wrong) {
    println!(
        "shadows      {:.2} % wrong  ({} too dark and {} too bright of {} pixels, {} in shadow)",
        wrong.per_cent(),
        wrong.acne,
        wrong.leaks,
        wrong.covered,
        wrong.shadowed
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_six_hexadecimal_digits() {
        assert_eq!("#0a1Bff".parse(), Ok(Colour([10, 27, 255])));
        for bad in ["", "12345", "1234567", "+12345", "zzzzzz"] {
            assert!(bad.parse::<Colour>().is_err(), "{bad}");
        }
    }
}
