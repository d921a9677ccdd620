//! Reads numbers and checks that they are there.

use crate::{Mask, VdbError};

/// A position in bytes.
#[derive(Clone, Copy)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    pub(crate) fn position(&self) -> usize {
        self.at
    }

    pub(crate) fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    pub(crate) fn take(&mut self, count: usize, what: &'static str) -> Result<&'a [u8], VdbError> {
        let bytes = self
            .at
            .checked_add(count)
            .and_then(|end| self.bytes.get(self.at..end));
        let bytes = bytes.ok_or(VdbError::Truncated {
            at: self.bytes.len() as u64,
            what,
        })?;
        self.at += count;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], VdbError> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N, what)?);
        Ok(bytes)
    }

    pub(crate) fn u8(&mut self, what: &'static str) -> Result<u8, VdbError> {
        Ok(self.array::<1>(what)?[0])
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, VdbError> {
        Ok(u32::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn i32(&mut self, what: &'static str) -> Result<i32, VdbError> {
        Ok(i32::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn u64(&mut self, what: &'static str) -> Result<u64, VdbError> {
        Ok(u64::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn i64(&mut self, what: &'static str) -> Result<i64, VdbError> {
        Ok(i64::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn f64(&mut self, what: &'static str) -> Result<f64, VdbError> {
        Ok(f64::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn place(&mut self, what: &'static str) -> Result<[i32; 3], VdbError> {
        Ok([self.i32(what)?, self.i32(what)?, self.i32(what)?])
    }

    pub(crate) fn string(&mut self, what: &'static str) -> Result<String, VdbError> {
        let length = self.u32(what)? as usize;
        let bytes = self.take(length, what)?;
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    pub(crate) fn mask<const N: usize>(&mut self, what: &'static str) -> Result<Mask<N>, VdbError> {
        let mut mask = Mask::default();
        let bytes = self.take(8 * N, what)?;
        for (word, chunk) in mask.0.iter_mut().zip(bytes.as_chunks::<8>().0) {
            *word = u64::from_le_bytes(*chunk);
        }
        Ok(mask)
    }

    pub(crate) fn damaged(&self, what: impl Into<String>) -> VdbError {
        VdbError::Damaged {
            at: self.at as u64,
            what: what.into(),
        }
    }
}

pub(crate) fn write_string(text: &str, out: &mut Vec<u8>) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

pub(crate) fn write_place(place: [i32; 3], out: &mut Vec<u8>) {
    out.extend(place.iter().flat_map(|c| c.to_le_bytes()));
}
