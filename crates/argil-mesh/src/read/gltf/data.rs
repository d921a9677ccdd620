//! Buffers, views and accessors: the numbers of a glTF file.

use super::super::budget::{Budget, Purpose};
use super::super::error::ReadFault;
use super::json::{AccessorJson, BufferJson, Root, SparseJson, ViewJson, element};
use super::meshopt;
use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::collections::HashMap;
use std::ops::Deref;
use std::rc::Rc;

/// Memory that an element takes in a mesh, where the file stores none of its bytes.
const ZERO_BYTES: u64 = 64;

/// Bytes of the file, or unpacked ones.
#[derive(Clone)]
enum Bytes<'a> {
    Stored(&'a [u8]),
    Unpacked(Rc<Vec<u8>>),
}

impl Deref for Bytes<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Stored(bytes) => bytes,
            Self::Unpacked(bytes) => bytes,
        }
    }
}

/// A file's numbers, unpacked as they are needed.
pub(super) struct Data<'a> {
    root: &'a Root<'a>,
    /// The binary chunk of a GLB.
    chunk: Option<&'a [u8]>,
    /// Other files, by their addresses.
    files: &'a [(String, Vec<u8>)],
    buffers: HashMap<usize, Bytes<'a>>,
    views: HashMap<usize, Rc<Vec<u8>>>,
    accessors: HashMap<usize, Rc<Accessor<'a>>>,
    budget: Budget,
}

/// Returns the bytes of a `data:` address, or `None` of another.
pub(super) fn of_data_uri(uri: &str) -> Option<Result<Vec<u8>, ReadFault>> {
    let (kind, text) = uri.strip_prefix("data:")?.split_once(',')?;
    if !kind.ends_with(";base64") {
        return Some(Err("a buffer's data are not base64".into()));
    }
    let config = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    let engine = GeneralPurpose::new(&base64::alphabet::STANDARD, config);
    let bytes = engine.decode(text.trim_ascii());
    Some(bytes.map_err(|error| format!("a buffer's data: {error}").into()))
}

impl<'a> Data<'a> {
    pub(super) fn new(
        root: &'a Root<'a>,
        chunk: Option<&'a [u8]>,
        files: &'a [(String, Vec<u8>)],
        file_bytes: usize,
    ) -> Self {
        Self {
            root,
            chunk,
            files,
            buffers: HashMap::new(),
            views: HashMap::new(),
            accessors: HashMap::new(),
            budget: Budget::new(Purpose::Data, file_bytes),
        }
    }

