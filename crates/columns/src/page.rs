//! The pages of a file whose headers are plausible.

use parquet::basic::Encoding;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};

/// Refuses pages for which the `parquet` crate would allocate as much as their headers claim, whatever they contain.
/// Skips pages without values, which that crate takes for the end of the column.
pub(crate) struct Checked {
    pub pages: Box<dyn PageReader>,
    /// \[byte\] Smallest size of a value in a dictionary.
    pub width: usize,
}

impl PageReader for Checked {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        loop {
            let Some(page) = self.pages.get_next_page()? else { return Ok(None) };
            match &page {
                Page::DictionaryPage { buf, num_values, .. } => {
                    if (*num_values as usize).saturating_mul(self.width) > buf.len() {
                        return Err(ParquetError::General(
                            "a dictionary claims more values than it contains".into(),
                        ));
                    }
                }
                Page::DataPage { num_values: 0, .. } | Page::DataPageV2 { num_values: 0, .. } => continue,
                Page::DataPage { encoding, .. } | Page::DataPageV2 { encoding, .. } => {
                    if matches!(encoding, Encoding::DELTA_LENGTH_BYTE_ARRAY | Encoding::DELTA_BYTE_ARRAY) {
                        return Err(ParquetError::NYI(format!("encoding {encoding}")));
                    }
                }
            }
            return Ok(Some(page));
        }
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.pages.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.pages.skip_next_page()
    }
}

impl Iterator for Checked {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}
