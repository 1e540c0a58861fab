//! What a host asks of a device: one line of text.
//!
//! ```text
//! picture=model rotation=1073741824;0;0;0;1073741824;0;0;0;1073741824
//!   translation=0;0;-2399456 focal=1582163 size=240;320 light=6521;9781;11412
//!   visibility=eye footprint=box reciprocal=divide frame=words grid=0 fineness=none cell_size=128
//!   shadows=two-pass shadow_map=128 light_splat=2
//! ```
//!
//! (broken here for the page; blanks separate the parts). A number is the integer of its Q
//! format, so that host and device draw from the same bits. Nothing is optional and nothing
//! has a default: a part that is missing, unknown, repeated or out of range is an error that
//! names it. There is no comma in a line, because the command line of the emulator's
//! semihosting cannot hold a plain one.

use core::fmt::{self, Write};
use core::num::IntErrorKind;

use heapless::String;
use rho_grid::camera::Camera;
use rho_grid::mode::{LightSplat, MapSize, Mode, Preset, UnknownName};
use rho_grid::q::{Focal, Length, PixelSize, Rotation, Unit};

/// The longest line: every number at its longest is 305 bytes.
pub const MAX_LINE: usize = 512;

/// What a device draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// The model in the board's flash.
    Model(Scene),
    /// Colours, gradients and corner marks: the first image wanted on a new board.
    TestCard,
    /// Code of known lengths, which tells whether the counter reads true.
    CountLoop,
}

/// Everything that a picture of a model depends on, but the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scene {
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Towards the light, in the world, of length 1.
    pub light: [Unit; 3],
    /// How it is drawn.
    pub mode: Mode,
}

/// Why a line is no request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RequestError {
    /// The key is not there.
    Missing(&'static str),
    /// There is no such key for this picture (cut to its first bytes).
    Unknown(String<24>),
    /// The key is there twice.
    Repeated(&'static str),
    /// A part without `=` (cut to its first bytes).
    NoValue(String<24>),
    /// The value holds something that is no integer.
    NotANumber(&'static str),
    /// The value holds too few or too many integers.
    Count {
        /// The key.
        key: &'static str,
        /// How many integers it takes.
        expected: usize,
    },
    /// A number lies outside its range.
    OutOfRange {
        /// The key.
        key: &'static str,
        /// The least allowed.
        low: i64,
        /// The largest allowed.
        high: i64,
    },
    /// The value is none of the names.
    Choice {
        /// The key.
        key: &'static str,
        /// The names there are.
        expected: &'static str,
    },
}

impl fmt::Display for RequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(key) => write!(f, "{key} is missing"),
            Self::Unknown(key) => write!(f, "there is no {key} for this picture"),
            Self::Repeated(key) => write!(f, "{key} is there twice"),
            Self::NoValue(part) => write!(f, "{part} has no value"),
            Self::NotANumber(key) => write!(f, "{key} takes integers"),
            Self::Count { key, expected } => write!(f, "{key} takes {expected} integers"),
            Self::OutOfRange { key, low, high } => {
                write!(f, "{key} is out of range ({low} to {high})")
            }
            Self::Choice { key, expected } => write!(f, "{key}: expected one of: {expected}"),
        }
    }
}

impl core::error::Error for RequestError {}

const PICTURES: &str = "model, test-card, count-loop";

/// The parts of a line, by the order of [`KEYS`].
#[derive(Clone, Copy)]
enum Key {
    Picture,
    Rotation,
    Translation,
    Focal,
    Size,
    Light,
    Visibility,
    Footprint,
    Reciprocal,
    Frame,
    Grid,
    Fineness,
    CellSize,
    Shadows,
    ShadowMap,
    LightSplat,
}

const KEYS: [&str; 16] = [
    "picture",
    "rotation",
    "translation",
    "focal",
    "size",
    "light",
    "visibility",
    "footprint",
    "reciprocal",
    "frame",
    "grid",
    "fineness",
    "cell_size",
    "shadows",
    "shadow_map",
    "light_splat",
];

