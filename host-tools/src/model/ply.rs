//! PLY, ascii and binary of either byte order.
//!
//! The header is read by ply-rs-bw. The payload is decoded here, for the sake of messages and
//! of odd files rather than of speed (both take about 80 ms for 871,414 triangles): a fault is
//! named with its byte or line, ascii numbers such as `.5` and `1.` and empty lines are read,
//! and a claimed count is held against the bytes that follow before anything is allocated. The
//! tests hold it against ply-rs-bw's own payload reader.

use std::io::Cursor;

use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, Header, PropertyType, ScalarType};

use super::input::Input;
use super::polygon::Faces;
use super::soup::Soup;
use crate::failure::{Failure, Outcome};

/// Where a vertex keeps its numbers: position, normal, colour.
const SLOTS: usize = 9;
const NAMES: [&[&str]; SLOTS] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
];
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// What to do with one property of an element.
#[derive(Clone, Copy, Debug)]
enum Field {
    Scalar(ScalarKind, Option<usize>),
    List {
        count: ScalarKind,
        item: ScalarKind,
        corners: bool,
    },
}

/// [`ScalarType`] as a value that can be copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ScalarKind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl From<&ScalarType> for ScalarKind {
    fn from(kind: &ScalarType) -> Self {
        match kind {
            ScalarType::Char => Self::I8,
            ScalarType::UChar => Self::U8,
            ScalarType::Short => Self::I16,
            ScalarType::UShort => Self::U16,
            ScalarType::Int => Self::I32,
            ScalarType::UInt => Self::U32,
            ScalarType::Float => Self::F32,
            ScalarType::Double => Self::F64,
        }
    }
}

impl ScalarKind {
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// What stands for full intensity in a colour of this type.
    fn full(self) -> f64 {
        match self {
            Self::F32 | Self::F64 => 1.0,
            Self::I16 | Self::U16 => 65535.0,
            _ => 255.0,
        }
    }
}

/// Reads the whole file.
pub(super) fn read(input: &Input) -> Outcome<Soup> {
    let (header, start, lines) = header(input)?;
    let mut payload = Payload {
        input,
        encoding: header.encoding,
        at: start,
        line: lines,
        token_line: 0,
    };
    let vertices = header.elements.get("vertex").map_or(0, |e| e.count);
    let faces = header.elements.get("face").map_or(0, |e| e.count);
    let mut soup = Soup::default();
    let mut corners = Faces::default();
    for element in header.elements.values() {
        payload.check_claim(element)?;
        match element.name.as_str() {
            "vertex" => {
                input.reserve(vertices as u64, faces as u64)?;
                payload.vertices(element, &mut soup)?;
            }
            "face" => {
                input.reserve(vertices as u64, faces as u64)?;
                corners = payload.faces(element, vertices)?;
            }
            _ => payload.skip(element)?,
        }
    }
    let cut = corners.cut(&soup.positions);
    if cut.odd > 0 {
        soup.warnings.push(format!(
            "{}: {} faces cross themselves; they were cut as fans",
            input.name, cut.odd
        ));
    }
    soup.triangles = cut.triangles;
    Ok(soup)
}

/// The header, the byte after it and the line on which the payload starts.
fn header(input: &Input) -> Outcome<(Header, usize, usize)> {
    let mut reader = Reader::new(Cursor::new(input.bytes.as_slice()));
    let parsed = Parser::<DefaultElement>::new().read_header(&mut reader);
    let header = parsed.map_err(|error| {
        let text = error.to_string();
        let what = text.lines().next().unwrap_or_default();
        // The library's own text begins with the line.
        let what = what.split_once(": ").map_or(what, |(_, what)| what);
        input
            .error(
                &format!("line {}", error.line().unwrap_or(1)),
                &format!("not a PLY header: {what}"),
            )
            .help("export the model as PLY again")
    })?;
    let start = usize::try_from(reader.get_ref().position()).unwrap_or(usize::MAX);
    let start = start.min(input.bytes.len());
    let lines = input.bytes[..start].iter().filter(|&&b| b == b'\n').count();
    Ok((header, start, lines + 1))
}

struct Payload<'a> {
    input: &'a Input,
    encoding: Encoding,
    /// The next byte to be read.
    at: usize,
    /// Ascii: the line on which that byte lies, from 1.
    line: usize,
    /// Ascii: the line of the number read last.
    token_line: usize,
}

