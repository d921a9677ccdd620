//! The zip archive of a 3MF file, and the model that it names.

use super::super::address::decoded;
use super::super::error::ReadFault;
use quick_xml::Reader;
use quick_xml::events::Event;
use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use zip::ZipArchive;
use zip::read::ZipFile;

/// Unpacked bytes per byte of the archive. XML of meshes shrinks to a tenth, and a bomb a thousandfold.
const UNPACKED_PER_BYTE: u64 = 50;
/// Bytes that each archive may unpack.
const UNPACKED_FLOOR: u64 = 16 << 20;
/// Bytes of a tag, or of a text between two.
const MAX_EVENT: u64 = 16 << 20;

/// The end of the type of the relationship that names the model.
const MODEL_TYPE: &str = "/3dmodel";

pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// Places of parts in the archive, by their names in lower case.
    places: HashMap<String, usize>,
    limit: u64,
    left: u64,
}

/// Returns a part's name as archives are searched for it: without a slash first, in lower case, with `%20` and the like as
/// characters. Some programs write backslashes.
pub(super) fn key(name: &str) -> String {
    let name = decoded(name).replace('\\', "/");
    name.trim_start_matches('/').to_lowercase()
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, ReadFault> {
        let archive = ZipArchive::new(Cursor::new(bytes));
        let archive = archive.map_err(|error| ReadFault::Damaged(error.to_string()))?;
        let names = archive.file_names().enumerate();
        let places = names.map(|(place, name)| (key(name), place)).collect();
        let limit = UNPACKED_FLOOR.max(UNPACKED_PER_BYTE * bytes.len() as u64);
        Ok(Self {
            archive,
            places,
            limit,
            left: limit,
        })
    }

    /// Whether there is a part of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.places.contains_key(&key(name))
    }

    /// Opens a part.
    ///
    /// # Errors
    /// If it is missing, or not UTF-8.
    pub(super) fn part(&mut self, name: &str) -> Result<Part<'_, 'a>, ReadFault> {
        let place = self.places.get(&key(name));
        let place = *place.ok_or_else(|| format!("the archive has no part \"{name}\""))?;
        let file = self.archive.by_index(place);
        let file = file.map_err(|error| ReadFault::Damaged(format!("{name}: {error}")))?;
        let mut file = BufReader::new(Limited {
            file,
            limit: self.limit,
            left: &mut self.left,
            event: 0,
        });
        let first = file.fill_buf().map_err(|error| fault(name, &error))?;
        if first.starts_with(&[0xff, 0xfe]) || first.starts_with(&[0xfe, 0xff]) {
            let reason = format!("{name}: its XML is UTF-16: save it as UTF-8");
            return Err(ReadFault::Unsupported(reason));
        }
        Ok(file)
    }

    /// Returns the name of the model that the archive is about.
    pub(super) fn main_model(&mut self) -> Result<String, ReadFault> {
        if self.has("_rels/.rels") {
            let mut reader = Reader::from_reader(self.part("_rels/.rels")?);
            let mut buffer = Vec::new();
            loop {
                buffer.clear();
                reader.get_mut().get_mut().event = 0;
                let event = reader.read_event_into(&mut buffer);
                match event.map_err(|error| ReadFault::Damaged(format!("_rels/.rels: {error}")))? {
                    Event::Start(tag) | Event::Empty(tag) => {
                        let of = |name: &str| {
                            let attribute = tag.try_get_attribute(name).ok().flatten();
                            attribute.map(|attribute| {
                                String::from_utf8_lossy(&attribute.value).into_owned()
                            })
                        };
                        let is_model = of("Type").is_some_and(|value| value.ends_with(MODEL_TYPE));
                        if let Some(target) = of("Target").filter(|_| is_model) {
                            return Ok(target);
                        }
                    }
                    Event::Eof => break,
                    _ => {}
                }
            }
        }
        // Without a name, there must be one model.
        let usual = "3D/3dmodel.model";
        let mut models = self.places.keys().filter(|name| name.ends_with(".model"));
        match (models.next(), models.next()) {
            _ if self.has(usual) => Ok(usual.into()),
            (Some(only), None) => Ok(only.clone()),
            (None, _) => Err("the archive has no 3D/3dmodel.model".into()),
            _ => Err("the archive has several models, and _rels/.rels names none".into()),
        }
    }
}

/// An open part.
pub(super) type Part<'p, 'a> = BufReader<Limited<'p, ZipFile<'p, Cursor<&'a [u8]>>>>;

/// Bytes of a part, of which the archive may unpack a limited number.
pub(super) struct Limited<'a, R> {
    file: R,
    limit: u64,
    left: &'a mut u64,
    /// Bytes since the last event, which whoever reads sets to 0.
    pub(super) event: u64,
}

impl<R: Read> Read for Limited<'_, R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(out)?;
        match self.left.checked_sub(count as u64) {
            Some(left) => *self.left = left,
            None => return Err(io::Error::other(TooMuch(self.limit))),
        }
        self.event += count as u64;
        if self.event > MAX_EVENT {
            return Err(io::Error::other(format!(
                "a tag or a text is longer than {MAX_EVENT} bytes"
            )));
        }
        Ok(count)
    }
}

/// More was unpacked than the limit.
#[derive(Debug)]
struct TooMuch(u64);

impl std::fmt::Display for TooMuch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let limit = self.0;
        write!(
            f,
            "it unpacks to more than {limit} bytes, {UNPACKED_PER_BYTE} per byte of the file: it is damaged, or a bomb"
        )
    }
}

impl std::error::Error for TooMuch {}

/// Returns a fault of a part.
pub(super) fn fault(name: &str, error: &io::Error) -> ReadFault {
    match error.get_ref().is_some_and(|inner| inner.is::<TooMuch>()) {
        true => ReadFault::TooLarge(error.to_string()),
        false => ReadFault::Damaged(format!("{name}: {error}")),
    }
}
