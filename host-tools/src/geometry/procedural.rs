//! The objects that need no file: their names, their parameters, and how both are written.
//!
//! An object's parameters are a struct with defaults. The command line and scene files give
//! some of them by name; the rest keep their defaults. On the command line a name and its
//! parameters are one word, `terrain:seed=7,height=0.4`, without a character that a shell
//! would take for its own.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;
use std::ops::RangeInclusive;
use toml::{Table, Value};

use super::Geometry;
use super::shapes::Shapes;
use super::sponge::Sponge;
use super::teapot::Teapot;
use super::terrain::Terrain;
use super::tree::{Broad, Willow};

/// The parameters of an object.
pub(super) trait Parameters: Serialize + DeserializeOwned {
    /// Whether the object can be made.
    fn check(&self) -> Result<(), BadParameter>;

    /// Makes the object; the parameters were checked.
    fn make(&self) -> Box<dyn Geometry>;
}

/// A parameter that cannot be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadParameter {
    /// Its name.
    pub name: String,
    /// What is wrong with it, a sentence that goes on after the name.
    pub what: String,
}

impl fmt::Display for BadParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.name, self.what)
    }
}

/// Refuses a number out of its range.
pub(super) fn within<T: Copy + PartialOrd + fmt::Display>(
    name: &str,
    value: T,
    range: RangeInclusive<T>,
) -> Result<(), BadParameter> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(BadParameter {
        name: name.to_owned(),
        what: format!(
            "is {value}, and may be {} to {}",
            range.start(),
            range.end()
        ),
    })
}

/// An object, or why there is none.
pub type Made = Result<Box<dyn Geometry>, BadParameter>;

/// An object that needs no file.
#[derive(Debug)]
pub struct Procedural {
    /// What it goes by.
    pub name: &'static str,
    /// What it is, in a few words.
    pub about: &'static str,
    defaults: fn() -> Table,
    /// From the defaults and what was given.
    check: fn(&Table, &Table) -> Result<(), BadParameter>,
    make: fn(&Table, &Table) -> Made,
}

/// All of them.
pub static PROCEDURAL: [Procedural; 6] = [
    Procedural {
        name: "teapot",
        about: "the Utah teapot on a slab",
        defaults: Table::new,
        check: no_parameters,
        make: |defaults, given| {
            no_parameters(defaults, given)?;
            Ok(Box::new(Teapot::new()))
        },
    },
    Procedural {
        name: "terrain",
        about: "a block of land with mountains and lakes",
        defaults: || table(&Terrain::default()),
        check: |defaults, given| read::<Terrain>(defaults, given).map(drop),
        make: make::<Terrain>,
    },
    Procedural {
        name: "tree",
        about: "a broad tree",
        defaults: || table(&Broad::default()),
        check: |defaults, given| read::<Broad>(defaults, given).map(drop),
        make: make::<Broad>,
    },
    Procedural {
        name: "willow",
        about: "a weeping willow",
        defaults: || table(&Willow::default()),
        check: |defaults, given| read::<Willow>(defaults, given).map(drop),
        make: make::<Willow>,
    },
    Procedural {
        name: "sponge",
        about: "Menger's sponge, cut in half; zoom in without end",
        defaults: || table(&Sponge::default()),
        check: |defaults, given| read::<Sponge>(defaults, given).map(drop),
        make: make::<Sponge>,
    },
    Procedural {
        name: "shapes",
        about: "balls, boxes, rings ... grown together: a rubber duck",
        defaults: || table(&Shapes::default()),
        check: |defaults, given| read::<Shapes>(defaults, given).map(drop),
        make: make::<Shapes>,
    },
];

impl Procedural {
    /// The object of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        PROCEDURAL.iter().find(|object| object.name == name)
    }

    /// Its parameters and their defaults.
    #[must_use]
    pub fn defaults(&self) -> Table {
        (self.defaults)()
    }

    /// Whether the object can be made with these parameters.
    ///
    /// # Errors
    /// As [`Procedural::make`].
    pub fn check(&self, given: &Table) -> Result<(), BadParameter> {
        (self.check)(&self.defaults(), given)
    }

    /// Makes the object with these parameters, and defaults for those not given.
    ///
    /// # Errors
    /// For a parameter that the object has not, that is of another type, or out of range.
    pub fn make(&self, given: &Table) -> Made {
        (self.make)(&self.defaults(), given)
    }
}

/// Reads `key=value,key=value`. A value that is neither a number nor a truth is a text.
///
/// # Errors
/// For a part that has no `=` or a name that comes twice.
pub fn parse(text: &str) -> Result<Table, BadParameter> {
    let mut table = Table::new();
    for part in text.split(',') {
        let bad = |what: &str| BadParameter {
            name: part.to_owned(),
            what: what.to_owned(),
        };
        let (key, value) = part
            .split_once('=')
            .ok_or_else(|| bad("is no parameter: write name=value"))?;
        let number = || {
            let integer = value.parse().map(Value::Integer);
            integer.or_else(|_| value.parse().map(Value::Float)).ok()
        };
        let truth = || value.parse().map(Value::Boolean).ok();
        let value = number()
            .or_else(truth)
            .unwrap_or_else(|| Value::String(value.to_owned()));
        if table.insert(key.to_owned(), value).is_some() {
            return Err(bad("is given twice"));
        }
    }
    Ok(table)
}

