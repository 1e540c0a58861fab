//! glTF 2.0, binary (GLB) and JSON, through the gltf crate.
//!
//! The crate trusts offsets and counts once its validation passed, so everything is checked
//! here before it is asked for numbers. The nodes' transforms are applied. Colours are
//! COLOR_0 times the material's base colour; glTF has them linear, a mesh has them as
//! displayed, so they are encoded as sRGB. Textures are not read.

use std::path::Path;

use glam::{DMat3, DMat4, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};

use super::input::{Input, read_limited};
use super::soup::Soup;
use crate::failure::{Failure, Outcome};

/// Nodes deeper than this are refused: they are walked by recursion.
const MAX_DEPTH: usize = 256;
const EXPORT: &str = "export the model again as GLB without compression or extensions";

/// Reads the whole file and the buffers that it names.
pub(super) fn read(input: &Input) -> Outcome<Soup> {
    let (document, blob) = document(input)?;
    let buffers = buffers(input, &document, blob)?;
    let mut reader = Reader {
        input,
        buffers,
        soup: Soup::default(),
        visited: vec![false; document.nodes().len()],
        coloured: false,
        textured: false,
        skipped: 0,
    };
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    if let Some(scene) = scene {
        for node in scene.nodes() {
            reader.node(&node, DMat4::IDENTITY, 0)?;
        }
    } else {
        // Without a scene, every mesh stands where it was made.
        for mesh in document.meshes() {
            for primitive in mesh.primitives() {
                reader.primitive(&primitive, DMat4::IDENTITY, mesh.index())?;
            }
        }
    }
    Ok(reader.finish())
}

/// The JSON and the binary chunk, both validated as far as the crate does.
fn document(input: &Input) -> Outcome<(Document, Option<Vec<u8>>)> {
    let bytes = input.bytes.as_slice();
    if bytes.starts_with(b"glTF") {
        // The crate subtracts the header's size unasked.
        let word = |at: usize| {
            let word = bytes.get(at..)?.first_chunk()?;
            Some(u32::from_le_bytes(*word) as usize)
        };
        let claimed = word(8).unwrap_or(usize::MAX);
        if claimed > bytes.len() || bytes.len() < 20 {
            return Err(input.cut_short(
                &format!("byte {}", bytes.len()),
                &word(8).map_or("the header is incomplete".to_owned(), |n| {
                    format!("the header claims {n} bytes")
                }),
            ));
        }
        if claimed < 20 {
            return Err(input
                .error(
                    "byte 8",
                    &format!("the header claims {claimed} bytes in all"),
                )
                .help(EXPORT));
        }
        if let Some(json) = word(12)
            && json > claimed - 20
        {
            return Err(input.cut_short("byte 12", &format!("the JSON chunk claims {json} bytes")));
        }
    }
    let gltf = Gltf::from_slice_without_validation(bytes).map_err(|error| {
        input
            .error("its structure", &first_line(&error.to_string()))
            .help(EXPORT)
    })?;
    let json = gltf.document.into_json();
    if let Some(extension) = unsupported(&json.extensions_required) {
        return Err(
            Failure::input(format!("{}: it requires {extension}", input.name)).help(
                "re-export without compression or quantisation, such as with `gltfpack -noq` and without -c",
            ),
        );
    }
    // The crate's validation looks up the accessor of the positions before it checks it.
    for (number, mesh) in json.meshes.iter().enumerate() {
        for accessor in mesh.primitives.iter().flat_map(|p| p.attributes.values()) {
            if accessor.value() >= json.accessors.len() {
                let what = format!(
                    "it refers to accessor {}, and there are {}",
                    accessor.value(),
                    json.accessors.len()
                );
                return Err(input.error(&format!("mesh {number}"), &what).help(EXPORT));
            }
        }
    }
    let document = Document::from_json(json).map_err(|error| {
        let what = match error {
            gltf::Error::Validation(faults) => faults
                .first()
                .map(|(path, fault)| format!("{path}: {fault}"))
                .unwrap_or_default(),
            other => first_line(&other.to_string()),
        };
        input.error("its structure", &what).help(EXPORT)
    })?;
    Ok((document, gltf.blob))
}

/// The first required extension that changes how geometry is stored or that is not known.
fn unsupported(required: &[String]) -> Option<&String> {
    /// These change only how surfaces look.
    const HARMLESS: [&str; 3] = ["KHR_materials_", "KHR_texture_", "KHR_lights_punctual"];
    required
        .iter()
        .find(|name| !HARMLESS.iter().any(|harmless| name.starts_with(harmless)))
}

