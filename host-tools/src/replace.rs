//! Writing a file at once and whole: beside its place first, then renamed over it.

use std::io::Write;
use std::path::Path;

use crate::failure::{Failure, Outcome};

/// Replaces the file at `path`, or leaves it as it was; `-` writes to standard output.
///
/// # Errors
/// Exit 2 when the folder is missing, is not writable, or the path is a directory.
pub fn replace(path: &Path, bytes: &[u8]) -> Outcome {
    let failed = |error: std::io::Error| {
        Failure::input(format!("cannot write {}: {error}", path.display()))
            .help("check that the folder exists, may be written to and has room")
    };
    if path == Path::new("-") {
        let mut out = std::io::stdout().lock();
        return out
            .write_all(bytes)
            .and_then(|()| out.flush())
            .map_err(failed);
    }
    check_replaceable(path)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rho-");
    #[cfg(unix)]
    {
        // As any new file: the user's mask takes away what it should.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder_of(path)).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Fails when [`replace`] is bound to: for commands that work long before they write.
///
/// # Errors
/// Exit 2 when the folder is missing or the path is a directory.
pub fn check_replaceable(path: &Path) -> Outcome {
    let refuse = |what: &str, help: &str| {
        Err(Failure::input(format!("cannot write {}: {what}", path.display())).help(help))
    };
    if path == Path::new("-") {
        Ok(())
    } else if path.is_dir() {
        refuse("it is a directory", "name a file")
    } else if !folder_of(path).is_dir() {
        refuse("its folder does not exist", "make the folder first")
    } else {
        Ok(())
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        replace(&path, b"long before").unwrap();
        replace(&path, b"after").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"after");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_fails_cleanly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.bin");
        let failure = replace(&path, b"x").unwrap_err();
        assert!(failure.message.contains("none/a.bin"), "{failure}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let failure = replace(folder.path(), b"x").unwrap_err();
        assert!(failure.message.contains("is a directory"));
    }
}