/// The names and parameters of all objects, for people.
#[must_use]
pub fn list() -> String {
    let mut text = String::from("Objects that need no file, with their parameters:\n");
    for object in &PROCEDURAL {
        text += &format!("  {:<9} {}\n", object.name, object.about);
        let mut line = String::new();
        for (name, value) in object.defaults() {
            let value = match value {
                Value::String(text) => text,
                Value::Array(_) => "[...] in scene files".to_owned(),
                value => value.to_string(),
            };
            if line.len() + name.len() + value.len() > 80 {
                text += &format!("            {}\n", line.trim_end());
                line.clear();
            }
            line += &format!("{name}={value} ");
        }
        if !line.is_empty() {
            text += &format!("            {}\n", line.trim_end());
        }
    }
    text + "Parameters follow the name: terrain:seed=7,height=0.4; colours are #rrggbb"
}

/// The parameters as they would be written.
fn table<T: Serialize>(parameters: &T) -> Table {
    // Structs of numbers and texts are tables.
    Table::try_from(parameters).unwrap_or_default()
}

fn make<T: Parameters + 'static>(defaults: &Table, given: &Table) -> Made {
    Ok(read::<T>(defaults, given)?.make())
}

/// The parameters, checked.
fn read<T: Parameters>(defaults: &Table, given: &Table) -> Result<T, BadParameter> {
    let mut table = defaults.clone();
    let parsed = |table: &Table, name: &str| -> Result<T, BadParameter> {
        let parsed = table.clone().try_into();
        parsed.map_err(|error: toml::de::Error| BadParameter {
            name: name.to_owned(),
            what: format!("cannot be that: {}", error.message()),
        })
    };
    // One by one, so that an error is that of the last.
    for (name, value) in given {
        if table.insert(name.clone(), value.clone()).is_none() {
            return Err(unknown(name, defaults));
        }
        parsed(&table, name)?;
    }
    let parameters = parsed(&table, "")?;
    parameters.check()?;
    Ok(parameters)
}

fn no_parameters(defaults: &Table, given: &Table) -> Result<(), BadParameter> {
    given
        .keys()
        .next()
        .map_or(Ok(()), |name| Err(unknown(name, defaults)))
}

fn unknown(name: &str, defaults: &Table) -> BadParameter {
    let known: Vec<&str> = defaults.keys().map(String::as_str).collect();
    BadParameter {
        name: name.to_owned(),
        what: if known.is_empty() {
            "is not known: the object has no parameters".to_owned()
        } else {
            format!("is not known; there are {}", known.join(", "))
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(name: &str, parameters: &str) -> Made {
        Procedural::named(name).unwrap().make(&parse(parameters)?)
    }

    #[test]
    fn parameters_are_numbers_truths_and_texts() {
        let table = parse("a=1,b=-0.5,c=true,d=#00ff00").unwrap();
        assert_eq!(table["a"], Value::Integer(1));
        assert_eq!(table["b"], Value::Float(-0.5));
        assert_eq!(table["c"], Value::Boolean(true));
        assert_eq!(table["d"], Value::String("#00ff00".to_owned()));
        for bad in ["", "a", "a=1,,b=2", "a=1,a=2"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_parameter_that_cannot_be_is_named() {
        for (object, parameters, name, part) in [
            ("terrain", "sed=7", "sed", "there are"),
            (
                "terrain",
                "octaves=4,resolution=1000000",
                "resolution",
                "may be",
            ),
            ("terrain", "octaves=4,height=nan", "height", "is NaN"),
            ("terrain", "seed=1,grass=green", "grass", "is no colour"),
            ("terrain", "octaves=many", "octaves", "expected"),
            ("terrain", "seed=-1", "seed", "expected"),
            ("teapot", "seed=1", "seed", "no parameters"),
        ] {
            let bad = made(object, parameters).err().unwrap();
            assert_eq!(bad.name, name);
            assert!(bad.what.contains(part), "{bad}");
        }
    }

    #[test]
    fn the_defaults_of_every_object_are_in_range_and_listed() {
        let list = list();
        for object in &PROCEDURAL {
            assert!(list.contains(object.name));
            for name in object.defaults().keys() {
                assert!(list.contains(&format!("{name}=")), "{name}");
            }
            assert!(
                object
                    .make(&object.defaults())
                    .is_ok_and(|made| made.primitives() > 0)
            );
        }
        assert!(Procedural::named("coffee").is_none());
    }
}
