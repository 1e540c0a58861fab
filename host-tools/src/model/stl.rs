//! STL, ascii and binary.
//!
//! The ascii form is read by stl_io, one solid after the other. The binary form is an array of
//! 50-byte records, taken as it is: stl_io would read a binary file whose header begins with
//! "solid " as ascii. The tests hold both against stl_io.
//!
//! Corners of the same position (bit for bit, -0 as 0) become one vertex, so that the normals
//! made from the faces are smooth. The file's own normals are one a face and often wrong or
//! zero: they are not used, and the winding says which side is outside.

use std::collections::HashMap;
use std::io::Cursor;

use glam::DVec3;

use super::input::Input;
use super::soup::Soup;
use crate::failure::Outcome;

/// A header of 80 bytes and the number of triangles.
const HEADER: usize = 84;
/// A normal, three corners, two bytes of attributes.
const FACET: usize = 50;

/// Whether the length is that of a binary STL, which holds whatever the header says.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    claimed(bytes).is_some_and(|n| n > 0 && n.checked_mul(FACET) == bytes.len().checked_sub(HEADER))
}

fn claimed(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

/// Reads the whole file.
pub(super) fn read(input: &Input) -> Outcome<Soup> {
    let bytes = input.bytes.as_slice();
    let ascii = bytes.trim_ascii_start();
    let ascii = ascii.len() >= 5 && ascii[..5].eq_ignore_ascii_case(b"solid");
    let mut merged = Merged::default();
    if ascii && !is_binary(bytes) {
        read_ascii(input, &mut merged)?;
    } else {
        read_binary(input, &mut merged)?;
    }
    Ok(merged.soup)
}

fn read_binary(input: &Input, merged: &mut Merged) -> Outcome {
    let bytes = input.bytes.as_slice();
    let Some(count) = claimed(bytes) else {
        return Err(input.cut_short(
            &format!("byte {}", bytes.len()),
            &format!("a binary STL begins with {HEADER} bytes"),
        ));
    };
    let held = (bytes.len() - HEADER) / FACET;
    if count > held {
        return Err(input.cut_short(
            &format!("byte {}", bytes.len()),
            &format!("it claims {count} facets and holds {held}"),
        ));
    }
    input.reserve(count as u64, count as u64)?;
    if count < held {
        let rest = bytes.len() - HEADER - count * FACET;
        merged.soup.warnings.push(format!(
            "{}: {rest} bytes after the last facet ignored",
            input.name
        ));
    }
    let facets = bytes[HEADER..].as_chunks::<FACET>().0;
    for (number, facet) in facets[..count].iter().enumerate() {
        let words = facet.as_chunks::<4>().0;
        let corner = |i: usize| [0, 1, 2].map(|axis| f32::from_le_bytes(words[3 * i + axis]));
        // The normal comes first.
        let corners = [corner(1), corner(2), corner(3)];
        merged.add(corners, input, || {
            format!("byte {} (facet {number})", HEADER + number * FACET)
        })?;
    }
    Ok(())
}

fn read_ascii(input: &Input, merged: &mut Merged) -> Outcome {
    // Some programs write keywords in capitals; numbers do not mind.
    let text = input.bytes.to_ascii_lowercase();
    input.reserve(text.len() as u64 / 100, text.len() as u64 / 100)?;
    let lines: Vec<&[u8]> = text.split(|&byte| byte == b'\n').collect();
    let is_start = |line: &&[u8]| line.trim_ascii_start().starts_with(b"solid");
    let mut number = 0;
    let mut first_line = lines.iter().position(is_start).unwrap_or(0);
    // A file may hold several solids; the library reads one.
    while first_line < lines.len() {
        let rest = &lines[first_line + 1..];
        let next = rest
            .iter()
            .position(is_start)
            .map_or(lines.len(), |n| first_line + 1 + n);
        let body: usize = lines[first_line + 1..next]
            .iter()
            .map(|l| l.len() + 1)
            .sum();
        let offset: usize = lines[..=first_line].iter().map(|l| l.len() + 1).sum();
        let start = offset.min(text.len());
        let end = (offset + body).min(text.len());
        // The name is left out: the library insists on a space after "solid".
        let mut solid = Cursor::new([b"solid \n", &text[start..end]].concat());
        let facets = stl_io::create_stl_reader(&mut solid)
            .map_err(|e| input.error(&format!("line {}", first_line + 1), &e.to_string()))?;
        for (in_solid, facet) in facets.enumerate() {
            let place = || {
                let line = rest
                    .iter()
                    .enumerate()
                    .filter(|(_, line)| line.trim_ascii_start().starts_with(b"facet"))
                    .nth(in_solid)
                    .map_or(lines.len(), |(line, _)| first_line + 2 + line);
                format!("line {line} (facet {number})")
            };
            let facet = facet.map_err(|e| {
                if e.kind() == std::io::ErrorKind::UnexpectedEof {
                    input.cut_short(&place(), &e.to_string())
                } else {
                    input
                        .error(&place(), &e.to_string())
                        .help("write the model again, best as binary STL")
                }
            })?;
            merged.add(facet.vertices.map(|v| v.0), input, place)?;
            number += 1;
        }
        first_line = next;
    }
    Ok(())
}

/// Facets whose corners are merged by position.
#[derive(Default)]
struct Merged {
    soup: Soup,
    /// Looked up only; the order of vertices is that of the file.
    known: HashMap<[u32; 3], u32>,
}

impl Merged {
    fn add(
        &mut self,
        corners: [[f32; 3]; 3],
        input: &Input,
        place: impl Fn() -> String,
    ) -> Outcome {
        let mut triangle = [0; 3];
        for (index, corner) in triangle.iter_mut().zip(corners) {
            // -0 + 0 is 0.
            let p = corner.map(|x| x + 0.0);
            if !p.iter().all(|x| x.is_finite()) {
                let what = format!("a corner lies at {} {} {}", p[0], p[1], p[2]);
                return Err(input
                    .error(&place(), &what)
                    .help("positions must be finite numbers; repair the model"));
            }
            *index = match self.known.entry(p.map(f32::to_bits)) {
                std::collections::hash_map::Entry::Occupied(entry) => *entry.get(),
                std::collections::hash_map::Entry::Vacant(entry) => {
                    let next = u32::try_from(self.soup.positions.len()).map_err(|_| {
                        input
                            .error(&place(), "more than 2^32 vertices")
                            .help("decimate the model")
                    })?;
                    self.soup.positions.push(DVec3::from(p.map(f64::from)));
                    *entry.insert(next)
                }
            };
        }
        self.soup.triangles.push(triangle);
        Ok(())
    }
}
