//! JSON text, written straight into a buffer that is used again.

use std::{fmt::Display, io::Write};

use serde::Serialize;

use crate::Fields;

/// Writes [`Fields`] as JSON text.
#[derive(Debug)]
pub struct JsonWriter<'a> {
    out: &'a mut Vec<u8>,
    empty: bool,
    /// Significant digits of a number; all that tell it from others if none are given.
    digits: Option<usize>,
}

impl JsonWriter<'_> {
    /// Replaces the buffer's contents by one object.
    pub fn write(out: &mut Vec<u8>, fill: impl FnOnce(&mut dyn Fields)) {
        out.clear();
        JsonWriter::append(out, None, fill);
    }

    /// Like [`write`](Self::write), numbers rounded to so many significant digits (1 to 17).
    pub fn write_rounded(out: &mut Vec<u8>, digits: usize, fill: impl FnOnce(&mut dyn Fields)) {
        out.clear();
        JsonWriter::append(out, Some(digits), fill);
    }

    fn append(out: &mut Vec<u8>, digits: Option<usize>, fill: impl FnOnce(&mut dyn Fields)) {
        out.push(b'{');
        fill(&mut JsonWriter {
            out: &mut *out,
            empty: true,
            digits,
        });
        out.push(b'}');
    }

    fn open(&mut self, bracket: u8) {
        self.out.push(bracket);
        self.empty = true;
    }

    fn close(&mut self, bracket: u8) {
        self.out.push(bracket);
        self.empty = false;
    }

    fn field<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) {
        self.name(name);
        self.value(value);
    }

    fn name(&mut self, name: &str) {
        if !self.empty {
            self.out.push(b',');
        }
        self.empty = false;
        self.value(name);
        self.out.push(b':');
    }

    fn value<T: Serialize + ?Sized>(&mut self, value: &T) {
        let start = self.out.len();
        // A buffer takes everything; only a `Display` that fails could get here.
        if serde_json::to_writer(&mut *self.out, value).is_err() {
            self.out.truncate(start);
            self.out.extend_from_slice(b"null");
        }
    }
}

impl Fields for JsonWriter<'_> {
    fn number(&mut self, name: &str, value: f64) {
        match self.digits {
            Some(digits) => self.rounded_number(name, value, digits),
            None => self.exact_number(name, value),
        }
    }

    fn rounded_number(&mut self, name: &str, value: f64, digits: usize) {
        self.exact_number(name, rounded(value, digits.clamp(1, 17)));
    }

    fn exact_number(&mut self, name: &str, value: f64) {
        if value.is_finite() {
            self.field(name, &value);
        }
    }

    fn integer(&mut self, name: &str, value: u64) {
        self.field(name, &value);
    }

    fn boolean(&mut self, name: &str, value: bool) {
        self.field(name, &value);
    }

    /// Without a string in between.
    fn display(&mut self, name: &str, value: &dyn Display) {
        struct Text<'a>(&'a dyn Display);
        impl Serialize for Text<'_> {
            fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
                s.collect_str(self.0)
            }
        }
        self.field(name, &Text(value));
    }

    fn begin(&mut self, name: &str) {
        self.name(name);
        self.open(b'{');
    }

    fn end(&mut self) {
        self.close(b'}');
    }

    fn begin_list(&mut self, name: &str) -> bool {
        self.name(name);
        self.open(b'[');
        true
    }

    fn begin_item(&mut self) {
        if !self.empty {
            self.out.push(b',');
        }
        self.open(b'{');
    }

    fn end_list(&mut self) {
        self.close(b']');
    }
}

/// The number that is nearest to so many significant digits of a finite one; its shortest text has no more.
fn rounded(value: f64, digits: usize) -> f64 {
    // Sign, point, 17 digits, and an exponent of three digits with its sign.
    let mut text = [0; 32];
    let mut rest = &mut text[..];
    if write!(rest, "{value:.*e}", digits - 1).is_err() {
        return value;
    }
    let unused = rest.len();
    let text = std::str::from_utf8(&text[..text.len() - unused]);
    let number = text.ok().and_then(|text| text.parse::<f64>().ok());
    // Next to the largest number, rounding up has no result.
    number.filter(|n| n.is_finite()).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn writes_nested_fields_and_leaves_out_what_is_not_finite() {
        let mut text = b"old".to_vec();
        JsonWriter::write(&mut text, |o| {
            o.number("nan", f64::NAN);
            o.number("a \"quoted\"", 1e-7);
            o.xyz("v", &Vector3::new(1.0, f64::INFINITY, 3.0));
            o.object("empty", |_| ());
            o.list("list", [1, 2], |o, i| o.integer("i", i));
            o.boolean("on", true);
            o.display("shown", &format_args!("{}.{}", "a", "b"));
        });
        assert_eq!(
            String::from_utf8(text).unwrap(),
            r#"{"a \"quoted\"":1e-7,"v":{"x":1.0,"z":3.0},"empty":{},"list":[{"i":1},{"i":2}],"on":true,"shown":"a.b"}"#
        );
    }

    #[test]
    fn rounds_numbers_to_significant_digits() {
        let mut text = Vec::new();
        JsonWriter::write_rounded(&mut text, 7, |o| {
            o.number("third", 1.0 / 3.0);
            o.number("small", -1.234_567_89e-300);
            o.number("large", 123_456_789.0);
            o.object("inner", |o| o.number("whole", 2.0));
            o.list("list", [0.1 + 0.2], |o, v| o.number("v", v));
            o.number("largest", f64::MAX);
            o.exact_number("exact", 0.1 + 0.2);
        });
        let text = String::from_utf8(text).unwrap();
        let expected = concat!(
            r#"{"third":0.3333333,"small":-1.234568e-300,"large":123456800.0,"inner":{"whole":2.0},"#,
            r#""list":[{"v":0.3}],"largest":1.797693e+308,"exact":0.30000000000000004}"#,
        );
        assert_eq!(text, expected);
    }

    proptest::proptest! {
        #[test]
        fn a_rounded_number_is_near(bits: u64, digits in 1_u8..=17) {
            let value = f64::from_bits(bits);
            proptest::prop_assume!(value.is_normal());
            let error = (rounded(value, usize::from(digits)) - value).abs();
            let bound = (0.5001 * 10_f64.powi(1 - i32::from(digits)) + f64::EPSILON) * value.abs();
            proptest::prop_assert!(error <= bound);
        }
    }
}
