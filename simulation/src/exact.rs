//! Lists of a file that have exactly as many numbers as they should: the format's own reading leaves out what is too
//! much, in silence.

use serde::{Deserialize, Deserializer, de::Error as _};

/// So many numbers.
///
/// # Errors
/// Another number of them, or something else.
pub fn numbers<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
    deserializer: D,
) -> Result<[T; N], D::Error> {
    let given: Vec<T> = Vec::deserialize(deserializer)?;
    <[T; N]>::try_from(given).map_err(|given| {
        let expected = format!("an array of length {N}");
        D::Error::invalid_length(given.len(), &expected.as_str())
    })
}

/// So many numbers where there may be none.
pub(crate) fn maybe<'de, D: Deserializer<'de>, const N: usize>(
    deserializer: D,
) -> Result<Option<[f64; N]>, D::Error> {
    numbers(deserializer).map(Some)
}
