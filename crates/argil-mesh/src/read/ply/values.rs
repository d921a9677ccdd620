//! The numbers after the header of a PLY file.

use super::super::error::ReadFault;
use super::super::text;
use super::header::{Encoding, Header, Number};

/// Reads numbers one after the other.
pub(super) enum Values<'a> {
    Text(Lines<'a>),
    Binary { rest: &'a [u8], is_big: bool },
}

/// Lines of numbers. An element has one line, or several.
pub(super) struct Lines<'a> {
    lines: Box<dyn Iterator<Item = (usize, &'a [u8])> + 'a>,
    number: usize,
    line: &'a [u8],
    /// What is left of the line, without blanks around it.
    words: &'a [u8],
    /// The first line with more numbers than the header declares.
    first_longer: Option<usize>,
}

fn truncated() -> ReadFault {
    "unexpected end of file: it is truncated".into()
}

impl<'a> Lines<'a> {
    /// Moves to the next line that is not blank.
    fn advance(&mut self) -> Result<(), ReadFault> {
        let next = self.lines.find(|(_, line)| !line.trim_ascii().is_empty());
        (self.number, self.line) = next.ok_or_else(truncated)?;
        self.words = self.line.trim_ascii();
        Ok(())
    }

    fn word(&mut self) -> Result<&'a [u8], ReadFault> {
        if self.words.is_empty() {
            self.advance()?;
        }
        let end = self.words.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = self.words.split_at(end.unwrap_or(self.words.len()));
        self.words = rest.trim_ascii_start();
        Ok(word)
    }

    fn bad(&self) -> ReadFault {
        text::bad_line(self.number, self.line)
    }
}

impl<'a> Values<'a> {
    pub(super) fn new(body: &'a [u8], header: &Header) -> Self {
        let before = header.lines;
        match header.encoding {
            Encoding::Text => Self::Text(Lines {
                lines: Box::new(text::lines(body).map(move |(n, line)| (n + before, line))),
                number: before,
                line: &[],
                words: &[],
                first_longer: None,
            }),
            Encoding::LittleEndian => Self::Binary {
                rest: body,
                is_big: false,
            },
            Encoding::BigEndian => Self::Binary {
                rest: body,
                is_big: true,
            },
        }
    }

    /// Begins an element.
    pub(super) fn begin(&mut self) -> Result<(), ReadFault> {
        match self {
            Self::Text(lines) => lines.advance(),
            Self::Binary { .. } => Ok(()),
        }
    }

    /// Ends an element, whose line may have more numbers.
    pub(super) fn end(&mut self) {
        if let Self::Text(lines) = self
            && !lines.words.is_empty()
        {
            lines.first_longer.get_or_insert(lines.number);
        }
    }

    /// Describes what was left out, after the last element.
    pub(super) fn warning(mut self) -> Option<String> {
        match &mut self {
            Self::Text(lines) => {
                let begun = lines.first_longer;
                let first = begun.or_else(|| lines.advance().ok().map(|()| lines.number));
                first.map(|number| {
                    format!("left out what its header does not declare, first at line {number}")
                })
            }
            Self::Binary { rest, .. } => {
                let is_filling = rest.iter().all(|b| *b == 0 || b.is_ascii_whitespace());
                (!is_filling).then(|| {
                    format!(
                        "left out {} bytes that its header does not declare",
                        rest.len()
                    )
                })
            }
        }
    }

    /// Reads a number.
    pub(super) fn next(&mut self, kind: Number) -> Result<f64, ReadFault> {
        match self {
            Self::Text(lines) => {
                let word = lines.word()?;
                text::number(word).ok_or_else(|| lines.bad())
            }
            Self::Binary { rest, is_big } => {
                let (bytes, after) = rest.split_at_checked(kind.size()).ok_or_else(truncated)?;
                *rest = after;
                Ok(decode(bytes, kind, *is_big))
            }
        }
    }

    /// Reads the length of a list.
    pub(super) fn count(&mut self, kind: Number) -> Result<u32, ReadFault> {
        let count = self.next(kind)?;
        let is_count = (0.0..f64::from(u32::MAX)).contains(&count) && count.fract() == 0.0;
        match self {
            _ if is_count => Ok(count as u32),
            Self::Text(lines) => Err(lines.bad()),
            Self::Binary { .. } => Err(format!("a list has {count} numbers").into()),
        }
    }

    /// Skips numbers.
    pub(super) fn skip(&mut self, kind: Number, count: u32) -> Result<(), ReadFault> {
        match self {
            Self::Text(lines) => (0..count).try_for_each(|_| lines.word().map(|_| ())),
            Self::Binary { rest, .. } => {
                let size = (count as usize).checked_mul(kind.size());
                let after = size.and_then(|size| rest.get(size..));
                *rest = after.ok_or_else(truncated)?;
                Ok(())
            }
        }
    }
}

/// Decodes a number of `kind.size()` bytes.
fn decode(bytes: &[u8], kind: Number, is_big: bool) -> f64 {
    let mut little = [0; 8];
    let digits = &mut little[..bytes.len()];
    digits.copy_from_slice(bytes);
    if is_big {
        digits.reverse();
    }
    let [a, b, c, d, ..] = little;
    match kind {
        Number::I8 => f64::from(a as i8),
        Number::U8 => f64::from(a),
        Number::I16 => f64::from(i16::from_le_bytes([a, b])),
        Number::U16 => f64::from(u16::from_le_bytes([a, b])),
        Number::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Number::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Number::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Number::F64 => f64::from_le_bytes(little),
    }
}
