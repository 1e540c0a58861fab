//! What is built from the workspace when a command needs it: firmware, and the emulator's plugin.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::failure::{Failure, Outcome};

/// A package of the workspace and how it is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Package<'a> {
    /// Its name.
    pub name: &'a str,
    /// The one of its programs that is wanted; none for a library.
    pub program: Option<&'a str>,
    /// The cargo profile.
    pub profile: &'a str,
    /// What it is built for, where that is not this machine.
    pub target: Option<&'a str>,
}

impl Package<'_> {
    /// Builds it from the workspace that the folder lies in; where the result lies. With
    /// `target_dir`, cargo writes there and not where it would by itself.
    ///
    /// # Errors
    /// When cargo or the target is missing, the folder is in no such workspace, or the build
    /// fails; then with cargo's own words.
    pub fn build(&self, folder: &Path, target_dir: Option<&Path>) -> Outcome<PathBuf> {
        let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = Command::new(cargo);
        command
            .args(["build", "--quiet", "--profile", self.profile])
            .args(["--package", self.name])
            .arg("--message-format=json-render-diagnostics")
            .current_dir(folder)
            .stdin(Stdio::null());
        if let Some(program) = self.program {
            command.args(["--bin", program]);
        }
        if let Some(target) = self.target {
            command.args(["--target", target]);
        }
        if let Some(target_dir) = target_dir {
            command.arg("--target-dir").arg(target_dir);
        }
        let output = command.output().map_err(|error| {
            Failure::missing(format!("cargo does not start: {error}"))
                .help("install Rust with https://rustup.rs")
        })?;
        if !output.status.success() {
            return Err(self.failure(&String::from_utf8_lossy(&output.stderr)));
        }
        self.artifact(&String::from_utf8_lossy(&output.stdout))
            .ok_or_else(|| Failure::missing(format!("cargo built {} but named no file", self.name)))
    }

    /// The command that builds it by hand.
    #[must_use]
    pub fn command(&self) -> String {
        let target = self.target.map(|target| format!(" --target {target}"));
        format!(
            "cargo build --profile {} -p {}{}",
            self.profile,
            self.name,
            target.unwrap_or_default()
        )
    }

    /// The path of the result in cargo's messages.
    fn artifact(&self, messages: &str) -> Option<PathBuf> {
        // A library's name has underscores.
        let library = self.name.replace('-', "_");
        let wanted = self.program.unwrap_or(&library);
        messages
            .lines()
            .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
            .filter(|message| message["target"]["name"] == *wanted)
            .find_map(|message| message["filenames"][0].as_str().map(PathBuf::from))
    }

    /// What to tell when cargo fails, from what it wrote.
    fn failure(&self, stderr: &str) -> Failure {
        if stderr.contains("could not find `Cargo.toml`") || stderr.contains("did not match any") {
            return Failure::input(format!(
                "{} cannot be built: this folder is not in its workspace",
                self.name
            ))
            .help("run this in the project's folder");
        }
        if let Some(target) = self.target
            && (stderr.contains("can't find crate for `core`")
                || stderr.contains("may not be installed"))
        {
            return Failure::missing(format!("the Rust target {target} is not installed"))
                .help(format!("rustup target add {target}"));
        }
        Failure::missing(format!(
            "{} does not build:\n{}",
            self.name,
            stderr.trim_end()
        ))
        .help("mend what cargo complains about")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Exit;

    const IMAGE: Package<'_> = Package {
        name: "rho-board",
        program: Some("board"),
        profile: "firmware",
        target: Some("thumbv7m-none-eabi"),
    };

    #[test]
    fn the_result_is_found_in_cargos_messages() {
        let messages = concat!(
            r#"{"reason":"compiler-artifact","target":{"name":"rho-grid"},"filenames":["/x"]}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"rho_board"},"filenames":["/librho_board.rlib"]}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"board"},"filenames":["/a/b"]}"#,
            "\nnoise\n",
            r#"{"reason":"compiler-artifact","target":{"name":"a_b"},"filenames":["/liba_b.so"]}"#,
        );
        assert_eq!(IMAGE.artifact(messages), Some(PathBuf::from("/a/b")));
        let library = Package {
            name: "a-b",
            program: None,
            ..IMAGE
        };
        let expected = Some(PathBuf::from("/liba_b.so"));
        assert_eq!(library.artifact(messages), expected);
    }

    #[test]
    fn a_missing_target_tells_the_command_that_mends_it() {
        let failure = IMAGE.failure("error[E0463]: can't find crate for `core`");
        assert_eq!(failure.exit, Exit::Missing);
        assert_eq!(
            failure.help.as_deref(),
            Some("rustup target add thumbv7m-none-eabi")
        );
    }

    #[test]
    fn a_folder_outside_the_workspace_is_told() {
        let failure = IMAGE.failure("error: could not find `Cargo.toml` in `/` or any parent");
        assert_eq!(failure.exit, Exit::Input);
    }
}