    fn buffer(&mut self, index: usize) -> Result<Bytes<'a>, ReadFault> {
        if let Some(bytes) = self.buffers.get(&index) {
            return Ok(bytes.clone());
        }
        let json: BufferJson = element(&self.root.buffers, index, "buffer")?;
        let bytes = match json.uri {
            None => {
                let chunk = self.chunk.filter(|_| index == 0);
                Bytes::Stored(
                    chunk.ok_or_else(|| format!("the data of buffer {index} are missing"))?,
                )
            }
            Some(uri) => match of_data_uri(&uri) {
                Some(bytes) => Bytes::Unpacked(Rc::new(bytes?)),
                None => {
                    let file = self.files.iter().find(|(name, _)| *name == uri);
                    let (_, bytes) = file.ok_or_else(|| {
                        format!("the file \"{uri}\", which has its data, is missing")
                    })?;
                    Bytes::Stored(bytes)
                }
            },
        };
        self.buffers.insert(index, bytes.clone());
        Ok(bytes)
    }

    /// Returns a part of a buffer.
    fn slice(
        &mut self,
        buffer: usize,
        offset: usize,
        length: usize,
    ) -> Result<Slice<'a>, ReadFault> {
        let bytes = self.buffer(buffer)?;
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len());
        match end {
            Some(_) => Ok(Slice {
                bytes,
                offset,
                length,
            }),
            None => Err(format!(
                "its data lie outside the buffer: bytes {offset} to {} of {}",
                offset.saturating_add(length),
                bytes.len()
            )
            .into()),
        }
    }

    /// Returns a view's bytes and its stride.
    fn view(&mut self, index: usize) -> Result<(Slice<'a>, Option<usize>), ReadFault> {
        let view: ViewJson = element(&self.root.buffer_views, index, "buffer view")?;
        let Some(packed) = &view.extensions.meshopt else {
            let slice = self.slice(view.buffer, view.byte_offset, view.byte_length)?;
            return Ok((slice, view.byte_stride));
        };
        let bytes = match self.views.get(&index) {
            Some(bytes) => bytes.clone(),
            None => {
                let stored = self.slice(packed.buffer, packed.byte_offset, packed.byte_length)?;
                let size = packed.count.saturating_mul(packed.byte_stride);
                self.budget.take(size as u64)?;
                let bytes = Rc::new(meshopt::decode(&stored, packed)?);
                self.views.insert(index, bytes.clone());
                bytes
            }
        };
        let length = bytes.len();
        let bytes = Bytes::Unpacked(bytes);
        Ok((
            Slice {
                bytes,
                offset: 0,
                length,
            },
            Some(packed.byte_stride),
        ))
    }

    /// Opens an accessor of numbers, once.
    ///
    /// # Errors
    /// If its shape is another, or its numbers lie outside their buffer.
    pub(super) fn accessor(
        &mut self,
        index: usize,
        shape: &str,
    ) -> Result<Rc<Accessor<'a>>, ReadFault> {
        let accessor = match self.accessors.get(&index) {
            Some(accessor) => accessor.clone(),
            None => {
                let accessor = Rc::new(self.open(index)?);
                self.accessors.insert(index, accessor.clone());
                accessor
            }
        };
        if accessor.shape != shape {
            let reason = format!("accessor {index}: {} where {shape} belongs", accessor.shape);
            return Err(reason.into());
        }
        Ok(accessor)
    }

    fn open(&mut self, index: usize) -> Result<Accessor<'a>, ReadFault> {
        let accessor: AccessorJson = element(&self.root.accessors, index, "accessor")?;
        let fault = |reason: &str| ReadFault::Damaged(format!("accessor {index}: {reason}"));
        let kind =
            Kind::of(accessor.component_type).ok_or_else(|| fault("unsupported component type"))?;
        let width = match &accessor.shape[..] {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => return Err(fault("its type is neither SCALAR, VEC3 nor VEC4")),
        };
        let size = width * kind.size();
        let (slice, stride) = match accessor.buffer_view {
            Some(view) => {
                let (slice, stride) = self.view(view)?;
                (Some(slice), stride.unwrap_or(size))
            }
            None => (None, size),
        };
        let numbers = slice
            .map(|slice| Numbers::new(slice, accessor.byte_offset, stride, accessor.count, size));
        let numbers = match numbers {
            Some(numbers) => Some(numbers.ok_or_else(|| fault("its data lie outside the buffer"))?),
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(
                self.sparse(sparse, size)
                    .ok_or_else(|| fault("its sparse values are damaged"))?,
            ),
            None => None,
        };
        if numbers.is_none() && sparse.is_none() {
            return Err(fault("it has no data"));
        }
        if numbers.is_none() {
            self.budget
                .take((accessor.count as u64).saturating_mul(ZERO_BYTES))?;
        }
        Ok(Accessor {
            numbers,
            sparse,
            count: accessor.count,
            kind,
            shape: accessor.shape,
            is_normalized: accessor.normalized,
        })
    }

    fn sparse(&mut self, json: &SparseJson, size: usize) -> Option<Sparse<'a>> {
        let kind = Kind::of(json.indices.component_type?)?;
        let (slice, _) = self.view(json.indices.buffer_view).ok()?;
        let indices = Numbers::new(
            slice,
            json.indices.byte_offset,
            kind.size(),
            json.count,
            kind.size(),
        )?;
        let (slice, _) = self.view(json.values.buffer_view).ok()?;
        let values = Numbers::new(slice, json.values.byte_offset, size, json.count, size)?;
        let indices: Vec<u32> = (0..json.count).map(|i| kind.index(indices.at(i))).collect();
        indices
            .is_sorted_by(|a, b| a < b)
            .then_some(Sparse { indices, values })
    }
}

