//! Which format a file has: by content, by its extension only where content does not tell.

use std::fmt;

use super::input::Input;
use crate::failure::{Failure, Outcome};

/// A format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Polygon file format, ascii or binary of either byte order.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, ascii or binary.
    Stl,
    /// glTF 2.0, binary.
    Glb,
    /// glTF 2.0, JSON with buffers beside it or within.
    Gltf,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ply => "PLY",
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
        })
    }
}

/// The format, and a warning when the name says another one.
pub(super) fn format(input: &Input) -> Outcome<(Format, Option<String>)> {
    let named = by_name(&input.name);
    match (by_content(&input.bytes), named) {
        (Some(found), Some(named)) if found != named => Ok((
            found,
            Some(format!(
                "{} is named as {named} but holds {found}; it was read as {found}",
                input.name
            )),
        )),
        (Some(found), _) => Ok((found, None)),
        // A binary STL has no mark; a text without any known keyword may still be one.
        (None, Some(named @ (Format::Stl | Format::Obj))) => Ok((named, None)),
        (None, named) => {
            let start: Vec<String> = input
                .bytes
                .iter()
                .take(8)
                .map(|b| format!("{b:02x}"))
                .collect();
            let what = named.map_or_else(
                || "its format is not known".to_owned(),
                |named| format!("it is not {named}"),
            );
            Err(Failure::input(format!(
                "{}: {what}; it begins with the bytes {}",
                input.name,
                start.join(" ")
            ))
            .help("models are read from PLY, OBJ, STL, GLB and glTF, each also as .gz"))
        }
    }
}

fn by_name(name: &str) -> Option<Format> {
    let name = name.to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let (_, extension) = name.rsplit_once('.')?;
    match extension {
        "ply" => Some(Format::Ply),
        "obj" => Some(Format::Obj),
        "stl" => Some(Format::Stl),
        "glb" => Some(Format::Glb),
        "gltf" => Some(Format::Gltf),
        _ => None,
    }
}

fn by_content(bytes: &[u8]) -> Option<Format> {
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return Some(Format::Ply);
    }
    if bytes.starts_with(b"glTF") {
        return Some(Format::Glb);
    }
    // Before the ascii form: the header of a binary STL may well begin with "solid".
    if super::stl::is_binary(bytes) {
        return Some(Format::Stl);
    }
    let text = &bytes[..bytes.len().min(4096)];
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let text = text.trim_ascii_start();
    if text.first() == Some(&b'{') {
        return Some(Format::Gltf);
    }
    if text.len() >= 5 && text[..5].eq_ignore_ascii_case(b"solid") {
        return Some(Format::Stl);
    }
    looks_like_obj(text).then_some(Format::Obj)
}

/// Whether one of the first lines is a statement that only an OBJ has, and no line is binary.
fn looks_like_obj(text: &[u8]) -> bool {
    const KEYWORDS: [&[u8]; 10] = [
        b"v", b"vn", b"vt", b"f", b"o", b"g", b"s", b"l", b"mtllib", b"usemtl",
    ];
    !text.contains(&0)
        && text
            .split(|&byte| byte == b'\n')
            .map(<[u8]>::trim_ascii)
            .filter(|line| !line.is_empty() && !line.starts_with(b"#"))
            .map(|line| line.split(u8::is_ascii_whitespace).next().unwrap_or(line))
            .next()
            .is_some_and(|word| KEYWORDS.contains(&word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, bytes: &[u8]) -> Outcome<(Format, Option<String>)> {
        format(&Input::from_bytes(name, bytes.to_vec(), 1 << 20)?)
    }

    #[test]
    fn content_goes_before_the_extension() {
        let (format, warning) = of("a.obj", b"ply\nformat ascii 1.0\n").unwrap();
        assert_eq!(format, Format::Ply);
        assert!(warning.unwrap().contains("named as OBJ but holds PLY"));
        assert_eq!(of("a.ply", b"# by hand\nv 0 0 0\n").unwrap().0, Format::Obj);
        assert_eq!(of("noname", b"glTF\x02\0\0\0").unwrap().0, Format::Glb);
        assert_eq!(of("x", b"\n {\"asset\":{}}").unwrap().0, Format::Gltf);
        assert_eq!(of("x", b"solid cube\n").unwrap().0, Format::Stl);
    }

    #[test]
    fn a_binary_stl_whose_header_begins_with_solid_is_binary() {
        let mut bytes = vec![b' '; 80];
        bytes[..6].copy_from_slice(b"solid ");
        bytes.extend(1u32.to_le_bytes());
        bytes.extend([0; 50]);
        assert!(super::super::stl::is_binary(&bytes));
        assert_eq!(of("x", &bytes).unwrap().0, Format::Stl);
    }

    #[test]
    fn unknown_content_names_the_formats() {
        let failure = of("cat.png", b"\x89PNG\r\n\x1a\n").unwrap_err();
        assert!(failure.message.contains("89 50 4e 47"), "{failure}");
        assert!(failure.help.unwrap().contains("PLY, OBJ, STL, GLB"));
        let failure = of("cat.ply", b"\x89PNG\r\n\x1a\n").unwrap_err();
        assert!(failure.message.contains("it is not PLY"), "{failure}");
    }
}
