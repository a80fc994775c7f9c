//! JSON text, written straight into a buffer that is used again.

use nalgebra::Vector3;
use serde::Serialize;

/// A JSON object being written. Numbers that are not finite are left out.
///
/// Give every field once: names are not checked.
#[derive(Debug)]
pub struct JsonWriter<'a> {
    out: &'a mut Vec<u8>,
    empty: bool,
}

impl JsonWriter<'_> {
    /// Replaces the buffer's contents by one object.
    pub fn write(out: &mut Vec<u8>, fill: impl FnOnce(&mut JsonWriter<'_>)) {
        out.clear();
        JsonWriter::append(out, fill);
    }

    fn append(out: &mut Vec<u8>, fill: impl FnOnce(&mut JsonWriter<'_>)) {
        out.push(b'{');
        fill(&mut JsonWriter {
            out: &mut *out,
            empty: true,
        });
        out.push(b'}');
    }

    /// A number; left out if it is not finite.
    pub fn number(&mut self, name: &str, value: f64) {
        if value.is_finite() {
            self.field(name, &value);
        }
    }

    /// A count.
    pub fn integer(&mut self, name: &str, value: u64) {
        self.field(name, &value);
    }

    /// True or false.
    pub fn boolean(&mut self, name: &str, value: bool) {
        self.field(name, &value);
    }

    /// A text.
    pub fn text(&mut self, name: &str, value: &str) {
        self.field(name, value);
    }

    /// Anything as text, without a string in between.
    pub fn display(&mut self, name: &str, value: &dyn std::fmt::Display) {
        struct Text<'a>(&'a dyn std::fmt::Display);
        impl Serialize for Text<'_> {
            fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
                s.collect_str(self.0)
            }
        }
        self.field(name, &Text(value));
    }

    /// An object with `x`, `y`, `z`.
    pub fn xyz(&mut self, name: &str, v: &Vector3<f64>) {
        self.object(name, |o| {
            o.number("x", v.x);
            o.number("y", v.y);
            o.number("z", v.z);
        });
    }

    /// A nested object.
    pub fn object(&mut self, name: &str, fill: impl FnOnce(&mut JsonWriter<'_>)) {
        self.name(name);
        JsonWriter::append(self.out, fill);
    }

    /// A list of objects.
    pub fn list<T>(
        &mut self,
        name: &str,
        items: impl IntoIterator<Item = T>,
        mut fill: impl FnMut(&mut JsonWriter<'_>, T),
    ) {
        self.name(name);
        self.out.push(b'[');
        for (i, item) in items.into_iter().enumerate() {
            if i > 0 {
                self.out.push(b',');
            }
            JsonWriter::append(self.out, |o| fill(o, item));
        }
        self.out.push(b']');
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

#[cfg(test)]
mod tests {
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
}
