//! Numbers as people read them.

/// `1234567` as `1,234,567`.
#[must_use]
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A size to three digits or so: `734 B`, `68.2 kB`, `5.46 MB`; k and M are powers of 1000.
#[must_use]
pub fn size(bytes: u64) -> String {
    let b = bytes as f64;
    match bytes {
        0..1000 => format!("{bytes} B"),
        1000..99_950 => format!("{:.1} kB", b / 1e3),
        99_950..999_500 => format!("{:.0} kB", b / 1e3),
        999_500..9_995_000 => format!("{:.2} MB", b / 1e6),
        9_995_000..99_950_000 => format!("{:.1} MB", b / 1e6),
        _ => format!("{:.0} MB", b / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_by_three() {
        for (number, text) in [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (12_345_678, "12,345,678"),
        ] {
            assert_eq!(thousands(number), text);
        }
    }

    #[test]
    fn sizes_keep_three_digits() {
        for (bytes, text) in [
            (999, "999 B"),
            (1000, "1.0 kB"),
            (68_240, "68.2 kB"),
            (606_125, "606 kB"),
            (999_499, "999 kB"),
            (999_500, "1.00 MB"),
            (5_456_000, "5.46 MB"),
            (123_456_789, "123 MB"),
        ] {
            assert_eq!(size(bytes), text);
        }
    }
}
