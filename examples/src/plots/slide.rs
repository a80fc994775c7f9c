//! Figures of push and slide.
use super::FigureError;
use crate::{experiment::Picture, push_and_slide::measures::Logs};
use std::path::Path;
/// Draws.
pub fn draw(_logs: &Logs, _directory: &Path) -> Result<Vec<Picture>, FigureError> {
    Ok(Vec::new())
}
