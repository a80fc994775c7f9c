//! Numbers under names in one flat list: what is handed over at every frame, without text.

/// Where a name's numbers are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// The name.
    pub name: String,
    /// Index of the first.
    pub at: usize,
    /// How many there are.
    pub count: usize,
}

/// A flat list of numbers that is written anew again and again, always the same names in the same order.
#[derive(Clone, Debug, Default)]
pub struct Board {
    fields: Vec<Field>,
    values: Vec<f64>,
    /// Whether it was written once: then the names are known.
    is_laid_out: bool,
}

impl Board {
    /// Begins to write: what was on it is gone, the names stay.
    pub(crate) fn begin(&mut self) {
        self.is_laid_out |= !self.fields.is_empty();
        self.values.clear();
    }

    /// Writes the next name's numbers; the name is asked for the first time alone.
    pub(crate) fn put(
        &mut self,
        name: impl FnOnce() -> String,
        values: impl IntoIterator<Item = f64>,
    ) {
        let at = self.values.len();
        self.values.extend(values);
        if !self.is_laid_out {
            self.fields.push(Field {
                name: name(),
                at,
                count: self.values.len() - at,
            });
        }
    }

    /// Where everything is.
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// The numbers.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The numbers of a name.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let field = self.fields.iter().find(|field| field.name == name)?;
        self.values.get(field.at..field.at + field.count)
    }
}