/// The value of each key that is still to be read.
struct Parts<'a>([Option<&'a str>; KEYS.len()]);

impl<'a> Parts<'a> {
    fn split(line: &'a str) -> Result<Self, RequestError> {
        let mut parts = [None; KEYS.len()];
        for part in line.split_ascii_whitespace() {
            let (name, value) = part
                .split_once('=')
                .ok_or_else(|| RequestError::NoValue(cut(part)))?;
            let (key, slot) = KEYS
                .iter()
                .zip(&mut parts)
                .find(|(key, _)| **key == name)
                .ok_or_else(|| RequestError::Unknown(cut(name)))?;
            if slot.replace(value).is_some() {
                return Err(RequestError::Repeated(key));
            }
        }
        Ok(Self(parts))
    }

    fn take(&mut self, key: Key) -> Result<&'a str, RequestError> {
        self.0[key as usize]
            .take()
            .ok_or(RequestError::Missing(KEYS[key as usize]))
    }

    fn numbers<const N: usize>(
        &mut self,
        key: Key,
        low: i64,
        high: i64,
    ) -> Result<[i64; N], RequestError> {
        let text = self.take(key)?;
        let key = KEYS[key as usize];
        let count = RequestError::Count { key, expected: N };
        let mut words = text.split(';');
        let mut numbers = [0; N];
        for number in &mut numbers {
            let word = words.next().ok_or_else(|| count.clone())?;
            let range = RequestError::OutOfRange { key, low, high };
            *number = word.parse().map_err(|e| integer_error(&e, key, &range))?;
            if !(low..=high).contains(number) {
                return Err(range);
            }
        }
        match words.next() {
            None => Ok(numbers),
            Some(_) => Err(count),
        }
    }

    fn choice<T: core::str::FromStr<Err = UnknownName>>(
        &mut self,
        key: Key,
    ) -> Result<T, RequestError> {
        self.take(key)?
            .parse()
            .map_err(|e: UnknownName| RequestError::Choice {
                key: KEYS[key as usize],
                expected: e.expected,
            })
    }

    /// The same, or the word `none`.
    fn choice_or_none<T: core::str::FromStr<Err = UnknownName>>(
        &mut self,
        key: Key,
    ) -> Result<Option<T>, RequestError> {
        if self.0[key as usize] == Some("none") {
            self.0[key as usize] = None;
            return Ok(None);
        }
        self.choice(key).map(Some)
    }

    fn nothing_left(&self) -> Result<(), RequestError> {
        match KEYS.iter().zip(&self.0).find(|(_, part)| part.is_some()) {
            None => Ok(()),
            Some((key, _)) => Err(RequestError::Unknown(cut(key))),
        }
    }
}

fn integer_error(
    error: &core::num::ParseIntError,
    key: &'static str,
    range: &RequestError,
) -> RequestError {
    match error.kind() {
        IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => range.clone(),
        _ => RequestError::NotANumber(key),
    }
}

/// The beginning of a text, for a message.
fn cut(text: &str) -> String<24> {
    let mut short = String::new();
    for c in text.chars() {
        if short.push(c).is_err() {
            break;
        }
    }
    short
}

/// Narrows what a range check has already bounded.
macro_rules! narrow {
    ($value:expr, $type:ty, $key:literal) => {
        <$type>::try_from($value).map_err(|_| RequestError::OutOfRange {
            key: $key,
            low: <$type>::MIN.into(),
            high: <$type>::MAX.into(),
        })
    };
}

impl Request {
    /// Reads a line.
    ///
    /// # Errors
    /// What is missing, unknown, repeated or out of range, by name.
    pub fn parse(line: &str) -> Result<Self, RequestError> {
        let mut parts = Parts::split(line)?;
        let request = match parts.take(Key::Picture)? {
            "model" => Self::Model(Scene::parse(&mut parts)?),
            "test-card" => Self::TestCard,
            "count-loop" => Self::CountLoop,
            _ => {
                return Err(RequestError::Choice {
                    key: "picture",
                    expected: PICTURES,
                });
            }
        };
        parts.nothing_left()?;
        Ok(request)
    }

