//! The blob: a view of bytes in flash, checked once, then read without failing.
//!
//! [`Blob::parse`] is the one check. It reads every byte once, in order, without recursion and
//! with a stack that does not depend on the input. Holding a [`Blob`] proves that its header and
//! pages carry the right CRC and that all sections are consistent; holding a [`Grid`] proves that
//! every mask names existing children and every sample an existing material, so that no accessor
//! can fail. SPEC.md has the bytes.

pub mod error;
pub mod facing;
pub mod format;
mod grid;
pub mod layout;
pub mod scene;

pub use error::BlobError;
pub use grid::{Attributes, Fineness, Grid, Level};
pub use layout::Layout;
pub use scene::{Instance, Light, Object};

use format::{
    CRC, ENTRY_BYTES, HEADER_BYTES, MAGIC, MATERIAL_BYTES, MAX_MATERIALS, MAX_SCENE_MATERIALS,
    MAX_SECTIONS, OPTIONAL, PAGE_BYTES, VERSION, kind,
};

/// A checked blob; see the module's page for what holding one proves.
#[derive(Clone, Copy, Debug)]
pub struct Blob<'a> {
    bytes: &'a [u8],
    grids: u16,
    /// The place of the first section of each kind, by [`known`]; [`MAX_SECTIONS`] or more if there is none.
    firsts: [u16; KNOWN],
}

/// How many kinds of sections the renderer reads.
const KNOWN: usize = 11;

/// Of the kinds of sections, the number of this one.
#[inline(always)]
fn known(kind: u16) -> Option<usize> {
    match kind {
        kind::GRID..=kind::CAMERA => Some(usize::from(kind - kind::GRID)),
        kind::ORIGIN => Some(KNOWN - 2),
        kind::FACING => Some(KNOWN - 1),
        _ => None,
    }
}

/// How a surface answers light ([`crate::lighting`] has the formula), each 32768 = 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Material {
    /// Red, green, blue in the shade.
    pub ambient: [u16; 3],
    /// Red, green, blue added where the light falls squarely.
    pub diffuse: [u16; 3],
    /// Phong colour.
    pub specular: [u16; 3],
    /// Phong exponent.
    pub exponent: u16,
}

impl Material {
    fn read(m: &[u8]) -> Self {
        let rgb = |at| [u16_at(m, at), u16_at(m, at + 2), u16_at(m, at + 4)];
        Self {
            ambient: rgb(0),
            diffuse: rgb(6),
            specular: rgb(12),
            exponent: u16_at(m, 18),
        }
    }
}

/// One entry of the directory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section<'a> {
    /// See [`format::kind`].
    pub kind: u16,
    /// The grid it belongs to.
    pub grid: u16,
    /// Its bytes.
    pub bytes: &'a [u8],
}

impl<'a> Blob<'a> {
    /// Checks `bytes`, which begin with a blob and may go on after it (a region of flash).
    ///
    /// # Errors
    /// The first reason found to refuse it.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, BlobError> {
        let header: &[u8; HEADER_BYTES] = match bytes.first_chunk() {
            Some(header) => header,
            None if bytes.is_empty() => return Err(BlobError::Missing),
            None if MAGIC.starts_with(bytes) || bytes.starts_with(&MAGIC) => {
                return Err(BlobError::Truncated {
                    expected: HEADER_BYTES as u32,
                    found: bytes.len() as u32,
                });
            }
            None => return Err(BlobError::NotABlob),
        };
        if !header.starts_with(&MAGIC) {
            let empty = |byte| header.iter().all(|b| *b == byte);
            return Err(if empty(0) || empty(0xFF) {
                BlobError::Missing
            } else {
                BlobError::NotABlob
            });
        }
        let version = u16_at(header, 8);
        if version > VERSION {
            return Err(BlobError::Newer { version });
        }
        let length = u32_at(header, 12);
        let body = u32_at(header, 16) as usize;
        let page_bytes = u32_at(header, 20) as usize;
        let sections = u32_at(header, 24) as usize;
        let expected = HEADER_BYTES + ENTRY_BYTES * sections.min(MAX_SECTIONS);
        let pages = (length as usize).saturating_sub(body).div_ceil(PAGE_BYTES);
        if version == 0
            || usize::from(u16_at(header, 10)) != HEADER_BYTES
            || page_bytes != PAGE_BYTES
            || sections > MAX_SECTIONS
            || !length.is_multiple_of(4)
            || body > length as usize
            || body != expected.saturating_add(pages.saturating_mul(4))
        {
            return Err(BlobError::Header);
        }
        let Some(bytes) = bytes.get(..length as usize) else {
            return Err(BlobError::Truncated {
                expected: length,
                found: bytes.len() as u32,
            });
        };
        if !bytes.as_ptr().addr().is_multiple_of(4) {
            return Err(BlobError::Misaligned);
        }

