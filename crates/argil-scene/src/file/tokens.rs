//! Reads a file as tokens, and limits the size of each part.

use super::error::{MAX_DEPTH, MAX_PART_BYTES};
use crate::ValidationError;
use std::cell::Cell;
use std::io::Read;
use std::rc::Rc;
use struson::reader::{JsonStreamReader, ReaderError, ReaderSettings};

/// What stopped reading.
pub(super) enum Stop {
    /// A value that is out of range, with its path from the document's root.
    Fault(ValidationError),
    /// Unexpected JSON. The reader knows the place.
    Reader(ReaderError),
}

impl From<ReaderError> for Stop {
    fn from(error: ReaderError) -> Self {
        Self::Reader(error)
    }
}

pub(super) type Tokens<'a> = JsonStreamReader<Metered<'a>>;

/// A source of bytes. It has one type, so that the parser is compiled once.
pub(super) type ByteSource<'a> = Box<dyn Read + 'a>;

/// A source that returns at most a part's length between two marks. Names and numbers have no limit of their own.
pub(super) struct Metered<'a> {
    source: ByteSource<'a>,
    meter: Option<Meter>,
    /// Bytes that were read to detect a byte order mark, and must still be returned.
    head: Option<Vec<u8>>,
}

/// A mark that some editors put before UTF-8 text.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Bytes since the last mark.
#[derive(Clone, Default)]
pub(super) struct Meter(Rc<Cell<usize>>);

impl Meter {
    pub(super) fn mark(&self) {
        self.0.set(0);
    }
}

impl Read for Metered<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.head.is_none() {
            let mut head = Vec::new();
            let length = BYTE_ORDER_MARK.len() as u64;
            (&mut self.source).take(length).read_to_end(&mut head)?;
            if head == BYTE_ORDER_MARK {
                head.clear();
            }
            self.head = Some(head);
        }
        let count = match &mut self.head {
            Some(head) if !head.is_empty() => {
                let count = head.len().min(buffer.len());
                buffer[..count].copy_from_slice(&head[..count]);
                head.drain(..count);
                count
            }
            _ => self.source.read(buffer)?,
        };
        let Some(Meter(used)) = &self.meter else {
            return Ok(count);
        };
        used.set(used.get() + count);
        if used.get() > 2 * MAX_PART_BYTES {
            let reason =
                format!("a name or value is longer than the limit, {MAX_PART_BYTES} bytes");
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, reason));
        }
        Ok(count)
    }
}

pub(super) fn tokens<'a>(source: ByteSource<'a>, meter: Option<&Meter>) -> Tokens<'a> {
    let settings = ReaderSettings {
        max_nesting_depth: Some(MAX_DEPTH),
        restrict_number_values: false,
        track_path: false,
        ..ReaderSettings::default()
    };
    JsonStreamReader::new_custom(
        Metered {
            source,
            meter: meter.cloned(),
            head: None,
        },
        settings,
    )
}
