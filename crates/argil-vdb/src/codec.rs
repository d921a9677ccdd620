//! Compression of values: zip, and Blosc with LZ4.
//!
//! The container is that of Blosc 1 (<https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>): a header of 16
//! bytes, the offsets of blocks, and in each block a compressed stream, or one for each byte of a value.

use std::io::{Read, Write};

/// How values are compressed in a `.vdb` file. Inactive values are left out in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Codec {
    /// Not at all. Fastest, and any program reads it.
    #[default]
    None,
    /// Zlib. Smallest.
    Zip,
    /// Blosc with LZ4 and shuffled bytes, as OpenVDB compresses by default.
    Blosc,
}

const SHUFFLED: u8 = 1;
const STORED: u8 = 2;
const BIT_SHUFFLED: u8 = 4;
const NOT_SPLIT: u8 = 16;
const LZ4: u8 = 1;

/// Appends compressed bytes with their length, or the bytes themselves with their negative length.
pub(crate) fn pack(codec: Codec, bytes: &[u8], value_bytes: usize, out: &mut Vec<u8>) {
    let packed = match codec {
        Codec::None => {
            out.extend(bytes);
            return;
        }
        Codec::Zip => zip(bytes),
        Codec::Blosc => blosc(bytes, value_bytes),
    };
    match packed.filter(|packed| packed.len() < bytes.len()) {
        Some(packed) => {
            out.extend((packed.len() as i64).to_le_bytes());
            out.extend(packed);
        }
        None => {
            out.extend((-(bytes.len() as i64)).to_le_bytes());
            out.extend(bytes);
        }
    }
}

fn zip(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).ok()?;
    encoder.finish().ok()
}

/// Decompresses bytes whose length is known. Returns `None` if they are damaged.
pub(crate) fn unzip(bytes: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(length);
    let decoder = flate2::read::ZlibDecoder::new(bytes);
    decoder.take(length as u64 + 1).read_to_end(&mut out).ok()?;
    (out.len() == length).then_some(out)
}

fn blosc(bytes: &[u8], value_bytes: usize) -> Option<Vec<u8>> {
    let packed = lz4_flex::block::compress(&shuffled(bytes, value_bytes));
    let length = 16 + 4 + 4 + packed.len();
    if packed.len() >= bytes.len() {
        return None;
    }
    // One block with one stream.
    let mut out = vec![2, 1, SHUFFLED | NOT_SPLIT | LZ4 << 5, value_bytes as u8];
    for word in [bytes.len(), bytes.len(), length, 20, packed.len()] {
        out.extend((word as u32).to_le_bytes());
    }
    out.extend(packed);
    Some(out)
}

/// Decompresses a Blosc chunk whose length is known. Returns why it cannot be read.
pub(crate) fn unblosc(bytes: &[u8], length: usize) -> Result<Vec<u8>, &'static str> {
    const SHORT: &str = "a Blosc chunk is too short";
    let head = bytes.get(..16).ok_or(SHORT)?;
    let word = |at: usize| {
        let four = bytes.get(at..at + 4).ok_or(SHORT)?;
        Ok::<_, &'static str>(u32::from_le_bytes([four[0], four[1], four[2], four[3]]) as usize)
    };
    let (flags, value_bytes) = (head[2], usize::from(head[3]).max(1));
    let (total, block) = (word(4)?, word(8)?);
    if total != length {
        return Err("a Blosc chunk has another length than its values");
    }
    if flags & STORED != 0 {
        let stored = bytes.get(16..16 + length).ok_or(SHORT)?;
        return Ok(stored.to_vec());
    }
    if flags >> 5 != LZ4 {
        return Err("a Blosc chunk is not compressed with LZ4, the only method that is supported");
    }
    if flags & BIT_SHUFFLED != 0 || block == 0 {
        return Err("a Blosc chunk is shuffled by bits, which is not supported");
    }
    let mut out = Vec::with_capacity(length);
    for (i, begin) in (0..length).step_by(block).enumerate() {
        let size = block.min(length - begin);
        let is_rest = size < block;
        let is_split =
            flags & NOT_SPLIT == 0 && value_bytes <= 16 && block / value_bytes >= 128 && !is_rest;
        let streams = if is_split { value_bytes } else { 1 };
        let mut at = word(16 + 4 * i)?;
        let first = out.len();
        for _ in 0..streams {
            let packed = word(at)?;
            let stream = bytes
                .get(at + 4..)
                .and_then(|rest| rest.get(..packed))
                .ok_or(SHORT)?;
            let unpacked = size / streams;
            if packed == unpacked {
                out.extend(stream);
            } else {
                let stream = lz4_flex::block::decompress(stream, unpacked);
                let stream = stream.map_err(|_| "an LZ4 stream is damaged")?;
                if stream.len() != unpacked {
                    return Err("an LZ4 stream has another length than its values");
                }
                out.extend(stream);
            }
            at += 4 + packed;
        }
        if flags & SHUFFLED != 0 && value_bytes > 1 {
            let values = unshuffled(&out[first..], value_bytes);
            out.truncate(first);
            out.extend(values);
        }
    }
    if out.len() == length {
        Ok(out)
    } else {
        Err(SHORT)
    }
}

/// Gathers the first bytes of all values, then the second ones, and so on. Bytes after the last whole value stay.
fn shuffled(bytes: &[u8], value_bytes: usize) -> Vec<u8> {
    let count = bytes.len() / value_bytes;
    let mut out = Vec::with_capacity(bytes.len());
    for part in 0..value_bytes {
        out.extend((0..count).map(|i| bytes[i * value_bytes + part]));
    }
    out.extend(&bytes[count * value_bytes..]);
    out
}

fn unshuffled(bytes: &[u8], value_bytes: usize) -> Vec<u8> {
    let count = bytes.len() / value_bytes;
    let mut out = Vec::with_capacity(bytes.len());
    for i in 0..count {
        out.extend((0..value_bytes).map(|part| bytes[part * count + i]));
    }
    out.extend(&bytes[count * value_bytes..]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_bytes_come_back() {
        let smooth: Vec<u8> = (0..512u32)
            .flat_map(|i| (1.0 + i as f32 * 1e-3).to_le_bytes())
            .collect();
        for codec in [Codec::Zip, Codec::Blosc] {
            let mut out = Vec::new();
            pack(codec, &smooth, 4, &mut out);
            let length = i64::from_le_bytes(out[..8].try_into().expect("8 bytes"));
            assert!(length > 0 && (length as usize) < smooth.len(), "{codec:?}");
            let back = match codec {
                Codec::Zip => unzip(&out[8..], smooth.len()).expect("bytes"),
                _ => unblosc(&out[8..], smooth.len()).expect("bytes"),
            };
            assert_eq!(back, smooth, "{codec:?}");
            // Too short, and another length.
            assert!(unzip(&out[8..], smooth.len() - 1).is_none());
            assert!(unblosc(&out[8..out.len() - 1], smooth.len()).is_err());
        }
    }
}
