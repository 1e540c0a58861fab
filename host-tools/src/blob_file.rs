//! Blobs as files.

use std::io::Read;
use std::path::Path;

use rho_grid::blob::{Blob, BlobError};

use crate::failure::{Failure, Outcome};

/// A blob read from a file, aligned as flash is.
#[derive(Clone, Debug)]
pub struct BlobFile {
    words: Vec<u32>,
    length: usize,
    name: String,
}

impl BlobFile {
    /// Reads a file whole, or standard input when the path is `-`; what it holds is checked by
    /// [`Self::blob`].
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn read(path: &Path) -> Outcome<Self> {
        let (name, bytes) = if path == Path::new("-") {
            let mut bytes = Vec::new();
            let read = std::io::stdin().lock().read_to_end(&mut bytes);
            ("standard input".to_owned(), read.map(|_| bytes))
        } else {
            (path.display().to_string(), std::fs::read(path))
        };
        let bytes = bytes.map_err(|e| {
            Failure::input(format!("{name}: {e}"))
                .help("name a blob that `rho bake MODEL -o OUT.rho` has written")
        })?;
        Ok(Self::from_bytes(&bytes, name))
    }

    /// A blob that stands in memory; `name` is for messages.
    #[must_use]
    pub fn from_bytes(bytes: &[u8], name: impl Into<String>) -> Self {
        let mut words = vec![0u32; bytes.len().div_ceil(4)];
        bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
        Self {
            words,
            length: bytes.len(),
            name: name.into(),
        }
    }

    /// All bytes of the file.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.words)[..self.length]
    }

    /// The blob, checked.
    ///
    /// # Errors
    /// With the file's name, the reason and what to do.
    pub fn blob(&self) -> Outcome<Blob<'_>> {
        let refuse = |reason: String, help: &str| {
            Err(Failure::input(format!("{}: {reason}", self.name)).help(help))
        };
        match Blob::parse(self.bytes()) {
            Ok(blob) if blob.bytes().len() == self.length => Ok(blob),
            Ok(blob) => refuse(
                format!(
                    "{} bytes follow the blob's end",
                    self.length - blob.bytes().len()
                ),
                "copy or bake it again: the file should end where its header says",
            ),
            Err(e @ BlobError::Newer { .. }) => refuse(
                e.to_string(),
                "use the version of rho that baked it, or bake it again",
            ),
            Err(e @ BlobError::NotABlob) => refuse(
                e.to_string(),
                "bake the model first: rho bake MODEL -o OUT.rho",
            ),
            Err(e) => refuse(
                e.to_string(),
                "copy it again from its source, or bake it again",
            ),
        }
    }
}
