//! Wavefront OBJ: positions with or without colours, normals, faces of any number of corners.
//!
//! Groups, objects and materials are read through, so a model in many groups stays one
//! surface; every vertex counts for the bounding cube, also one in no face; and an error
//! names its line. tobj does none of these three, so it is not the reader but the judge: the
//! tests hold this reader against it.

use std::collections::HashMap;

use glam::DVec3;

use super::input::Input;
use super::polygon::Faces;
use super::soup::Soup;
use crate::failure::{Failure, Outcome};

const NONE: u32 = u32::MAX;

/// Reads the whole file.
pub(super) fn read(input: &Input) -> Outcome<Soup> {
    if input.bytes.contains(&0) {
        return Err(
            Failure::input(format!("{} is not an OBJ: it is not a text", input.name))
                .help("models are read from PLY, OBJ, STL, GLB and glTF, each also as .gz"),
        );
    }
    let text = String::from_utf8_lossy(&input.bytes);
    let count = |start: &str| {
        text.lines()
            .filter(|l| l.trim_start().starts_with(start))
            .count() as u64
    };
    let (vertices, faces) = (count("v "), count("f "));
    input.reserve(vertices, faces)?;
    let mut reader = Reader {
        input,
        line: 0,
        soup: Soup::default(),
        normals: Vec::new(),
        corner_normals: Vec::new(),
        colours: Vec::new(),
        faces: Faces::default(),
    };
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        reader.line = number + 1;
        if line.trim_end().ends_with('\\') {
            let mut joined = String::new();
            let mut next = Some(line);
            while let Some(part) = next {
                let part = part.trim_end();
                joined.push_str(part.trim_end_matches('\\'));
                joined.push(' ');
                next = if part.ends_with('\\') {
                    lines.next().map(|(_, line)| line)
                } else {
                    None
                };
            }
            reader.statement(&joined)?;
        } else {
            reader.statement(line)?;
        }
    }
    reader.finish()
}

struct Reader<'a> {
    input: &'a Input,
    line: usize,
    soup: Soup,
    /// `vn` of the file.
    normals: Vec<DVec3>,
    /// The normal of each corner of a face, or [`NONE`].
    corner_normals: Vec<u32>,
    /// 0 to 1 or 0 to 255, as the file has it; one a vertex of the file, or empty.
    colours: Vec<[f64; 3]>,
    faces: Faces,
}

