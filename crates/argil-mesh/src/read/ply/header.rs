//! The header of a PLY file.

use super::super::error::ReadFault;
use super::super::text;

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn parse(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Returns the bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of the number before a list, which counts it.
    pub(super) count: Option<Number>,
    pub(super) number: Number,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Lines of the header.
    pub(super) lines: usize,
}

impl Header {
    /// Parses a header, and returns the bytes after it. Comments may have any bytes.
    pub(super) fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), ReadFault> {
        let bytes = text::without_mark(bytes);
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        for (number, line) in text::lines(bytes) {
            let bad = || text::bad_line(number, line);
            let mut words = text::words(line);
            let mut word = || words.next().ok_or_else(bad);
            let first = word().unwrap_or_default();
            if number == 1 && first != b"ply" {
                return Err("its first line is not \"ply\"".into());
            }
            match first {
                b"" | b"ply" | b"comment" | b"obj_info" => {}
                b"format" => {
                    encoding = Some(match word()? {
                        b"ascii" => Encoding::Text,
                        b"binary_little_endian" => Encoding::LittleEndian,
                        b"binary_big_endian" => Encoding::BigEndian,
                        _ => return Err(bad()),
                    });
                }
                b"element" => {
                    let name = String::from_utf8_lossy(word()?).into_owned();
                    let count = std::str::from_utf8(word()?)
                        .ok()
                        .and_then(|w| w.parse().ok());
                    elements.push(Element {
                        name,
                        count: count.ok_or_else(bad)?,
                        properties: Vec::new(),
                    });
                }
                b"property" => {
                    let element = elements.last_mut().ok_or_else(bad)?;
                    let mut kind = word()?;
                    let mut count = None;
                    if kind == b"list" {
                        count = Some(Number::parse(word()?).ok_or_else(bad)?);
                        kind = word()?;
                    }
                    element.properties.push(Property {
                        number: Number::parse(kind).ok_or_else(bad)?,
                        name: String::from_utf8_lossy(word()?).into_owned(),
                        count,
                    });
                }
                b"end_header" => {
                    let encoding = encoding.ok_or("its header has no format")?;
                    let header = Self {
                        encoding,
                        elements,
                        lines: number,
                    };
                    return Ok((header, after(bytes, line)));
                }
                // The second line of a comment, from an old program.
                _ if elements.is_empty() => {}
                _ => return Err(bad()),
            }
        }
        Err("its header has no end: it is truncated".into())
    }
}

/// Returns what follows a header's last line. Where lines end in carriage returns alone, a line feed is data.
fn after<'a>(bytes: &'a [u8], last: &[u8]) -> &'a [u8] {
    let end = last.as_ptr_range().end as usize - bytes.as_ptr() as usize;
    let (header, rest) = bytes.split_at(end);
    match rest {
        [b'\r', b'\n', rest @ ..] if header.contains(&b'\n') => rest,
        [_, rest @ ..] => rest,
        [] => rest,
    }
}