    /// The name of the picture in a line.
    #[must_use]
    pub fn picture(&self) -> &'static str {
        match self {
            Self::Model(_) => "model",
            Self::TestCard => "test-card",
            Self::CountLoop => "count-loop",
        }
    }

    /// The line, which always fits.
    #[must_use]
    pub fn line(&self) -> String<MAX_LINE> {
        let mut line = String::new();
        // MAX_LINE holds the longest; a test writes it.
        let _ = write!(line, "{self}");
        line
    }
}

impl Scene {
    fn parse(parts: &mut Parts<'_>) -> Result<Self, RequestError> {
        const ONE: i64 = 1 << 30;
        const UNIT: i64 = 1 << 14;
        let r: [i64; 9] = parts.numbers(Key::Rotation, -ONE, ONE)?;
        let t: [i64; 3] = parts.numbers(Key::Translation, i32::MIN.into(), i32::MAX.into())?;
        let [focal] = parts.numbers(Key::Focal, 1, u32::MAX.into())?;
        let [width, height] = parts.numbers(Key::Size, 1, Camera::MAX_SIDE.into())?;
        let l: [i64; 3] = parts.numbers(Key::Light, -UNIT, UNIT)?;
        let mut rotation = [[Rotation::ZERO; 3]; 3];
        for (entry, bits) in rotation.as_flattened_mut().iter_mut().zip(r) {
            *entry = Rotation::from_bits(narrow!(bits, i32, "rotation")?);
        }
        let mut translation = [Length::ZERO; 3];
        for (entry, bits) in translation.iter_mut().zip(t) {
            *entry = Length::from_bits(narrow!(bits, i32, "translation")?);
        }
        let mut light = [Unit::ZERO; 3];
        for (entry, bits) in light.iter_mut().zip(l) {
            *entry = Unit::from_bits(narrow!(bits, i16, "light")?);
        }
        Ok(Self {
            camera: Camera {
                rotation,
                translation,
                focal: Focal::from_bits(narrow!(focal, u32, "focal")?),
                width: narrow!(width, u16, "size")?,
                height: narrow!(height, u16, "size")?,
            },
            light,
            mode: Mode {
                visibility: parts.choice(Key::Visibility)?,
                footprint: parts.choice(Key::Footprint)?,
                reciprocal: parts.choice(Key::Reciprocal)?,
                frame: parts.choice(Key::Frame)?,
                grid: {
                    let [index] = parts.numbers(Key::Grid, 0, u16::MAX.into())?;
                    narrow!(index, u16, "grid")?
                },
                fineness: parts.choice_or_none(Key::Fineness)?,
                cell_size: {
                    let [bits] = parts.numbers(Key::CellSize, 0, u16::MAX.into())?;
                    PixelSize::from_bits(narrow!(bits, u16, "cell_size")?)
                },
                shadows: parts.choice(Key::Shadows)?,
                shadow_map: {
                    let (low, high) = (64, MapSize::LARGEST.side().into());
                    let [side] = parts.numbers(Key::ShadowMap, low, high)?;
                    let size = MapSize::of(narrow!(side, u16, "shadow_map")?);
                    size.ok_or(RequestError::Choice {
                        key: "shadow_map",
                        expected: "64, 128, 256",
                    })?
                },
                light_splat: {
                    let high = LightSplat::LARGEST.into();
                    let [side] = parts.numbers(Key::LightSplat, 1, high)?;
                    let splat = LightSplat::of(narrow!(side, u16, "light_splat")?);
                    splat.ok_or(RequestError::OutOfRange {
                        key: "light_splat",
                        low: 1,
                        high,
                    })?
                },
            },
        })
    }
}

/// Integers with `;` between.
struct List<'a, T>(&'a [T]);

