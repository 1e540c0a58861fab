//! Blobs as files.

use std::io::Write;
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
    /// Reads a file whole; what it holds is checked by [`Self::blob`].
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn read(path: &Path) -> Outcome<Self> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|e| {
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

/// Writes a file beside `path` and puts it in its place at once: there is the old file or the whole
/// new one, never a part.
///
/// # Errors
/// When the folder does not exist or cannot be written; the old file is then as before.
pub fn replace(path: &Path, bytes: &[u8]) -> Outcome {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let write = || -> std::io::Result<()> {
        let mut file = tempfile::Builder::new()
            .prefix(".rho-")
            .tempfile_in(folder)?;
        file.write_all(bytes)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            file.as_file()
                .set_permissions(std::fs::Permissions::from_mode(0o644))?;
        }
        file.persist(path)?;
        Ok(())
    };
    write().map_err(|e| {
        Failure::input(format!("{}: cannot be written: {e}", path.display()))
            .help("name a file in a folder that exists and may be written")
    })
}
