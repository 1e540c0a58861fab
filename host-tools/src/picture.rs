//! Pictures: 8-bit RGB with or without coverage, as PNG, and as the panel's RGB565 words.

use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Encoder, Transformations, chunk};

use crate::failure::{Failure, Outcome};
use crate::replace::replace;

/// The most pixels that are read from a PNG; its header may claim any number.
pub(crate) const MAX_PIXELS: u64 = 1 << 26;

/// A picture, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels. Where coverage is partial, the mean over the whole pixel with
    /// the background black (premultiplied, in other words).
    pub rgb: Vec<[u8; 3]>,
    /// How much of each pixel is covered, 0 to 255 for none to all; `None` when that is not
    /// known and a covered pixel is one that differs from the background.
    pub coverage: Option<Vec<u8>>,
    /// What stands behind, if that is known: then `rgb` has its part of it.
    pub background: Option<[u8; 3]>,
}

impl Picture {
    /// A picture in one colour, without coverage.
    #[must_use]
    pub fn filled(width: u32, height: u32, colour: [u8; 3]) -> Self {
        Self {
            width,
            height,
            rgb: vec![colour; width as usize * height as usize],
            coverage: None,
            background: None,
        }
    }

    /// A frame of RGB565 words, rows from the top, expanded by bit replication.
    ///
    /// # Panics
    /// When the words are not `width * height`.
    #[must_use]
    pub fn from_rgb565(width: u32, height: u32, words: &[u16]) -> Self {
        assert_eq!(
            words.len(),
            width as usize * height as usize,
            "one word a pixel"
        );
        Self {
            width,
            height,
            rgb: words.iter().copied().map(rgb888).collect(),
            coverage: None,
            background: None,
        }
    }

    /// The frame as RGB565 words, each channel rounded to nearest.
    #[must_use]
    pub fn to_rgb565(&self) -> Vec<u16> {
        self.rgb.iter().copied().map(rgb565).collect()
    }

    /// Reads a PNG of any kind as 8-bit RGB; its alpha becomes the coverage, and its `bKGD` the
    /// background.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read, is not a PNG, is damaged, or has more than 2^26
    /// pixels.
    pub fn read(path: &Path) -> Outcome<Self> {
        let bytes = read_file(path)?;
        Self::from_png(&bytes, &path.display().to_string())
    }

    /// Reads a PNG from memory; `name` stands in messages.
    ///
    /// # Errors
    /// As [`Picture::read`].
    pub fn from_png(bytes: &[u8], name: &str) -> Outcome<Self> {
        let (info, data) = decode(
            bytes,
            name,
            Transformations::EXPAND | Transformations::STRIP_16,
        )?;
        let (rgb, coverage) = match info.color_type {
            ColorType::Rgb => (data.as_chunks::<3>().0.to_vec(), None),
            ColorType::Rgba => {
                let pixels = data.as_chunks::<4>().0;
                (
                    pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect(),
                    Some(pixels.iter().map(|p| p[3]).collect()),
                )
            }
            ColorType::GrayscaleAlpha => {
                let pixels = data.as_chunks::<2>().0;
                (
                    pixels.iter().map(|&[v, _]| [v; 3]).collect(),
                    Some(pixels.iter().map(|p| p[1]).collect()),
                )
            }
            _ => (data.iter().map(|&v| [v; 3]).collect(), None),
        };
        Ok(Self {
            width: info.width,
            height: info.height,
            rgb,
            coverage,
            background: info.background,
        })
    }

    /// The picture as a PNG, RGB or (with coverage) RGBA, always the same bytes for the same
    /// picture.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let (kind, data) = match &self.coverage {
            None => (ColorType::Rgb, self.rgb.as_flattened().to_vec()),
            Some(coverage) => {
                let pixels = self.rgb.iter().zip(coverage);
                let data = pixels.flat_map(|(&[r, g, b], &a)| [r, g, b, a]).collect();
                (ColorType::Rgba, data)
            }
        };
        let head = Head {
            width: self.width,
            height: self.height,
            kind,
            depth: BitDepth::Eight,
            background: self.background,
            texts: &[],
        };
        encode(&head, &data)
    }

    /// Replaces the PNG at `path`, at once and whole.
    ///
    /// # Errors
    /// Exit 2 when it cannot be written.
    pub fn write(&self, path: &Path) -> Outcome {
        replace(path, &self.to_png())
    }
}

/// Eight bits a channel as RGB565, each channel rounded to nearest.
#[must_use]
pub fn rgb565([r, g, b]: [u8; 3]) -> u16 {
    let to = |value: u8, full: u16| (u16::from(value) * full + 127) / 255;
    to(r, 31) << 11 | to(g, 63) << 5 | to(b, 31)
}

/// RGB565 as eight bits a channel, the upper bits repeated below.
#[must_use]
pub fn rgb888(word: u16) -> [u8; 3] {
    let (r, g, b) = (word >> 11, word >> 5 & 63, word & 31);
    [r << 3 | r >> 2, g << 2 | g >> 4, b << 3 | b >> 2].map(|channel| channel as u8)
}

/// The bytes of a file, which must be one.
pub(crate) fn read_file(path: &Path) -> Outcome<Vec<u8>> {
    std::fs::read(path).map_err(|error| {
        Failure::input(format!("cannot read {}: {error}", path.display()))
            .help("name a PNG, such as one that `rho render` wrote")
    })
}