        let mut crc = CRC.digest();
        crc.update(slice(bytes, 0, 28));
        crc.update(slice(bytes, HEADER_BYTES, body - HEADER_BYTES));
        if crc.finalize() != u32_at(header, 28) {
            return Err(cut_or(bytes, BlobError::HeaderCrc));
        }
        let table = slice(bytes, expected, 4 * pages);
        for (page, data) in slice(bytes, body, bytes.len() - body)
            .chunks(PAGE_BYTES)
            .enumerate()
        {
            if CRC.checksum(data) != u32_at(table, 4 * page) {
                return Err(cut_or(bytes, BlobError::PageCrc { page: page as u32 }));
            }
        }

        let mut blob = Self {
            bytes,
            grids: 0,
            firsts: [u16::MAX; KNOWN],
        };
        blob.check_directory(body)?;
        let materials = blob.required(kind::MATERIALS, 0)?;
        let count = materials.len() / MATERIAL_BYTES;
        let most = match blob.find(kind::OBJECTS, 0) {
            Some(_) => MAX_SCENE_MATERIALS,
            None => MAX_MATERIALS,
        };
        if count == 0 || count > most || !materials.len().is_multiple_of(MATERIAL_BYTES) {
            return Err(BlobError::Section {
                kind: kind::MATERIALS,
            });
        }
        while blob.find(kind::GRID, blob.grids).is_some() {
            let of_object = blob.sample_materials(blob.grids);
            Grid::check(&blob, blob.grids, of_object.unwrap_or(count))?;
            blob.grids += 1;
        }
        if blob.grids == 0 {
            return Err(BlobError::MissingSection { kind: kind::GRID });
        }
        blob.check_owners()?;
        blob.check_scene()?;
        Ok(blob)
    }

    /// The whole blob.
    #[must_use]
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// How many grids there are, at least 1.
    #[must_use]
    pub fn grid_count(&self) -> u16 {
        self.grids
    }

    /// Grid `index`, or `None` from [`Self::grid_count`] on.
    #[must_use]
    pub fn grid(&self, index: u16) -> Option<Grid<'a>> {
        if index < self.grids {
            Grid::view(self, index).ok()
        } else {
            None
        }
    }

    /// The finenesses of these grids: less work than [`Self::grid`] of each.
    pub fn finenesses(
        &self,
        grids: core::ops::Range<u16>,
    ) -> impl Iterator<Item = Fineness> + use<'a> {
        let blob = *self;
        grids.map(move |index| grid::fineness(blob.find(kind::GRID, index).unwrap_or_default()))
    }

    /// The layouts of all grids: less work than [`Self::grids`].
    pub fn layouts(&self) -> impl Iterator<Item = Layout> + use<'a> {
        let blob = *self;
        (0..self.grids)
            .map(move |index| grid::layout(blob.find(kind::GRID, index).unwrap_or_default()))
    }

    /// All grids, in the order of their indices: the same model in other cells, say.
    pub fn grids(&self) -> impl Iterator<Item = Grid<'a>> + use<'a> {
        let blob = *self;
        (0..self.grids).filter_map(move |index| blob.grid(index))
    }

    /// The materials: 1 to 8, with several objects up to 32.
    pub fn materials(&self) -> impl ExactSizeIterator<Item = Material> + Clone + use<'a> {
        self.find(kind::MATERIALS, 0)
            .unwrap_or_default()
            .chunks_exact(MATERIAL_BYTES)
            .map(Material::read)
    }

    /// Material `index`, if there is one.
    #[must_use]
    pub fn material(&self, index: u16) -> Option<Material> {
        let bytes = self.find(kind::MATERIALS, 0).unwrap_or_default();
        let mut all = bytes.chunks_exact(MATERIAL_BYTES);
        all.nth(index.into()).map(Material::read)
    }

    /// Where the blob comes from: lines `key=value`; empty when it does not say.
    #[must_use]
    pub fn origin(&self) -> &'a str {
        core::str::from_utf8(self.find(kind::ORIGIN, 0).unwrap_or_default()).unwrap_or_default()
    }

    /// Every section, in the order of the directory.
    pub fn sections(&self) -> impl Iterator<Item = Section<'a>> + use<'a> {
        let blob = *self;
        (0..u32_at(self.bytes, 24) as usize).map(move |i| blob.section(i))
    }

    /// Section `i` of the directory.
    fn section(&self, i: usize) -> Section<'a> {
        let (bytes, entry) = (self.bytes, HEADER_BYTES + ENTRY_BYTES * i);
        Section {
            kind: u16_at(bytes, entry),
            grid: u16_at(bytes, entry + 2),
            bytes: slice(
                bytes,
                u32_at(bytes, entry + 4) as usize,
                u32_at(bytes, entry + 8) as usize,
            ),
        }
    }

    fn check_directory(&mut self, body: usize) -> Result<(), BlobError> {
        let mut end = body;
        for i in 0..u32_at(self.bytes, 24) as usize {
            let entry = HEADER_BYTES + ENTRY_BYTES * i;
            let kind = u16_at(self.bytes, entry);
            let offset = u32_at(self.bytes, entry + 4) as usize;
            let length = u32_at(self.bytes, entry + 8) as usize;
            if kind & OPTIONAL == 0 && !(kind::GRID..=kind::CAMERA).contains(&kind) {
                return Err(BlobError::UnknownSection { kind });
            }
            let last = offset.checked_add(length);
            if !offset.is_multiple_of(4)
                || offset < end
                || last.is_none_or(|last| last > self.bytes.len())
            {
                return Err(BlobError::Section { kind });
            }
            end = offset + length;
            if let Some(first) = known(kind).and_then(|known| self.firsts.get_mut(known)) {
                *first = (*first).min(i as u16);
            }
        }
        Ok(())
    }

    /// Each part of a grid belongs to one that is there, and no section is there twice.
    fn check_owners(&self) -> Result<(), BlobError> {
        let owned = |kind| known(kind).is_some() && kind != kind::ORIGIN;
        for section in self.sections().filter(|s| owned(s.kind)) {
            let of_blob = (kind::MATERIALS..=kind::CAMERA).contains(&section.kind);
            let owners = if of_blob { 1 } else { self.grids };
            let same = |s: &Section<'_>| (s.kind, s.grid) == (section.kind, section.grid);
            if section.grid >= owners || self.sections().filter(same).count() != 1 {
                return Err(BlobError::Section { kind: section.kind });
            }
        }
        Ok(())
    }

    /// The first section of this kind of grid `grid`, or of the blob (0).
    ///
    /// The parts of grids mostly follow each other: no search then.
    fn find(&self, kind: u16, grid: u16) -> Option<&'a [u8]> {
        let first = usize::from(self.firsts.get(known(kind)?).copied()?);
        let step = if kind <= kind::ATTRIBUTES {
            usize::from(kind::ATTRIBUTES)
        } else {
            1
        };
        let is_it = |s: &Section<'_>| s.kind == kind && s.grid == grid;
        let count = u32_at(self.bytes, 24) as usize;
        let guess = first + step * usize::from(grid);
        let guess = (guess < count).then(|| self.section(guess)).filter(is_it);
        let found = guess.or_else(|| (first..count).map(|i| self.section(i)).find(is_it));
        found.map(|section| section.bytes)
    }

    fn required(&self, kind: u16, grid: u16) -> Result<&'a [u8], BlobError> {
        self.find(kind, grid)
            .ok_or(BlobError::MissingSection { kind })
    }

    /// A section as words of 32 bits.
    fn words(&self, kind: u16, grid: u16) -> Result<&'a [u32], BlobError> {
        const { assert!(cfg!(target_endian = "little"), "blobs are read in place") };
        bytemuck::try_cast_slice(self.required(kind, grid)?)
            .map_err(|_| BlobError::Section { kind })
    }
}

