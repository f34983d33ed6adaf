//! A table as CSV.

use super::{Cell, Column, Content, Extent, check_headings, check_kept};
use anyhow::{Context, Result, bail};
use crowd_mechanics::files::Staged;
use lemons_files::input;
use std::fmt::Write as _;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

pub struct Table {
    out: csv::Writer<BufWriter<Staged>>,
    text: String,
}

impl Table {
    /// With the header, or byte for byte what a run before has written.
    pub fn create(file: Staged, content: &Content, path: &Path, kept: Option<Extent>) -> Result<Table> {
        let mut out = BufWriter::new(file);
        if let Some(kept) = kept {
            copy(path, &content.columns, kept, &mut out)?;
            return Ok(Table { out: csv::Writer::from_writer(out), text: String::new() });
        }
        let mut out = csv::Writer::from_writer(out);
        out.write_record(content.columns.iter().map(|column| &column.name))?;
        Ok(Table { out, text: String::new() })
    }

    pub fn write<'a>(&mut self, cells: impl Iterator<Item = Cell<'a>>) -> Result<()> {
        for cell in cells {
            let text = &mut self.text;
            text.clear();
            match cell {
                // It reads back to the same double.
                Cell::Real(value) => write!(text, "{value:?}")?,
                Cell::Integer(value) => write!(text, "{value}")?,
                Cell::Long(value) => write!(text, "{value}")?,
                Cell::Boolean(value) => write!(text, "{value}")?,
                Cell::Text(value) => text.push_str(value),
                Cell::Missing => {}
            }
            self.out.write_field(&*text)?;
        }
        Ok(self.out.write_record(None::<&[u8]>)?)
    }

    pub fn finish(self) -> Result<Staged> {
        let file = self.out.into_inner().map_err(|error| error.into_error())?;
        Ok(file.into_inner().map_err(|error| error.into_error())?)
    }
}

fn copy(path: &Path, columns: &[Column], kept: Extent, to: &mut impl Write) -> Result<()> {
    let mut file = input::open(path)?;
    let mut reader = csv::Reader::from_reader(BufReader::new(&file));
    check_headings(
        reader.headers()?.iter().map(str::to_owned),
        columns.iter().map(|column| column.name.clone()),
    )?;
    let (mut row, mut rows, mut last) = (csv::ByteRecord::new(), 0, None);
    while reader.read_byte_record(&mut row)? {
        rows += 1;
        // Only the last one matters.
        if rows >= kept.rows {
            last = std::str::from_utf8(&row[0]).ok().and_then(|text| text.parse().ok());
        }
    }
    check_kept(kept, rows, last)?;
    drop(reader);
    file.seek(SeekFrom::End(-1))?;
    let mut end = [0];
    file.read_exact(&mut end)?;
    if end != *b"\n" {
        bail!("its last row does not end with its line");
    }
    file.seek(SeekFrom::Start(0))?;
    std::io::copy(&mut file, to).context("the rows of the saved run cannot be copied")?;
    Ok(())
}