/// What a PNG is, and its rows.
pub(crate) struct PngInfo {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) color_type: ColorType,
    pub(crate) bit_depth: BitDepth,
    /// The bKGD chunk, of 8 bits a channel.
    pub(crate) background: Option<[u8; 3]>,
    /// The tEXt chunks.
    pub(crate) texts: Vec<(String, String)>,
}

pub(crate) fn decode(
    bytes: &[u8],
    name: &str,
    transformations: Transformations,
) -> Outcome<(PngInfo, Vec<u8>)> {
    let bad = |what: String| {
        Failure::input(format!("{name}: {what}"))
            .help("name a PNG, such as one that `rho render` wrote")
    };
    let mut decoder = Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(transformations);
    let mut reader = decoder.read_info().map_err(|e| bad(e.to_string()))?;
    let (width, height) = reader.info().size();
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(bad(format!("{width}x{height} pixels are too many")));
    }
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| bad(format!("{width}x{height} pixels are too many")))?;
    let mut data = vec![0; size];
    let frame = reader
        .next_frame(&mut data)
        .map_err(|e| bad(e.to_string()))?;
    data.truncate(frame.buffer_size());
    let texts = &reader.info().uncompressed_latin1_text;
    Ok((
        PngInfo {
            width,
            height,
            color_type: frame.color_type,
            bit_depth: frame.bit_depth,
            background: match reader.info().bkgd.as_deref() {
                Some(&[0, r, 0, g, 0, b]) => Some([r, g, b]),
                _ => None,
            },
            texts: texts
                .iter()
                .map(|t| (t.keyword.clone(), t.text.clone()))
                .collect(),
        },
        data,
    ))
}

/// # Panics
/// When `data` is not what the size and the kind ask for: the callers' own arithmetic.
pub(crate) fn encode(head: &Head<'_>, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, head.width, head.height);
    encoder.set_color(head.kind);
    encoder.set_depth(head.depth);
    let written = head
        .texts
        .iter()
        .try_for_each(|(key, text)| encoder.add_text_chunk((*key).to_owned(), text.clone()))
        .and_then(|()| encoder.write_header())
        .and_then(|mut writer| {
            if let Some([r, g, b]) = head.background {
                writer.write_chunk(chunk::bKGD, &[0, r, 0, g, 0, b])?;
            }
            writer.write_image_data(data)?;
            writer.finish()
        });
    written.expect("a picture has at least one pixel, and memory does not fail to be written");
    bytes
}

/// What a PNG says before its rows.
pub(crate) struct Head<'a> {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) kind: ColorType,
    pub(crate) depth: BitDepth,
    /// The bKGD chunk, of 8 bits a channel.
    pub(crate) background: Option<[u8; 3]>,
    /// tEXt chunks.
    pub(crate) texts: &'a [(&'a str, String)],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(coverage: bool) -> Picture {
        Picture {
            width: 3,
            height: 2,
            rgb: (0..6).map(|i| [i * 40, 255 - i, i]).collect(),
            coverage: coverage.then(|| vec![0, 51, 128, 255, 1, 254]),
            background: coverage.then_some([8, 0, 255]),
        }
    }

    #[test]
    fn a_picture_comes_back_from_its_png() {
        for picture in [sample(false), sample(true)] {
            let png = picture.to_png();
            assert_eq!(Picture::from_png(&png, "a.png").unwrap(), picture);
            assert_eq!(picture.to_png(), png);
        }
    }

    #[test]
    fn a_damaged_or_foreign_file_is_refused_with_its_name() {
        let png = sample(true).to_png();
        for length in 0..png.len() - 12 {
            // The end mark may lack: all pixels are there.
            if let Err(failure) = Picture::from_png(&png[..length], "cut.png") {
                assert!(failure.message.contains("cut.png"));
            }
        }
        assert!(Picture::from_png(b"ply\n", "a.ply").is_err());
        assert!(Picture::read(Path::new("/no/such.png")).is_err());
        for i in 0..png.len() {
            for bit in 0..8 {
                let mut png = png.clone();
                png[i] ^= 1 << bit;
                let _ = Picture::from_png(&png, "flipped.png");
            }
        }
    }

    #[test]
    fn rgb565_rounds_to_nearest_and_comes_back_unchanged() {
        for value in 0..=255u8 {
            let [r, g, b] = rgb888(rgb565([value; 3])).map(i32::from);
            // Half a step of 255/31 and of 255/63, and what bit replication adds.
            let value = i32::from(value);
            assert!(
                (r - value).abs() <= 5 && (b - value).abs() <= 5,
                "{value} {r}"
            );
            assert!((g - value).abs() <= 3, "{value} {g}");
        }
        for word in 0..=u16::MAX {
            assert_eq!(rgb565(rgb888(word)), word);
        }
        assert_eq!(rgb565([255, 0, 255]), 0xf81f);
        assert_eq!(rgb888(0x07e0), [0, 255, 0]);
    }

    #[test]
    fn words_become_a_picture_of_the_same_words() {
        let words = [0, 0xffff, 0x1234, 0xabcd];
        assert_eq!(Picture::from_rgb565(2, 2, &words).to_rgb565(), words);
    }
}
