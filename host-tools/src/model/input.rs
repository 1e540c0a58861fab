//! The bytes of a model file: from disk, standard input or memory, inflated, never more
//! than allowed.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use crate::failure::{Failure, Outcome};

/// What a reader works on.
#[derive(Debug)]
pub(super) struct Input {
    /// How messages call it.
    pub(super) name: String,
    /// Inflated.
    pub(super) bytes: Vec<u8>,
    /// The folder whose files it may refer to.
    pub(super) folder: Option<PathBuf>,
    /// The most bytes that this and everything made from it may take.
    pub(super) limit: u64,
}

impl Input {
    pub(super) fn open(path: &Path, limit: u64) -> Outcome<Self> {
        if path == Path::new("-") {
            let name = "standard input";
            let bytes = read_limited(std::io::stdin().lock(), 0, name, limit)?;
            return Self::from_bytes(name, bytes, limit);
        }
        let name = path.display().to_string();
        let unreadable = |error: std::io::Error| cannot_read(&name, &error);
        let file = File::open(path).map_err(unreadable)?;
        let about = file.metadata().map_err(unreadable)?;
        if about.is_dir() {
            return Err(Failure::input(format!("{name} is a directory"))
                .help("name one model file: .ply, .obj, .stl, .glb or .gltf, or one of them .gz"));
        }
        let bytes = read_limited(file, about.len(), &name, limit)?;
        let mut input = Self::from_bytes(&name, bytes, limit)?;
        input.folder = path.parent().map(Path::to_owned);
        Ok(input)
    }

    pub(super) fn from_bytes(name: &str, bytes: Vec<u8>, limit: u64) -> Outcome<Self> {
        let bytes = if bytes.starts_with(&[0x1f, 0x8b]) {
            inflate(name, &bytes, limit)?
        } else {
            bytes
        };
        if bytes.is_empty() {
            return Err(Failure::input(format!("{name} is empty"))
                .help("name a model file: .ply, .obj, .stl, .glb or .gltf"));
        }
        Ok(Self {
            name: name.to_owned(),
            bytes,
            folder: None,
            limit,
        })
    }

    /// An error at a place in the file, such as `line 7` or `vertex 3 (byte 412)`.
    pub(super) fn error(&self, place: &str, what: &str) -> Failure {
        Failure::input(format!("{}, {place}: {what}", self.name))
    }

    /// The file ends too early; `place` says where.
    pub(super) fn cut_short(&self, place: &str, what: &str) -> Failure {
        self.error(place, &format!("the file is cut short: {what}"))
            .help("fetch or export the file again")
    }

    /// Fails unless a mesh of this size fits, together with the file, into the memory allowed.
    pub(super) fn reserve(&self, vertices: u64, triangles: u64) -> Outcome {
        /// Position, normal, colour, and once more for what is made on the way.
        const VERTEX: u64 = 2 * (24 + 24 + 3);
        /// The indices, as read and as triangles.
        const TRIANGLE: u64 = 2 * 12 + 4;
        let need = (self.bytes.len() as u64)
            .saturating_add(vertices.saturating_mul(VERTEX))
            .saturating_add(triangles.saturating_mul(TRIANGLE));
        if need <= self.limit {
            return Ok(());
        }
        Err(Failure::input(format!(
            "{}: {vertices} vertices and {triangles} faces need {} MiB, and {} MiB are allowed",
            self.name,
            need.div_ceil(1 << 20),
            self.limit >> 20,
        ))
        .help("decimate the model, or allow more memory"))
    }
}

/// Reads to the end, or fails once more than `limit` bytes came; `expected` only sizes the
/// first allocation.
pub(super) fn read_limited(
    reader: impl Read,
    expected: u64,
    name: &str,
    limit: u64,
) -> Outcome<Vec<u8>> {
    if expected > limit {
        return Err(too_large(name, limit));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(expected).unwrap_or(0).saturating_add(1));
    reader
        .take(limit.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|error| cannot_read(name, &error))?;
    if bytes.len() as u64 > limit {
        return Err(too_large(name, limit));
    }
    Ok(bytes)
}

fn inflate(name: &str, packed: &[u8], limit: u64) -> Outcome<Vec<u8>> {
    // The last four bytes claim the size (modulo 2^32): believed up to a common ratio.
    let claim = packed
        .last_chunk()
        .map_or(0, |tail| u32::from_le_bytes(*tail)) as usize;
    let mut bytes = Vec::with_capacity(claim.min(packed.len().saturating_mul(8)));
    let result = MultiGzDecoder::new(packed)
        .take(limit.saturating_add(1))
        .read_to_end(&mut bytes);
    if bytes.len() as u64 > limit {
        return Err(too_large(name, limit));
    }
    result.map_err(|error| {
        Failure::input(format!(
            "{name}, byte {} after inflating: the gzip data is damaged or cut short ({error})",
            bytes.len()
        ))
        .help("fetch or compress the file again")
    })?;
    Ok(bytes)
}

fn too_large(name: &str, limit: u64) -> Failure {
    Failure::input(format!(
        "{name} is larger than the {} MiB of memory allowed",
        limit >> 20
    ))
    .help("decimate the model, or allow more memory")
}

fn cannot_read(name: &str, error: &std::io::Error) -> Failure {
    match error.kind() {
        ErrorKind::NotFound => Failure::input(format!("there is no file {name}"))
            .help("check the path; relative ones start at the current directory"),
        ErrorKind::PermissionDenied => Failure::input(format!("no permission to read {name}"))
            .help("make the file readable for this user"),
        _ => Failure::input(format!("cannot read {name}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn a_bomb_stops_at_the_limit() {
        let bomb = packed(&vec![0; 1 << 24]);
        assert!(bomb.len() < 1 << 18);
        let failure = Input::from_bytes("bomb.ply.gz", bomb, 1 << 20).unwrap_err();
        assert!(
            failure.message.contains("larger than the 1 MiB"),
            "{failure}"
        );
    }

    #[test]
    fn a_cut_gzip_file_tells_how_far_it_went() {
        let mut bytes = packed(
            &(0..100_000u32)
                .flat_map(u32::to_le_bytes)
                .collect::<Vec<_>>(),
        );
        bytes.truncate(bytes.len() / 2);
        let failure = Input::from_bytes("half.ply.gz", bytes, 1 << 30).unwrap_err();
        assert!(failure.message.contains("half.ply.gz, byte"), "{failure}");
        assert!(failure.help.is_some());
    }

    #[test]
    fn what_cannot_be_opened_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let failure = Input::open(folder.path(), 1 << 20).unwrap_err();
        assert!(failure.message.contains("is a directory"), "{failure}");
        let failure = Input::open(&folder.path().join("none.ply"), 1 << 20).unwrap_err();
        assert!(failure.message.contains("there is no file"), "{failure}");
        let denied = cannot_read("x.ply", &ErrorKind::PermissionDenied.into());
        assert!(denied.message.contains("no permission to read x.ply"));
    }

    #[test]
    fn a_file_larger_than_allowed_is_refused_before_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sparse.stl");
        // A sparse file: it has a length but no blocks.
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let failure = Input::open(&path, 1 << 20).unwrap_err();
        assert!(failure.message.contains("larger than"), "{failure}");
    }

    #[test]
    fn an_empty_file_is_called_empty() {
        let failure = Input::from_bytes("a.obj", Vec::new(), 1).unwrap_err();
        assert!(failure.message.contains("a.obj is empty"));
        let failure = Input::from_bytes("a.obj.gz", packed(&[]), 1).unwrap_err();
        assert!(failure.message.contains("a.obj.gz is empty"));
    }
}
