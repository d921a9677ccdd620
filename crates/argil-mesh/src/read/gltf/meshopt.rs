//! Views that meshopt has compressed (`EXT_meshopt_compression`), by its library.

use super::super::error::ReadFault;
use super::json::Compressed;

/// Returns a view's bytes.
///
/// # Errors
/// If they cannot be decoded, or this program has no decoder.
#[cfg(any(target_arch = "wasm32", not(feature = "simplify")))]
pub(super) fn decode(_: &[u8], _: &Compressed) -> Result<Vec<u8>, ReadFault> {
    let reason = "its meshes are compressed with meshopt, which is not read in a browser, or without the feature `simplify`: \
         export it without, for example by `gltf-transform cp in.glb out.glb`";
    Err(ReadFault::Unsupported(reason.into()))
}

/// Returns a view's bytes.
///
/// # Errors
/// If they cannot be decoded.
#[cfg(all(not(target_arch = "wasm32"), feature = "simplify"))]
pub(super) fn decode(stored: &[u8], view: &Compressed) -> Result<Vec<u8>, ReadFault> {
    use meshopt::encoding::{decode_index_buffer, decode_index_sequence};
    let damaged = || ReadFault::Damaged("a view that meshopt has compressed is damaged".into());
    let (count, stride) = (view.count, view.byte_stride);
    let bytes = match (&view.mode[..], stride) {
        ("ATTRIBUTES", _) => return attributes(stored, view),
        ("TRIANGLES", _) if count % 3 != 0 => return Err(damaged()),
        ("TRIANGLES", 2) => decode_index_buffer::<u16>(stored, count).map(bytes_of),
        ("TRIANGLES", 4) => decode_index_buffer::<u32>(stored, count).map(bytes_of),
        ("INDICES", 2) => decode_index_sequence::<u16>(stored, count).map(bytes_of),
        ("INDICES", 4) => decode_index_sequence::<u32>(stored, count).map(bytes_of),
        _ => return Err(damaged()),
    };
    bytes.map_err(|_| damaged())
}

#[cfg(all(not(target_arch = "wasm32"), feature = "simplify"))]
fn bytes_of<T: bytemuck::NoUninit>(all: Vec<T>) -> Vec<u8> {
    bytemuck::cast_slice(&all).to_vec()
}

/// Decodes vertices of `N` words, and undoes the filter.
#[cfg(all(not(target_arch = "wasm32"), feature = "simplify"))]
fn vertices<const N: usize>(stored: &[u8], view: &Compressed) -> Option<Vec<u8>>
where
    [u32; N]: Default + bytemuck::Pod,
{
    use meshopt::encoding::{decode_filter_exp, decode_filter_oct, decode_filter_quat};
    let mut all = meshopt::decode_vertex_buffer::<[u32; N]>(stored, view.count).ok()?;
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut all);
    match (view.filter.as_deref().unwrap_or("NONE"), N) {
        ("NONE" | "COLOR", _) => {}
        ("EXPONENTIAL", _) => decode_filter_exp(&mut all),
        ("OCTAHEDRAL", 1) => {
            let words: &mut [[i8; 4]] = bytemuck::cast_slice_mut(bytes);
            decode_filter_oct(words);
        }
        ("OCTAHEDRAL", 2) => {
            let words: &mut [[i16; 4]] = bytemuck::cast_slice_mut(bytes);
            decode_filter_oct(words);
        }
        ("QUATERNION", 2) => {
            let words: &mut [[i16; 4]] = bytemuck::cast_slice_mut(bytes);
            decode_filter_quat(words);
        }
        _ => return None,
    }
    Some(bytes_of(all))
}

#[cfg(all(not(target_arch = "wasm32"), feature = "simplify"))]
fn attributes(stored: &[u8], view: &Compressed) -> Result<Vec<u8>, ReadFault> {
    macro_rules! by_words {
        ($($words:literal)*) => {
            match view.byte_stride {
                $(stride if stride == 4 * $words => vertices::<$words>(stored, view),)*
                _ => None,
            }
        };
    }
    let bytes = by_words!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16);
    bytes.ok_or_else(|| {
        format!(
            "a view that meshopt has compressed, of {} vertices of {} bytes, is damaged",
            view.count, view.byte_stride
        )
        .into()
    })
}
