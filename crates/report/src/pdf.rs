//! A report as PDF.
use crate::Report;
use lemons_picture::PictureError;
/// Returns it.
pub fn pdf(_: &Report) -> Result<Vec<u8>, PictureError> { Ok(Vec::new()) }
