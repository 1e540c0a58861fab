//! Where in the source an instruction comes from, by the image's debug information.

use std::collections::BTreeMap;
use std::path::Path;

use addr2line::Loader;

use crate::failure::{Failure, Outcome};

/// Where an instruction comes from.
///
/// The optimiser joins functions; this is the innermost one that is not the standard library's,
/// since an addition belongs to who wrote `+`.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The function, without the types it was made for.
    pub function: String,
    /// The file, from the workspace or from its crate.
    pub file: String,
    /// The line; 0 when it is not known.
    pub line: u32,
    /// The function of the image into which all of this was joined.
    pub symbol: String,
}

/// Looks places up.
pub struct Places {
    loader: Loader,
    known: BTreeMap<u32, Place>,
}

impl Places {
    /// Reads the debug information of an image.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn open(elf: &Path) -> Outcome<Self> {
        let loader = Loader::new(elf).map_err(|error| {
            Failure::input(format!(
                "{}: its debug information cannot be read: {error}",
                elf.display()
            ))
        })?;
        Ok(Self {
            loader,
            known: BTreeMap::new(),
        })
    }

    /// Where the instruction at an address comes from; empty where nothing is known.
    pub fn of(&mut self, address: u32) -> &Place {
        let Self { loader, known } = self;
        known
            .entry(address)
            .or_insert_with(|| find(loader, address))
    }
}

fn find(loader: &Loader, address: u32) -> Place {
    let mut place = Place::default();
    let mut own = false;
    let Ok(mut frames) = loader.find_frames(address.into()) else {
        return place;
    };
    while let Ok(Some(frame)) = frames.next() {
        let function = frame
            .function
            .and_then(|name| name.demangle().ok().map(|name| without_hash(&name)))
            .unwrap_or_default();
        let (file, line) = frame
            .location
            .map(|at| (at.file.unwrap_or_default(), at.line.unwrap_or(0)))
            .unwrap_or_default();
        place.symbol.clone_from(&function);
        if !own {
            own = !is_standard(file);
            place.function = function;
            place.file = short(file);
            place.line = line;
        }
    }
    if place.symbol.is_empty() {
        // Assembly has no frames, only a symbol.
        let symbol = loader.find_symbol(address.into()).unwrap_or_default();
        place.symbol = without_hash(symbol);
        place.function.clone_from(&place.symbol);
    }
    place
}

/// Whether a file belongs to the standard library.
fn is_standard(file: &str) -> bool {
    file.contains("/library/") || file.starts_with("/rustc/")
}

/// A function's name without the hash that makes it unique.
fn without_hash(name: &str) -> String {
    match name.rsplit_once("::h") {
        Some((name, hash)) if hash.len() == 16 && hash.chars().all(|c| c.is_ascii_hexdigit()) => {
            name.to_owned()
        }
        _ => name.to_owned(),
    }
}

/// A file's name from its crate or the workspace.
fn short(file: &str) -> String {
    let here = std::env::current_dir().unwrap_or_default();
    if let Ok(file) = Path::new(file).strip_prefix(here) {
        return file.display().to_string();
    }
    for folder in ["/registry/src/", "/library/"] {
        if let Some((_, rest)) = file.split_once(folder) {
            // The registry's own folder comes first.
            let skipped = rest.split_once('/').filter(|_| folder.contains("registry"));
            return skipped.map_or(rest, |(_, rest)| rest).to_owned();
        }
    }
    file.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_left_out_and_other_names_kept() {
        assert_eq!(without_hash("a::b::h0123456789abcdef"), "a::b");
        assert_eq!(without_hash("a::height"), "a::height");
    }

    #[test]
    fn files_are_named_from_their_crate() {
        let here = std::env::current_dir().unwrap();
        assert_eq!(
            short(&here.join("src/a.rs").display().to_string()),
            "src/a.rs"
        );
        assert_eq!(
            short("/home/registry/src/index-1/a-1.0/src/b.rs"),
            "a-1.0/src/b.rs"
        );
        assert_eq!(short("/rustc/1234/library/core/src/c.rs"), "core/src/c.rs");
        assert!(is_standard("/rustc/1234/library/core/src/c.rs"));
    }
}