fn buffers(input: &Input, document: &Document, mut blob: Option<Vec<u8>>) -> Outcome<Vec<Vec<u8>>> {
    let mut left = input.limit.saturating_sub(input.bytes.len() as u64);
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let place = format!("buffer {}", buffer.index());
        let data = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or_else(|| {
                input
                    .error(&place, "it is the binary chunk, and there is none")
                    .help(EXPORT)
            })?,
            gltf::buffer::Source::Uri(uri) if uri.starts_with("data:") => {
                let source = gltf::buffer::Source::Uri(uri);
                let data = gltf::buffer::Data::from_source(source, None);
                data.map_err(|error| {
                    input
                        .error(&place, &first_line(&error.to_string()))
                        .help(EXPORT)
                })?
                .0
            }
            gltf::buffer::Source::Uri(uri) => beside(input, uri, left, &place)?,
        };
        if data.len() < buffer.length() {
            return Err(input.cut_short(
                &place,
                &format!(
                    "it claims {} bytes and holds {}",
                    buffer.length(),
                    data.len()
                ),
            ));
        }
        left = left.saturating_sub(data.len() as u64);
        buffers.push(data);
    }
    Ok(buffers)
}

/// A file in the folder of the model.
fn beside(input: &Input, uri: &str, limit: u64, place: &str) -> Outcome<Vec<u8>> {
    let refuse = |what: String| {
        input
            .error(place, &what)
            .help("put the buffer beside the model, or export it as GLB")
    };
    let Some(folder) = &input.folder else {
        return Err(refuse(format!(
            "it lies in the file {uri}, which has no folder here"
        )));
    };
    let name = percent_decoded(uri)
        .filter(|name| !name.contains(':') && !Path::new(name).is_absolute())
        .ok_or_else(|| refuse(format!("\"{uri}\" is not the name of a file")))?;
    let path = folder.join(name);
    let about = std::fs::metadata(&path)
        .map_err(|error| refuse(format!("cannot read {}: {error}", path.display())))?;
    if !about.is_file() {
        return Err(refuse(format!("{} is not a file", path.display())));
    }
    let file = std::fs::File::open(&path)
        .map_err(|error| refuse(format!("cannot read {}: {error}", path.display())))?;
    read_limited(file, about.len(), &path.display().to_string(), limit)
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut bytes = uri.bytes();
    while let Some(byte) = bytes.next() {
        if byte == b'%' {
            let digit = |b: Option<u8>| char::from(b?).to_digit(16);
            let (high, low) = (digit(bytes.next())?, digit(bytes.next())?);
            out.push(u8::try_from(16 * high + low).ok()?);
        } else {
            out.push(byte);
        }
    }
    String::from_utf8(out).ok()
}

struct Reader<'a> {
    input: &'a Input,
    buffers: Vec<Vec<u8>>,
    soup: Soup,
    visited: Vec<bool>,
    coloured: bool,
    textured: bool,
    /// Primitives of points or lines.
    skipped: usize,
}

