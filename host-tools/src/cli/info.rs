//! `rho info`: what is in a blob.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::blob_file::BlobFile;
use crate::contents::Contents;
use crate::failure::Outcome;
use crate::text::thousands;

const EXAMPLES: &str = "\
Examples:
  rho info bunny.rho
  rho info bunny.rho --json

alpha is the number of children of a node above the leaves: rho squared on a flat surface. A
blob that is damaged, cut short or of a newer version is refused with the reason (exit 2).";

/// Tell what is in a blob: grids, samples, bytes
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Info {
    /// A blob that `rho bake` wrote; - for standard input
    #[arg(value_name = "OUT.rho")]
    pub blob: PathBuf,
    /// The same as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

impl Info {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit 2: the file cannot be read or is not a valid blob.
    pub fn run(&self) -> Outcome {
        let file = BlobFile::read(&self.blob)?;
        let contents = Contents::of(&file.blob()?);
        if self.json {
            println!("{}", json!(contents));
        } else {
            print(&contents);
        }
        Ok(())
    }
}

fn print(contents: &Contents) {
    for (key, value) in &contents.origin {
        println!("{key:<12} {value}");
    }
    for (index, grid) in contents.grids.iter().enumerate() {
        println!(
            "grid {index:<7} {}, {}-separating, {}, alpha {:.3}, {} bytes",
            grid.sequence(),
            grid.separation,
            grid.layout,
            grid.alpha,
            thousands(grid.bytes)
        );
        println!("{:>18}  {:>12}", "cells an axis", "nodes");
        for (level, (cells, nodes)) in grid.cells.iter().zip(&grid.nodes_by_level).enumerate() {
            let bare = if level < grid.first_sampled {
                "  without samples"
            } else {
                ""
            };
            println!("{cells:>18}  {:>12}{bare}", thousands(*nodes));
        }
    }
    if let Some(scene) = &contents.scene {
        for (index, object) in scene.objects.iter().enumerate() {
            let ends = |all: &[u16]| match all {
                [only] => only.to_string(),
                [first, .., last] => format!("{first} to {last}"),
                [] => String::new(),
            };
            println!(
                "object {index:<5} grids {}, materials {}, {} instances",
                ends(&object.grids),
                ends(&object.materials),
                object.instances
            );
        }
        println!(
            "scene        {} instances, {} lights{}, {}",
            scene.instances,
            scene.lights,
            if scene.shadows {
                ", one casts shadows"
            } else {
                ""
            },
            if scene.camera {
                "a camera"
            } else {
                "no camera"
            }
        );
    }
    println!("nodes        {}", thousands(contents.nodes));
    println!("leaf samples {}", thousands(contents.leaf_samples));
    println!("materials    {}", contents.materials.len());
    for (name, bytes) in contents.bytes.iter().filter(|(name, _)| *name != "total") {
        println!("  {name:<16}  {:>12}", thousands(*bytes));
    }
    println!(
        "bytes               {:>12}, {:.3} a leaf",
        thousands(contents.total_bytes()),
        contents.bytes_per_leaf
    );
}