impl<T: fmt::Display> fmt::Display for List<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, item) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_char(';')?;
            }
            item.fmt(f)?;
        }
        Ok(())
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "picture={}", self.picture())?;
        let Self::Model(Scene {
            camera,
            light,
            mode,
        }) = self
        else {
            return Ok(());
        };
        write!(
            f,
            " rotation={} translation={} focal={} size={};{} light={} visibility={} footprint={} \
             reciprocal={} frame={} grid={} fineness={} cell_size={} shadows={} shadow_map={} \
             light_splat={}",
            List(
                camera
                    .rotation
                    .map(|row| row.map(Rotation::to_bits))
                    .as_flattened()
            ),
            List(&camera.translation.map(Length::to_bits)),
            camera.focal.to_bits(),
            camera.width,
            camera.height,
            List(&light.map(Unit::to_bits)),
            mode.visibility,
            mode.footprint,
            mode.reciprocal,
            mode.frame,
            mode.grid,
            mode.fineness.map_or("none", Preset::name),
            mode.cell_size.to_bits(),
            mode.shadows,
            mode.shadow_map.side(),
            mode.light_splat.texels(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rho_grid::mode::{FootprintMode, FrameMode, ReciprocalMode, ShadowMode, VisibilityMode};
    use std::string::{String as Text, ToString};

    fn scene() -> impl Strategy<Value = Scene> {
        let one = 1 << 30;
        (
            proptest::array::uniform9(-one..=one),
            proptest::array::uniform3(any::<i32>()),
            1..=u32::MAX,
            (1..=Camera::MAX_SIDE, 1..=Camera::MAX_SIDE),
            proptest::array::uniform3(-(1i16 << 14)..=1 << 14),
            (
                proptest::sample::select(VisibilityMode::ALL),
                proptest::sample::select(FootprintMode::ALL),
                proptest::sample::select(ReciprocalMode::ALL),
                proptest::sample::select(FrameMode::ALL),
                any::<u16>(),
                proptest::option::of(proptest::sample::select(Preset::ALL)),
                any::<u16>(),
            ),
            (
                proptest::sample::select(ShadowMode::ALL),
                proptest::sample::select(&MapSize::ALL[..]),
                1..=LightSplat::LARGEST as u16,
            ),
        )
            .prop_map(
                |(
                    r,
                    t,
                    focal,
                    (width, height),
                    light,
                    (v, f, d, frame, grid, fineness, cell),
                    (shadows, shadow_map, splat),
                )| Scene {
                    camera: Camera {
                        rotation: [[r[0], r[1], r[2]], [r[3], r[4], r[5]], [r[6], r[7], r[8]]]
                            .map(|row| row.map(Rotation::from_bits)),
                        translation: t.map(Length::from_bits),
                        focal: Focal::from_bits(focal),
                        width,
                        height,
                    },
                    light: light.map(Unit::from_bits),
                    mode: Mode {
                        visibility: v,
                        footprint: f,
                        reciprocal: d,
                        frame,
                        grid,
                        fineness,
                        cell_size: PixelSize::from_bits(cell),
                        shadows,
                        shadow_map,
                        light_splat: LightSplat::of(splat).unwrap(),
                    },
                },
            )
    }

    fn longest() -> Request {
        Request::Model(Scene {
            camera: Camera {
                rotation: [[Rotation::from_bits(-(1 << 30)); 3]; 3],
                translation: [Length::MIN; 3],
                focal: Focal::MAX,
                width: Camera::MAX_SIDE,
                height: Camera::MAX_SIDE,
            },
            light: [Unit::from_bits(-(1 << 14)); 3],
            mode: Mode {
                footprint: FootprintMode::Splat,
                grid: u16::MAX,
                fineness: Some(Preset::Balanced),
                cell_size: PixelSize::MAX,
                shadows: ShadowMode::TwoPass,
                ..Mode::default()
            },
        })
    }

    proptest! {
        #[test]
        fn a_request_reads_back_as_itself(scene in scene()) {
            let request = Request::Model(scene);
            prop_assert_eq!(Request::parse(&request.line()), Ok(request));
            prop_assert!(!request.line().contains(','));
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in "\\PC*") {
            let _ = Request::parse(&text);
        }

        #[test]
        fn no_value_makes_the_parser_panic(which in 0..KEYS.len(), value in "[-0-9;a-z]*") {
            let line: Text = longest()
                .line()
                .split(' ')
                .map(|part| match part.split_once('=') {
                    Some((key, _)) if key == KEYS[which] => std::format!("{key}={value} "),
                    _ => std::format!("{part} "),
                })
                .collect();
            let _ = Request::parse(&line);
        }
    }

    #[test]
    fn the_longest_line_fits() {
        let line = longest().line();
        assert_eq!(line.as_str(), longest().to_string());
        assert_eq!(Request::parse(&line), Ok(longest()));
    }

    #[test]
    fn pictures_without_a_scene_read_back_as_themselves() {
        for request in [Request::TestCard, Request::CountLoop] {
            assert_eq!(Request::parse(&request.line()), Ok(request));
        }
    }

    #[test]
    fn each_part_that_is_missing_is_named() {
        let line = longest().line();
        for key in KEYS {
            let without: Text = line
                .split(' ')
                .filter(|part| !part.starts_with(&std::format!("{key}=")))
                .flat_map(|part| [part, " "])
                .collect();
            assert_eq!(Request::parse(&without), Err(RequestError::Missing(key)));
        }
    }

    fn with(key: &str, value: &str) -> Result<Request, RequestError> {
        let line: Text = longest()
            .line()
            .split(' ')
            .map(|part| match part.split_once('=') {
                Some((k, _)) if k == key => std::format!("{k}={value} "),
                _ => std::format!("{part} "),
            })
            .collect();
        Request::parse(&line)
    }

    #[test]
    fn a_number_out_of_range_is_an_error_that_tells_the_range() {
        let range = |key, low, high| Err(RequestError::OutOfRange { key, low, high });
        assert_eq!(with("focal", "0"), range("focal", 1, i64::from(u32::MAX)));
        assert_eq!(with("size", "240;1025"), range("size", 1, 1024));
        assert_eq!(with("cell_size", "-1"), range("cell_size", 0, 65_535));
        assert_eq!(with("shadow_map", "512"), range("shadow_map", 64, 256));
        assert_eq!(with("light_splat", "0"), range("light_splat", 1, 4));
        assert_eq!(
            with("light", "0;0;99999999999999999999"),
            range("light", -16_384, 16_384)
        );
    }

    #[test]
    fn a_wrong_count_or_word_is_an_error_by_name() {
        let count = RequestError::Count {
            key: "light",
            expected: 3,
        };
        assert_eq!(with("light", "1;2"), Err(count.clone()));
        assert_eq!(with("light", "1;2;3;4"), Err(count));
        assert_eq!(
            with("light", "1;2;"),
            Err(RequestError::NotANumber("light"))
        );
        assert_eq!(
            with("footprint", "disk"),
            Err(RequestError::Choice {
                key: "footprint",
                expected: "point, splat, box, disc"
            })
        );
        assert_eq!(
            with("shadow_map", "100"),
            Err(RequestError::Choice {
                key: "shadow_map",
                expected: "64, 128, 256"
            })
        );
    }

    #[test]
    fn unknown_repeated_and_valueless_parts_are_errors() {
        let parse = |text| Request::parse(text).unwrap_err();
        assert_eq!(
            parse("picture=test-card colour=1"),
            RequestError::Unknown(cut("colour"))
        );
        assert_eq!(
            parse("picture=test-card focal=1"),
            RequestError::Unknown(cut("focal"))
        );
        assert_eq!(
            parse("picture=test-card picture=test-card"),
            RequestError::Repeated("picture")
        );
        assert_eq!(parse("picture"), RequestError::NoValue(cut("picture")));
        assert_eq!(parse(""), RequestError::Missing("picture"));
        assert_eq!(
            parse("picture=cat").to_string(),
            "picture: expected one of: model, test-card, count-loop"
        );
    }
}
