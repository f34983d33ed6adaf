//! Checks the headers of a file in Thrift's compact protocol before the `parquet` crate reads them. That crate would
//! process all elements that a list claims to have, up to billions, even if the file ends earlier or the elements take
//! no space.

use bytes::Bytes;
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::{ChunkReader, Length};
use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};

/// \[byte\] Length field of the footer and magic number at the end of the file.
pub(crate) const TAIL: u64 = 8;
/// Largest depth of nested lists, as in the `parquet` crate.
const DEEPEST: u32 = 64;

/// A file whose page headers are known to end.
pub(crate) struct Headed(pub File);

impl Length for Headed {
    fn len(&self) -> u64 {
        Length::len(&self.0)
    }
}

impl ChunkReader for Headed {
    type T = BufReader<File>;

    fn get_read(&self, start: u64) -> Result<BufReader<File>> {
        // Everything but the tail of the file are page headers.
        if start.checked_add(TAIL) != Some(self.len()) {
            walk(&mut self.0.get_read(start)?).map_err(|why| refused("the header of a page", &why))?;
        }
        self.0.get_read(start)
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        self.0.get_bytes(start, length)
    }
}

/// Refuses a footer that does not end. If the file has no footer, the `parquet` crate reports it.
pub(crate) fn check_footer(mut file: &File) -> Result<()> {
    let length = Length::len(file);
    let Some(end) = length.checked_sub(TAIL) else { return Ok(()) };
    let mut size = [0; 4];
    file.seek(SeekFrom::Start(end))?;
    file.read_exact(&mut size)?;
    let size = u64::from(u32::from_le_bytes(size));
    let Some(start) = end.checked_sub(size) else { return Ok(()) };
    walk(&mut file.get_read(start)?.take(size)).map_err(|why| refused("the footer", &why))
}

fn refused(what: &str, why: &io::Error) -> ParquetError {
    ParquetError::General(match why.kind() {
        ErrorKind::UnexpectedEof => format!("{what} claims more data than the file has"),
        _ => format!("{what} {why}"),
    })
}

/// Reads to the end of a structure.
fn walk(header: &mut impl Read) -> io::Result<()> {
    value(header, STRUCTURE, DEEPEST)
}

const BYTE: u8 = 3;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const SET: u8 = 10;
const MAP: u8 = 11;
const STRUCTURE: u8 = 12;
const UUID: u8 = 13;

/// Each call reads at least one byte, so the work is bounded by the size of the file.
fn value(header: &mut impl Read, kind: u8, depth: u32) -> io::Result<()> {
    let depth = depth.checked_sub(1).ok_or_else(|| wrong("has too many nested lists"))?;
    match kind {
        BYTE => skip(header, 1),
        4..=6 => number(header).map(|_| ()),
        DOUBLE => skip(header, 8),
        UUID => skip(header, 16),
        BINARY => number(header).and_then(|length| skip(header, length)),
        LIST | SET => {
            let begin = byte(header)?;
            let count = match begin >> 4 {
                15 => number(header)?,
                few => few.into(),
            };
            (0..count).try_for_each(|_| element(header, begin & 15, depth))
        }
        MAP => {
            let count = number(header)?;
            let kinds = if count > 0 { byte(header)? } else { 0 };
            (0..count).try_for_each(|_| {
                element(header, kinds >> 4, depth)?;
                element(header, kinds & 15, depth)
            })
        }
        STRUCTURE => loop {
            let begin = byte(header)?;
            if begin & 15 == 0 {
                return Ok(());
            }
            if begin >> 4 == 0 {
                // The field number, which otherwise follows from the one before.
                number(header)?;
            }
            // Booleans are stored in the type byte.
            if begin & 15 > 2 {
                value(header, begin & 15, depth)?;
            }
        },
        _ => Err(wrong("has a value of an unknown type")),
    }
}

fn element(header: &mut impl Read, kind: u8, depth: u32) -> io::Result<()> {
    if kind == 1 || kind == 2 {
        // No footer has such a list. Its elements take a byte each in the file, but the `parquet` crate reads none.
        return Err(wrong("has a list of booleans"));
    }
    value(header, kind, depth)
}

fn wrong(what: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, what)
}

fn byte(header: &mut impl Read) -> io::Result<u8> {
    let mut byte = [0];
    header.read_exact(&mut byte)?;
    Ok(byte[0])
}

/// A variable-length integer: seven bits per byte, the lowest first.
fn number(header: &mut impl Read) -> io::Result<u64> {
    let mut number = 0;
    for place in 0..10 {
        let byte = byte(header)?;
        number |= u64::from(byte & 127) << (7 * place);
        if byte < 128 {
            return Ok(number);
        }
    }
    Err(wrong("has a number longer than ten bytes"))
}

fn skip(header: &mut impl Read, count: u64) -> io::Result<()> {
    let skipped = io::copy(&mut header.take(count), &mut io::sink())?;
    if skipped == count { Ok(()) } else { Err(ErrorKind::UnexpectedEof.into()) }
}
