//! Numbers and tables on a terminal.

use comfy_table::{CellAlignment, Table, presets};

/// Four significant digits, without trailing zeros.
pub fn number(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return x.to_string();
    }
    let magnitude = x.abs().log10().floor() as i32;
    if !(-3..6).contains(&magnitude) {
        return format!("{x:.1e}");
    }
    let decimals = usize::try_from(3 - magnitude).unwrap_or(0);
    let text = format!("{x:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A time in s, to the nanosecond: what sums of periods are off by is no part of it.
pub(crate) fn seconds(time: f64) -> f64 {
    let nanoseconds = (1e9 * time).round();
    if nanoseconds.abs() < 1e15 {
        nanoseconds / 1e9
    } else {
        time
    }
}

/// A number with its unit, or a dash where there is none.
pub fn quantity(x: Option<f64>, unit: &str) -> String {
    x.map_or_else(|| "–".to_owned(), |x| format!("{} {unit}", number(x)))
}

/// Whole per cent.
pub fn per_cent(share: Option<f64>) -> String {
    share.map_or_else(|| "–".to_owned(), |s| format!("{:.0} %", 100.0 * s))
}

/// Columns without lines between them; those named are aligned to the right.
pub fn table(header: &[&str], right: &[usize]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(header);
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if right.contains(&i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// Lines with a margin and without blanks at their ends.
pub fn indented(text: &str, margin: &str) -> String {
    let lines = text.lines().map(|line| {
        let line = format!("{margin}{line}");
        line.trim_end().to_owned() + "\n"
    });
    lines.collect()
}

/// Words in lines of at most so many characters, all but the first with a margin.
pub fn wrapped(words: &[String], separator: &str, margin: usize, width: usize) -> String {
    let mut lines = vec![String::new()];
    for (i, word) in words.iter().enumerate() {
        let word = if i + 1 < words.len() {
            format!("{word}{separator}")
        } else {
            word.clone()
        };
        let length = |text: &str| text.chars().count();
        if let Some(line) = lines.last_mut() {
            if line.is_empty() || length(line) + 1 + length(&word) <= width {
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(&word);
            } else {
                lines.push(word);
            }
        }
    }
    lines.join(&format!("\n{}", " ".repeat(margin)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_nanoseconds() {
        assert_eq!(seconds(7.0 * 0.2).to_string(), "1.4");
        assert_eq!(seconds(-0.1 - 0.2).to_string(), "-0.3");
        assert_eq!(seconds(1e300), 1e300);
        assert!(seconds(f64::NAN).is_nan());
    }

    #[test]
    fn numbers_have_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-0.123456, "-0.1235"),
            (12.3456, "12.35"),
            (1000.0, "1000"),
            (123456.0, "123456"),
            (1.26e-6, "1.3e-6"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(x), text);
        }
    }

    #[test]
    fn words_are_wrapped_behind_a_margin() {
        let words: Vec<String> = ["one", "two", "three"].map(str::to_owned).to_vec();
        assert_eq!(wrapped(&words, ",", 2, 9), "one, two,\n  three");
    }
}
