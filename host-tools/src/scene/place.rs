//! Where in a scene file something is wrong.

use std::ops::Range;

use crate::failure::Failure;

/// What is wrong, and the bytes of the file that say so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Bad {
    pub(super) at: Range<usize>,
    pub(super) what: String,
    pub(super) help: Option<String>,
}

impl Bad {
    pub(super) fn new(at: Range<usize>, what: impl Into<String>) -> Self {
        Self {
            at,
            what: what.into(),
            help: None,
        }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// With the file's name, the line and the field, and the line itself.
    pub(super) fn failure(&self, name: &str, text: &str) -> Failure {
        let at = self.at.start.min(text.len());
        let number = text[..at].matches('\n').count() + 1;
        let line = text.lines().nth(number - 1).unwrap_or_default();
        let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
        let column = at - start;
        let place = match field(line, column) {
            Some(field) => format!("{name}, line {number}, {field}"),
            None => format!("{name}, line {number}"),
        };
        let failure = Failure::input(format!("{place}: {}\n  | {}", self.what, line.trim()));
        match &self.help {
            Some(help) => failure.help(help),
            None => failure,
        }
    }
}

/// The field that byte `column` of a line belongs to: the name there, or before the last `=`.
fn field(line: &str, column: usize) -> Option<&str> {
    let name = |text: &'_ str| {
        let from = text
            .rfind(|c: char| !(c.is_alphanumeric() || "_-.".contains(c)))
            .map_or(0, |at| at + 1);
        from..text.len()
    };
    let (before, after) = line.split_at_checked(column)?;
    let length = after
        .find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '-'))
        .unwrap_or(after.len());
    let is_name = length > 0 && after[length..].trim_start().starts_with('=');
    if is_name {
        return Some(&after[..length]);
    }
    if line.trim_start().starts_with('[') && !line.contains('=') {
        return Some(line.trim().trim_matches(['[', ']']));
    }
    let key = before[..before.rfind('=')?].trim_end();
    Some(&key[name(key)])
}

impl From<toml::de::Error> for Bad {
    fn from(error: toml::de::Error) -> Self {
        Self::new(error.span().unwrap_or(0..0), error.message())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_is_the_name_at_the_place_or_before_it() {
        for (line, mark, expected) in [
            ("scale = 0", "0", "scale"),
            ("scal = 0", "scal", "scal"),
            ("copies = [{ scale = 1 }, { scale = 0 }]", "0 }", "scale"),
            ("parameters = { seed = 1, leafs = 2 }", "leafs", "leafs"),
            ("[[material]]", "[[", "material"),
        ] {
            assert_eq!(
                field(line, line.find(mark).unwrap()),
                Some(expected),
                "{line}"
            );
        }
        assert_eq!(field("???", 1), None);
        assert_eq!(field("", 7), None);
    }

    #[test]
    fn a_message_names_file_line_and_field_and_shows_the_line() {
        let text = "a = 1\n  b = 2\n";
        let failure = Bad::new(12..13, "is 2").failure("x.toml", text);
        assert_eq!(failure.message, "x.toml, line 2, b: is 2\n  | b = 2");
        let end = Bad::new(99..100, "ends").failure("x.toml", text);
        assert!(end.message.starts_with("x.toml, line 3: ends"));
    }
}