impl Reader<'_> {
    fn statement(&mut self, line: &str) -> Outcome {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.vertex(words),
            Some("vn") => {
                let mut n = [0.0; 3];
                self.numbers(words, &mut n, 3)?;
                self.normals.push(DVec3::from(n));
                Ok(())
            }
            Some("f" | "fo") => self.face(words),
            _ => Ok(()),
        }
    }

    fn vertex<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Outcome {
        let mut v = [0.0; 7];
        let count = self.numbers(words, &mut v, 3)?;
        let mut position = DVec3::new(v[0], v[1], v[2]);
        // Four numbers are x y z w, six are x y z r g b, seven are both.
        if matches!(count, 4 | 7) {
            position /= v[3];
        }
        if !position.is_finite() {
            let what = format!(
                "the position is {} {} {}",
                position.x, position.y, position.z
            );
            return Err(self
                .error(&what)
                .help("positions must be finite numbers; repair the model"));
        }
        if self.soup.positions.len() >= NONE as usize {
            return Err(self
                .error("more than 2^32 vertices")
                .help("decimate the model"));
        }
        if count >= 6 {
            self.colours.resize(self.soup.positions.len(), [1.0; 3]);
            self.colours
                .push([v[count - 3], v[count - 2], v[count - 1]]);
        } else if !self.colours.is_empty() {
            self.colours.push([1.0; 3]);
        }
        self.soup.positions.push(position);
        Ok(())
    }

    /// Reads up to `out.len()` numbers and says how many; at least `least`.
    fn numbers<'w>(
        &self,
        words: impl Iterator<Item = &'w str>,
        out: &mut [f64],
        least: usize,
    ) -> Outcome<usize> {
        let mut count = 0;
        for (word, slot) in words.zip(out) {
            *slot = word.parse().map_err(|_| {
                self.error(&format!("\"{}\" is not a number", shorten(word)))
                    .help("export the model again")
            })?;
            count += 1;
        }
        if count < least {
            return Err(self
                .error(&format!("{count} numbers where {least} are needed"))
                .help("export the model again; the line may be cut short"));
        }
        Ok(count)
    }

    fn face<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Outcome {
        let number = self.faces.len();
        for word in words {
            let mut parts = word.split('/');
            let vertex = self.index(parts.next(), self.soup.positions.len(), "vertex", word)?;
            let normal = self.index(parts.nth(1), self.normals.len(), "normal", word)?;
            let Some(vertex) = vertex else {
                return Err(self.error(&format!("face {number} has a corner without a vertex")));
            };
            self.faces.corner(vertex);
            self.corner_normals.push(normal.unwrap_or(NONE));
        }
        let corners = self.faces.open_corners();
        if self.faces.end().is_none() {
            return Err(self
                .error(&format!("face {number} has {corners} corners"))
                .help("a face needs three corners; remove loose edges and points"));
        }
        Ok(())
    }

    /// An index from 1, or from the end when negative, as one from 0.
    fn index(
        &self,
        text: Option<&str>,
        count: usize,
        what: &str,
        word: &str,
    ) -> Outcome<Option<u32>> {
        let Some(text) = text.filter(|t| !t.is_empty()) else {
            return Ok(None);
        };
        let index: i64 = text.parse().map_err(|_| {
            self.error(&format!("\"{}\" is not a corner of a face", shorten(word)))
                .help("corners are v, v/vt, v//vn or v/vt/vn; export the model again")
        })?;
        let from_zero = if index < 0 {
            index.checked_add_unsigned(count as u64)
        } else {
            index.checked_sub(1)
        };
        from_zero
            .and_then(|i| u32::try_from(i).ok())
            .filter(|&i| (i as usize) < count)
            .map(Some)
            .ok_or_else(|| {
                self.error(&format!(
                    "face {} refers to {what} {index}, and there are {count} so far, numbered from 1",
                    self.faces.len()
                ))
                .help("export the model again; its faces do not fit its vertices")
            })
    }

    /// Gives each vertex its normal; one that has several is copied, after all of the file's.
    fn finish(mut self) -> Outcome<Soup> {
        let positions = &mut self.soup.positions;
        self.colours.resize(
            if self.colours.is_empty() {
                0
            } else {
                positions.len()
            },
            [1.0; 3],
        );
        let mut normal_of = vec![NONE; positions.len()];
        // Looked up only, so its order does not matter.
        let mut copies: HashMap<(u32, u32), u32> = HashMap::new();
        for (vertex, &normal) in self
            .faces
            .corners_mut()
            .iter_mut()
            .zip(&self.corner_normals)
        {
            let taken = &mut normal_of[*vertex as usize];
            if normal == NONE || *taken == normal {
                continue;
            }
            if *taken == NONE {
                *taken = normal;
                continue;
            }
            let key = (*vertex, normal);
            if let Some(&copy) = copies.get(&key) {
                *vertex = copy;
                continue;
            }
            if copies.len().is_multiple_of(1 << 16) {
                self.input.reserve(normal_of.len() as u64, 0)?;
            }
            let copy = u32::try_from(positions.len()).map_err(|_| {
                Failure::input(format!("{}: more than 2^32 vertices", self.input.name))
                    .help("decimate the model")
            })?;
            positions.push(positions[*vertex as usize]);
            if !self.colours.is_empty() {
                self.colours.push(self.colours[*vertex as usize]);
            }
            normal_of.push(normal);
            copies.insert(key, copy);
            *vertex = copy;
        }
        if !self.normals.is_empty() {
            let normals = &self.normals;
            self.soup.normals = normal_of
                .iter()
                .map(|&n| normals.get(n as usize).copied().unwrap_or_default())
                .collect();
        }
        // Colours are 0 to 1; some programs write 0 to 255.
        let full = if self.colours.iter().flatten().any(|&c| c > 1.0) {
            255.0
        } else {
            1.0
        };
        self.soup.colours = self
            .colours
            .iter()
            .map(|c| c.map(|c| (c / full * 255.0).round().clamp(0.0, 255.0) as u8))
            .collect();
        let cut = self.faces.cut(&self.soup.positions);
        if cut.odd > 0 {
            self.soup.warnings.push(format!(
                "{}: {} faces cross themselves; they were cut as fans",
                self.input.name, cut.odd
            ));
        }
        self.soup.triangles = cut.triangles;
        Ok(self.soup)
    }

    fn error(&self, what: &str) -> Failure {
        self.input.error(&format!("line {}", self.line), what)
    }
}

fn shorten(word: &str) -> String {
    word.chars().take(24).collect()
}