/// A part of a buffer or view.
struct Slice<'a> {
    bytes: Bytes<'a>,
    offset: usize,
    length: usize,
}

impl Deref for Slice<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes[self.offset..self.offset + self.length]
    }
}

/// Numbers at equal distances. All lie within the slice.
struct Numbers<'a> {
    slice: Slice<'a>,
    offset: usize,
    stride: usize,
    size: usize,
}

impl<'a> Numbers<'a> {
    fn new(
        slice: Slice<'a>,
        offset: usize,
        stride: usize,
        count: usize,
        size: usize,
    ) -> Option<Self> {
        let last = count.saturating_sub(1).checked_mul(stride)?;
        let end = last.checked_add(offset)?.checked_add(size)?;
        let is_inside = count == 0 || (end <= slice.length && stride >= size);
        is_inside.then_some(Self {
            slice,
            offset,
            stride,
            size,
        })
    }

    fn at(&self, index: usize) -> &[u8] {
        let start = self.offset + index * self.stride;
        &self.slice[start..start + self.size]
    }
}

struct Sparse<'a> {
    /// Indices of values that are replaced, in order.
    indices: Vec<u32>,
    values: Numbers<'a>,
}

/// A type of numbers.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Kind {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn number(self, bytes: &[u8], is_normalized: bool) -> f32 {
        let mut padded = [0; 4];
        let size = self.size();
        padded[..size].copy_from_slice(&bytes[..size]);
        let [a, b, ..] = padded;
        let (number, most) = match self {
            Self::I8 => (f32::from(a as i8), 127.0),
            Self::U8 => (f32::from(a), 255.0),
            Self::I16 => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
            Self::U16 => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
            Self::U32 => (u32::from_le_bytes(padded) as f32, u32::MAX as f32),
            Self::F32 => return f32::from_le_bytes(padded),
        };
        if is_normalized {
            (number / most).max(-1.0)
        } else {
            number
        }
    }

    /// Returns an index. One of a type that has no indices is one that nothing has.
    fn index(self, bytes: &[u8]) -> u32 {
        match (self, bytes) {
            (Self::U8, &[a, ..]) => a.into(),
            (Self::U16, &[a, b, ..]) => u16::from_le_bytes([a, b]).into(),
            (Self::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]),
            _ => u32::MAX,
        }
    }
}

/// Numbers or vectors, some of which may be replaced.
pub(super) struct Accessor<'a> {
    numbers: Option<Numbers<'a>>,
    sparse: Option<Sparse<'a>>,
    pub(super) count: usize,
    kind: Kind,
    shape: String,
    is_normalized: bool,
}

impl Accessor<'_> {
    /// Returns an element's bytes, or none of zeros.
    fn bytes(&self, index: usize) -> Option<&[u8]> {
        if let Some(sparse) = &self.sparse
            && let Ok(position) = sparse.indices.binary_search(&u32::try_from(index).ok()?)
        {
            return Some(sparse.values.at(position));
        }
        Some(self.numbers.as_ref()?.at(index))
    }

    /// Returns a vector, whose missing components are 0.
    ///
    /// # Panics
    /// If `index` is not less than `count`.
    pub(super) fn vector(&self, index: usize) -> [f32; 4] {
        let mut out = [0.0; 4];
        let Some(bytes) = self.bytes(index) else {
            return out;
        };
        for (out, bytes) in out.iter_mut().zip(bytes.chunks(self.kind.size())) {
            *out = self.kind.number(bytes, self.is_normalized);
        }
        out
    }

    /// Returns an index.
    ///
    /// # Panics
    /// If `index` is not less than `count`.
    pub(super) fn index(&self, index: usize) -> u32 {
        self.bytes(index).map_or(0, |bytes| self.kind.index(bytes))
    }

    /// Whether its numbers can be indices.
    pub(super) fn has_indices(&self) -> bool {
        matches!(self.kind, Kind::U8 | Kind::U16 | Kind::U32)
    }
}