impl Reader<'_> {
    fn node(&mut self, node: &Node<'_>, parent: DMat4, depth: usize) -> Outcome {
        let place = format!("node {}", node.index());
        // The format asks for trees; a loop or a shared child would never end or grow
        // without bounds.
        if std::mem::replace(&mut self.visited[node.index()], true) {
            return Err(self
                .input
                .error(&place, "it is the child of two nodes or of itself")
                .help(EXPORT));
        }
        if depth > MAX_DEPTH {
            let what = format!("it lies more than {MAX_DEPTH} nodes deep");
            return Err(self.input.error(&place, &what).help(EXPORT));
        }
        let columns = node.transform().matrix();
        let own = DMat4::from_cols_array_2d(&columns.map(|c| c.map(f64::from)));
        let transform = parent * own;
        if !transform.is_finite() {
            return Err(self
                .input
                .error(&place, "its transform is not finite")
                .help(EXPORT));
        }
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                self.primitive(&primitive, transform, mesh.index())?;
            }
        }
        for child in node.children() {
            self.node(&child, transform, depth + 1)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, transform: DMat4, mesh: usize) -> Outcome {
        if matches!(
            primitive.mode(),
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip
        ) {
            self.skipped += 1;
            return Ok(());
        }
        let place = format!("mesh {mesh}, primitive {}", primitive.index());
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            return Ok(());
        };
        let count = accessor.count();
        let base = self.soup.positions.len();
        self.input.reserve(
            base.saturating_add(count) as u64,
            self.soup.triangles.len() as u64,
        )?;
        let end = u32::try_from(base.saturating_add(count)).map_err(|_| {
            self.input
                .error(&place, "more than 2^32 vertices")
                .help("decimate the model")
        })?;
        let base = end - u32::try_from(count).unwrap_or(0);
        self.positions(&accessor, transform)?;
        self.normals(primitive, transform, count)?;
        self.colours(primitive, count)?;
        let corners = match primitive.indices() {
            Some(accessor) => self.indices(&accessor, count)?,
            None => (0..end - base).collect(),
        };
        // A mirror turns the winding round.
        let mirrored = DMat3::from_mat4(transform).determinant() < 0.0;
        let mut triangle = |[a, b, c]: [u32; 3]| {
            let t = if mirrored { [a, c, b] } else { [a, b, c] };
            self.soup.triangles.push(t.map(|i| base + i));
        };
        match primitive.mode() {
            Mode::TriangleStrip => {
                for (i, w) in corners.windows(3).enumerate() {
                    triangle(if i % 2 == 0 {
                        [w[0], w[1], w[2]]
                    } else {
                        [w[1], w[0], w[2]]
                    });
                }
            }
            Mode::TriangleFan => {
                for w in corners.windows(2).skip(1) {
                    triangle([corners[0], w[0], w[1]]);
                }
            }
            _ => {
                if corners.len() % 3 != 0 {
                    let what = format!("{} corners are not a number of triangles", corners.len());
                    return Err(self.input.error(&place, &what).help(EXPORT));
                }
                for &t in corners.as_chunks::<3>().0 {
                    triangle(t);
                }
            }
        }
        Ok(())
    }

    fn positions(&mut self, accessor: &Accessor<'_>, transform: DMat4) -> Outcome {
        let data = self.numbers(accessor, &[DataType::F32], &[Dimensions::Vec3])?;
        for (i, p) in data.as_chunks::<3>().0.iter().enumerate() {
            let position = transform.transform_point3(DVec3::from(*p));
            if !position.is_finite() {
                return Err(self
                    .input
                    .error(
                        &format!("accessor {}, vertex {i}", accessor.index()),
                        &format!("its position is {} {} {}", p[0], p[1], p[2]),
                    )
                    .help("positions must be finite numbers; repair the model"));
            }
            self.soup.positions.push(position);
        }
        Ok(())
    }

    fn normals(&mut self, primitive: &Primitive<'_>, transform: DMat4, count: usize) -> Outcome {
        let before = self.soup.positions.len() - count;
        let Some(accessor) = primitive.get(&Semantic::Normals) else {
            if !self.soup.normals.is_empty() {
                self.soup.normals.resize(before + count, DVec3::ZERO);
            }
            return Ok(());
        };
        self.same_count(&accessor, count, "normals")?;
        let data = self.numbers(&accessor, &[DataType::F32], &[Dimensions::Vec3])?;
        let turn = DMat3::from_mat4(transform).inverse().transpose();
        self.soup.normals.resize(before, DVec3::ZERO);
        let normals = data.as_chunks::<3>().0.iter();
        self.soup
            .normals
            .extend(normals.map(|n| turn * DVec3::from(*n)));
        Ok(())
    }

    fn colours(&mut self, primitive: &Primitive<'_>, count: usize) -> Outcome {
        let material = primitive.material().pbr_metallic_roughness();
        self.textured |= material.base_color_texture().is_some();
        let factor = material.base_color_factor().map(f64::from);
        let accessor = primitive.get(&Semantic::Colors(0));
        self.coloured |= accessor.is_some() || factor[..3] != [1.0; 3];
        let Some(accessor) = accessor else {
            let flat = [0, 1, 2].map(|i| srgb(factor[i]));
            let end = self.soup.colours.len() + count;
            self.soup.colours.resize(end, flat);
            return Ok(());
        };
        self.same_count(&accessor, count, "colours")?;
        let data = self.numbers(
            &accessor,
            &[DataType::F32, DataType::U8, DataType::U16],
            &[Dimensions::Vec3, Dimensions::Vec4],
        )?;
        let full = match accessor.data_type() {
            DataType::U8 => 255.0,
            DataType::U16 => 65535.0,
            _ => 1.0,
        };
        let width = accessor.dimensions().multiplicity();
        self.soup.colours.extend(
            data.chunks_exact(width)
                .map(|c| [0, 1, 2].map(|i| srgb(c[i] / full * factor[i]))),
        );
        Ok(())
    }

    fn indices(&self, accessor: &Accessor<'_>, vertices: usize) -> Outcome<Vec<u32>> {
        self.input.reserve(
            self.soup.positions.len() as u64,
            self.soup.triangles.len().saturating_add(accessor.count()) as u64,
        )?;
        let data = self.numbers(
            accessor,
            &[DataType::U8, DataType::U16, DataType::U32],
            &[Dimensions::Scalar],
        )?;
        let indices = data.iter().enumerate().map(|(i, &index)| {
            if index < vertices as f64 {
                // A u32 in the file.
                return Ok(index as u32);
            }
            Err(self
                .input
                .error(
                    &format!("accessor {}, index {i} (face {})", accessor.index(), i / 3),
                    &format!(
                        "it refers to vertex {index}, and there are {vertices}, numbered from 0"
                    ),
                )
                .help("export the model again; its faces do not fit its vertices"))
        });
        indices.collect()
    }

    fn same_count(&self, accessor: &Accessor<'_>, count: usize, what: &str) -> Outcome {
        if accessor.count() == count {
            return Ok(());
        }
        Err(self
            .input
            .error(
                &format!("accessor {}", accessor.index()),
                &format!("{} {what} for {count} vertices", accessor.count()),
            )
            .help(EXPORT))
    }

    /// All numbers of an accessor, after everything that the file claims about it was checked.
    fn numbers(
        &self,
        accessor: &Accessor<'_>,
        types: &[DataType],
        dimensions: &[Dimensions],
    ) -> Outcome<Vec<f64>> {
        let place = format!("accessor {}", accessor.index());
        let refuse = |what: &str| self.input.error(&place, what).help(EXPORT);
        if !types.contains(&accessor.data_type()) || !dimensions.contains(&accessor.dimensions()) {
            return Err(refuse(&format!(
                "{:?} of {:?} is not what this attribute is made of",
                accessor.dimensions(),
                accessor.data_type()
            )));
        }
        if accessor.sparse().is_some() {
            return Err(refuse("it is sparse, which is not read"));
        }
        let Some(view) = accessor.view() else {
            return Err(refuse("it has no buffer view"));
        };
        let buffer = self
            .buffers
            .get(view.buffer().index())
            .map_or(&[][..], Vec::as_slice);
        let bytes = view
            .offset()
            .checked_add(view.length())
            .and_then(|end| buffer.get(view.offset()..end))
            .and_then(|bytes| bytes.get(accessor.offset()..))
            .unwrap_or_default();
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(refuse(&format!("a stride of {stride} bytes for {size}")));
        }
        let need = match accessor.count() {
            0 => Some(0),
            n => stride.checked_mul(n - 1).and_then(|s| s.checked_add(size)),
        };
        if need.is_none_or(|need| need > bytes.len()) {
            let what = format!(
                "{} elements of {stride} bytes do not fit into the {} bytes left in buffer view {}",
                accessor.count(),
                bytes.len(),
                view.index()
            );
            return Err(self.input.cut_short(&place, &what));
        }
        let width = accessor.dimensions().multiplicity();
        let mut numbers = Vec::with_capacity(accessor.count() * width);
        for element in bytes.chunks(stride).take(accessor.count()) {
            let element = &element[..size];
            match accessor.data_type() {
                DataType::U8 => numbers.extend(element.iter().map(|&b| f64::from(b))),
                DataType::U16 => numbers.extend(
                    element
                        .as_chunks()
                        .0
                        .iter()
                        .map(|&b| f64::from(u16::from_le_bytes(b))),
                ),
                DataType::U32 => numbers.extend(
                    element
                        .as_chunks()
                        .0
                        .iter()
                        .map(|&b| f64::from(u32::from_le_bytes(b))),
                ),
                _ => numbers.extend(
                    element
                        .as_chunks()
                        .0
                        .iter()
                        .map(|&b| f64::from(f32::from_le_bytes(b))),
                ),
            }
        }
        Ok(numbers)
    }

    fn finish(mut self) -> Soup {
        if !self.coloured {
            self.soup.colours = Vec::new();
        }
        let name = &self.input.name;
        if self.textured {
            self.soup.warnings.push(format!(
                "{name}: textures are not read; vertex colours and base colours are"
            ));
        }
        if self.skipped > 0 {
            self.soup.warnings.push(format!(
                "{name}: {} primitives of points or lines skipped",
                self.skipped
            ));
        }
        self.soup
    }
}

/// Linear 0 to 1 as an sRGB byte (IEC 61966-2-1).
fn srgb(linear: f64) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 {
        12.92 * c
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * encoded).round() as u8
}

fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().to_owned()
}