/// A copy that ended early leaves 00 or erased flash (FF) up to the blob's end: told apart from
/// damage, since the cure is another.
fn cut_or(bytes: &[u8], error: BlobError) -> BlobError {
    let Some((last @ (0 | 0xFF), _)) = bytes.split_last() else {
        return error;
    };
    let found = bytes.iter().rposition(|b| b != last).map_or(0, |i| i + 1);
    // Some bytes of a whole blob's end may be 00 by chance, a page of them is no chance.
    if bytes.len() - found < 16 {
        return error;
    }
    BlobError::Truncated {
        expected: bytes.len() as u32,
        found: found as u32,
    }
}

/// The u16 at `at`, 0 beyond the end.
fn u16_at(bytes: &[u8], at: usize) -> u16 {
    bytes
        .get(at..)
        .and_then(|b| b.first_chunk())
        .map_or(0, |b| u16::from_le_bytes(*b))
}

/// The u32 at `at`, 0 beyond the end.
fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes
        .get(at..)
        .and_then(|b| b.first_chunk())
        .map_or(0, |b| u32::from_le_bytes(*b))
}

/// `length` bytes from `at`, none if they are not all there.
fn slice(bytes: &[u8], at: usize, length: usize) -> &[u8] {
    at.checked_add(length)
        .and_then(|end| bytes.get(at..end))
        .unwrap_or_default()
}
