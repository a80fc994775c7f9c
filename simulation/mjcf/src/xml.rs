//! XML text, element by element.

use std::fmt::{Display, Write};

/// A text that grows by elements, indented.
#[derive(Debug, Default)]
pub(crate) struct Writer {
    text: String,
    /// Names of the elements that are open.
    open: Vec<&'static str>,
}

/// The attributes of an element, in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Attributes(String);

impl Attributes {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    pub(crate) fn with(mut self, name: &str, value: impl Display) -> Self {
        let value = escaped(&value.to_string());
        // Writing into a string does not fail.
        let _ = write!(self.0, " {name}=\"{value}\"");
        self
    }

    /// Numbers, with as many digits as it takes to read back the same.
    pub(crate) fn numbers(self, name: &str, values: &[f64]) -> Self {
        let values: Vec<String> = values.iter().map(|&x| number(x)).collect();
        self.with(name, values.join(" "))
    }

    /// The same if there is a value.
    pub(crate) fn optional(self, name: &str, values: Option<[f64; 2]>) -> Self {
        match values {
            Some(values) => self.numbers(name, &values),
            None => self,
        }
    }
}

impl Writer {
    pub(crate) fn open(&mut self, element: &'static str, attributes: &Attributes) {
        self.line(&format!("<{element}{}>", attributes.0));
        self.open.push(element);
    }

    pub(crate) fn close(&mut self) {
        if let Some(element) = self.open.pop() {
            self.line(&format!("</{element}>"));
        }
    }

    pub(crate) fn element(&mut self, element: &str, attributes: &Attributes) {
        self.line(&format!("<{element}{}/>", attributes.0));
    }

    pub(crate) fn comment(&mut self, text: &str) {
        // XML allows no two hyphens in a comment.
        self.line(&format!("<!-- {} -->", text.replace("--", "- -")));
    }

    pub(crate) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }

    fn line(&mut self, text: &str) {
        let indent = "  ".repeat(self.open.len());
        let _ = writeln!(self.text, "{indent}{text}");
    }
}

/// A zero has no sign.
fn number(x: f64) -> String {
    let x = if x == 0.0 { 0.0 } else { x };
    if x != 0.0 && !(1e-4..1e9).contains(&x.abs()) {
        format!("{x:e}")
    } else {
        x.to_string()
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_and_names_are_escaped() {
        let attributes = Attributes::new()
            .with("name", "a<\"b\"&c>")
            .numbers("pos", &[-0.0, 1e-17, 0.1, 2.5e12]);
        let mut writer = Writer::default();
        writer.open("body", &attributes);
        let text = writer.finish();
        assert_eq!(
            text,
            "<body name=\"a&lt;&quot;b&quot;&amp;c&gt;\" pos=\"0 1e-17 0.1 2.5e12\">\n</body>\n"
        );
    }
}