impl Payload<'_> {
    fn vertices(&mut self, element: &ElementDef, soup: &mut Soup) -> Outcome {
        let fields = fields(element);
        let slot = |i: usize| {
            fields.iter().find_map(|f| match f {
                Field::Scalar(kind, Some(slot)) if *slot == i => Some(*kind),
                _ => None,
            })
        };
        if (0..3).any(|i| slot(i).is_none()) {
            return Err(Failure::input(format!(
                "{}: its vertices lack x, y or z",
                self.input.name
            ))
            .help("export the positions as properties x, y and z"));
        }
        let normals = (3..6).all(|i| slot(i).is_some());
        let full = [6, 7, 8].map(|i| slot(i).map(ScalarKind::full));
        soup.positions.reserve_exact(element.count);
        if normals {
            soup.normals.reserve_exact(element.count);
        }
        for number in 0..element.count {
            let start = self.at;
            let mut v = [0.0; SLOTS];
            for field in &fields {
                match *field {
                    Field::Scalar(kind, slot) => {
                        let value = self.scalar(kind, element, number)?;
                        if let Some(slot) = slot {
                            v[slot] = value;
                        }
                    }
                    Field::List { count, item, .. } => {
                        self.skip_list(count, item, element, number)?;
                    }
                }
            }
            let position = DVec3::new(v[0], v[1], v[2]);
            if !position.is_finite() {
                return Err(self
                    .input
                    .error(
                        &self.place(element, number, start),
                        &format!("its position is {} {} {}", v[0], v[1], v[2]),
                    )
                    .help("positions must be finite numbers; repair the model"));
            }
            soup.positions.push(position);
            if normals {
                soup.normals.push(DVec3::new(v[3], v[4], v[5]));
            }
            if let [Some(r), Some(g), Some(b)] = full {
                soup.colours
                    .push([byte(v[6] / r), byte(v[7] / g), byte(v[8] / b)]);
            }
        }
        Ok(())
    }

    fn faces(&mut self, element: &ElementDef, vertices: usize) -> Outcome<Faces> {
        let fields = fields(element);
        let has_corners = fields
            .iter()
            .any(|f| matches!(f, Field::List { corners: true, .. }));
        if !has_corners && element.count > 0 {
            return Err(Failure::input(format!(
                "{}: its faces lack vertex_indices",
                self.input.name
            ))
            .help("export the faces as a list property vertex_indices"));
        }
        let mut faces = Faces::with_capacity(element.count);
        for number in 0..element.count {
            let start = self.at;
            for field in &fields {
                match *field {
                    Field::Scalar(kind, _) => {
                        self.scalar(kind, element, number)?;
                    }
                    Field::List {
                        count,
                        item,
                        corners: true,
                    } => {
                        let corners = self.length(count, element, number)?;
                        for _ in 0..corners {
                            let index = self.scalar(item, element, number)?;
                            if !(index >= 0.0 && index < vertices as f64) || index.fract() != 0.0 {
                                return Err(self
                                    .input
                                    .error(
                                        &self.place(element, number, start),
                                        &format!("it refers to vertex {index}, and there are {vertices}, numbered from 0"),
                                    )
                                    .help("export the model again; its faces do not fit its vertices"));
                            }
                            // In range, so it fits: counts are checked against 2^32 below.
                            faces.corner(index as u32);
                        }
                        if faces.end().is_none() {
                            return Err(self
                                .input
                                .error(
                                    &self.place(element, number, start),
                                    &format!("it has {corners} corners"),
                                )
                                .help(
                                    "a face needs three corners; remove loose edges and points",
                                ));
                        }
                    }
                    Field::List { count, item, .. } => {
                        self.skip_list(count, item, element, number)?;
                    }
                }
            }
        }
        Ok(faces)
    }

    fn skip(&mut self, element: &ElementDef) -> Outcome {
        let fields = fields(element);
        if fields.is_empty() {
            return Ok(());
        }
        for number in 0..element.count {
            for field in &fields {
                match *field {
                    Field::Scalar(kind, _) => {
                        self.scalar(kind, element, number)?;
                    }
                    Field::List { count, item, .. } => {
                        self.skip_list(count, item, element, number)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn skip_list(
        &mut self,
        count: ScalarKind,
        item: ScalarKind,
        element: &ElementDef,
        number: usize,
    ) -> Outcome {
        for _ in 0..self.length(count, element, number)? {
            self.scalar(item, element, number)?;
        }
        Ok(())
    }

    /// The length of a list, which the rest of the file must be able to hold.
    fn length(&mut self, kind: ScalarKind, element: &ElementDef, number: usize) -> Outcome<usize> {
        let start = self.at;
        let length = self.scalar(kind, element, number)?;
        if length < 0.0 || length.fract() != 0.0 {
            return Err(self
                .input
                .error(
                    &self.place(element, number, start),
                    &format!("a list of {length} numbers"),
                )
                .help("export the model again"));
        }
        if length > (self.input.bytes.len() - self.at) as f64 {
            let place = self.place(element, number, start);
            let what = format!("a list of {length} numbers is longer than the file");
            return Err(self.input.cut_short(&place, &what));
        }
        Ok(length as usize)
    }

    /// Fails at once when a header claims more elements than the file can hold.
    fn check_claim(&self, element: &ElementDef) -> Outcome {
        let fields = fields(element);
        let each: usize = match self.encoding {
            // A digit and what parts it from the next.
            Encoding::Ascii => 2 * fields.len(),
            _ => fields
                .iter()
                .map(|field| match *field {
                    Field::Scalar(kind, _) | Field::List { count: kind, .. } => kind.size(),
                })
                .sum(),
        };
        let left = self.input.bytes.len() - self.at;
        let need = element.count.saturating_mul(each);
        // The last line of a text needs no line end.
        if need > left + usize::from(self.encoding == Encoding::Ascii) {
            let place = self.place_of_next();
            return Err(self.input.cut_short(
                &place,
                &format!(
                    "{} elements '{}' need at least {need} bytes, and {left} follow",
                    element.count, element.name
                ),
            ));
        }
        if element.count > u32::MAX as usize {
            return Err(Failure::input(format!(
                "{}: {} elements '{}' are more than 2^32 - 1",
                self.input.name, element.count, element.name
            ))
            .help("decimate the model"));
        }
        Ok(())
    }

    fn scalar(&mut self, kind: ScalarKind, element: &ElementDef, number: usize) -> Outcome<f64> {
        match self.encoding {
            Encoding::Ascii => self.word(kind, element, number),
            Encoding::BinaryLittleEndian => self
                .binary::<true>(kind)
                .ok_or_else(|| self.ends_in(element, number)),
            Encoding::BinaryBigEndian => self
                .binary::<false>(kind)
                .ok_or_else(|| self.ends_in(element, number)),
        }
    }

    #[inline]
    fn binary<const LITTLE: bool>(&mut self, kind: ScalarKind) -> Option<f64> {
        macro_rules! number {
            ($type:ty) => {{
                let bytes = self.input.bytes.get(self.at..)?.first_chunk()?;
                self.at += bytes.len();
                f64::from(if LITTLE {
                    <$type>::from_le_bytes(*bytes)
                } else {
                    <$type>::from_be_bytes(*bytes)
                })
            }};
        }
        Some(match kind {
            ScalarKind::I8 => number!(i8),
            ScalarKind::U8 => number!(u8),
            ScalarKind::I16 => number!(i16),
            ScalarKind::U16 => number!(u16),
            ScalarKind::I32 => number!(i32),
            ScalarKind::U32 => number!(u32),
            ScalarKind::F32 => number!(f32),
            ScalarKind::F64 => number!(f64),
        })
    }

    fn word(&mut self, kind: ScalarKind, element: &ElementDef, number: usize) -> Outcome<f64> {
        let bytes = self.input.bytes.as_slice();
        while let Some(byte) = bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*byte == b'\n');
            self.at += 1;
        }
        let start = self.at;
        while bytes.get(self.at).is_some_and(|b| !b.is_ascii_whitespace()) {
            self.at += 1;
        }
        self.token_line = self.line;
        let word = &bytes[start..self.at];
        if word.is_empty() {
            return Err(self.ends_in(element, number));
        }
        let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        let value: f64 = value.ok_or_else(|| {
            let word = String::from_utf8_lossy(&word[..word.len().min(24)]);
            self.input
                .error(
                    &self.place(element, number, start),
                    &format!("\"{word}\" is not a number"),
                )
                .help("export the model again")
        })?;
        // As a binary file of this type would hold it.
        Ok(match kind {
            ScalarKind::F32 => f64::from(value as f32),
            _ => value,
        })
    }

    fn ends_in(&self, element: &ElementDef, number: usize) -> Failure {
        self.input.cut_short(
            &self.place_of_next(),
            &format!("it ends in {} {number} of {}", element.name, element.count),
        )
    }

    fn place(&self, element: &ElementDef, number: usize, start: usize) -> String {
        match self.encoding {
            Encoding::Ascii => format!(
                "line {} ({} {number})",
                self.token_line.max(1),
                element.name
            ),
            _ => format!("byte {start} ({} {number})", element.name),
        }
    }

    fn place_of_next(&self) -> String {
        match self.encoding {
            Encoding::Ascii => format!("line {}", self.line),
            _ => format!("byte {}", self.at),
        }
    }
}

fn fields(element: &ElementDef) -> Vec<Field> {
    let is_vertex = element.name == "vertex";
    element
        .properties
        .values()
        .map(|property| match &property.data_type {
            PropertyType::Scalar(kind) => Field::Scalar(
                kind.into(),
                NAMES
                    .iter()
                    .position(|names| is_vertex && names.contains(&property.name.as_str())),
            ),
            PropertyType::List(count, item) => Field::List {
                count: count.into(),
                item: item.into(),
                corners: INDICES.contains(&property.name.as_str())
                    && !ScalarKind::from(item).is_float(),
            },
        })
        .collect()
}

/// 0 to 1 as 0 to 255, to nearest; what is not a number is 0.
fn byte(intensity: f64) -> u8 {
    (intensity * 255.0).round().clamp(0.0, 255.0) as u8
}
