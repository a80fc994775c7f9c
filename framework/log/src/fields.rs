//! A message's values, whatever they become: text, or columns of numbers.

use std::fmt::Display;

use nalgebra::Vector3;

use crate::{ChannelId, JsonWriter, LogError, LogSink};

/// Takes the values of a message, one named field after the other. Objects are opened and closed in pairs.
///
/// Give every field once: names are not checked.
pub trait Fields {
    /// A number with the digits that are usual for the message; left out if it is not finite.
    fn number(&mut self, name: &str, value: f64);

    /// A number of so many significant digits (1 to 17), for who writes digits; left out if it is not finite.
    fn rounded_number(&mut self, name: &str, value: f64, digits: usize);

    /// A number with all its digits; left out if it is not finite.
    fn exact_number(&mut self, name: &str, value: f64);

    /// A count.
    fn integer(&mut self, name: &str, value: u64);

    /// True or false.
    fn boolean(&mut self, name: &str, value: bool);

    /// Anything as text.
    fn display(&mut self, name: &str, value: &dyn Display);

    /// Opens an object: what follows is inside it.
    fn begin(&mut self, name: &str);

    /// Closes the object that was opened last.
    fn end(&mut self);

    /// Opens a list of objects; false if lists are not taken, and nothing is to be said of its contents.
    fn begin_list(&mut self, name: &str) -> bool;

    /// Opens the next object of a list.
    fn begin_item(&mut self);

    /// Closes the list.
    fn end_list(&mut self);
}

impl dyn Fields + '_ {
    /// A text.
    pub fn text(&mut self, name: &str, value: &str) {
        self.display(name, &value);
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
    pub fn object(&mut self, name: &str, fill: impl FnOnce(&mut Self)) {
        self.begin(name);
        fill(self);
        self.end();
    }

    /// A list of objects.
    pub fn list<T>(
        &mut self,
        name: &str,
        items: impl IntoIterator<Item = T>,
        mut fill: impl FnMut(&mut Self, T),
    ) {
        if !self.begin_list(name) {
            return;
        }
        for item in items {
            self.begin_item();
            fill(self, item);
            self.end();
        }
        self.end_list();
    }
}

/// Writes a message to a sink: as values to one that [takes them](LogSink::fields), as text to any other. `text` is
/// room for that text; numbers in it have so many significant digits where the message does not say it.
///
/// # Errors
/// [`LogError`] of the sink.
pub fn write_message(
    sink: &mut dyn LogSink,
    (channel, time): (ChannelId, f64),
    (text, digits): (&mut Vec<u8>, usize),
    fill: impl FnOnce(&mut dyn Fields),
) -> Result<(), LogError> {
    if let Some(fields) = sink.fields(channel, time)? {
        fill(fields);
        return Ok(());
    }
    JsonWriter::write_rounded(text, digits, |o| fill(o));
    sink.write(channel, time, text)
}
