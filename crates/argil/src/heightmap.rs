//! Reads heightmap images.

#[cfg(feature = "png")]
use crate::limits::MAX_IMAGE_PIXELS;
use argil_mesh::MeshReadError;
use argil_scene::SampledGrid;
use std::path::Path;

/// Returns the heights of a PNG image, from 0 for black to 1 for white. `resolution` limits the posts along the
/// longer side; a finer image is averaged. Colors count by their luminance. `place` appears in messages.
#[cfg(feature = "png")]
pub(crate) fn heights(
    bytes: &[u8],
    posts: u32,
    place: &Path,
) -> Result<SampledGrid, MeshReadError> {
    let damaged = |reason: String| MeshReadError::Damaged {
        path: place.into(),
        kind: "PNG",
        reason,
    };
    let wrong = |e: png::DecodingError| damaged(e.to_string());
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let (width, height) = reader.info().size();
    if u64::from(width) * u64::from(height) > MAX_IMAGE_PIXELS {
        return Err(MeshReadError::TooLarge {
            path: place.into(),
            what: format!(
                "{width} × {height} pixels: heights are read of up to {MAX_IMAGE_PIXELS}; make it smaller"
            ),
        });
    }
    if width < 2 || height < 2 {
        return Err(MeshReadError::Unsupported {
            path: place.into(),
            what: format!("{width} × {height} pixels: heights need two along each side"),
        });
    }
    let size = reader.output_buffer_size();
    let mut pixels = vec![0; size.ok_or_else(|| damaged("it is too large".into()))?];
    let frame = reader.next_frame(&mut pixels).map_err(wrong)?;
    let channels = frame.color_type.samples();
    let is_wide = frame.bit_depth == png::BitDepth::Sixteen;
    let bytes_each = if is_wide { 2 } else { 1 };
    let value = |pixel: usize, channel: usize| {
        let at = (pixel * channels + channel) * bytes_each;
        if is_wide {
            f32::from(u16::from_be_bytes([pixels[at], pixels[at + 1]])) / 65_535.0
        } else {
            f32::from(pixels[at]) / 255.0
        }
    };
    // The luminance weights of Rec. ITU-R BT.709.
    let brightness = |pixel: usize| match channels {
        3.. => 0.2126 * value(pixel, 0) + 0.7152 * value(pixel, 1) + 0.0722 * value(pixel, 2),
        _ => value(pixel, 0),
    };
    let longer = width.max(height);
    let kept = |n: u32| match longer > posts {
        true => ((u64::from(n) * u64::from(posts)).div_ceil(u64::from(longer)) as u32).max(2),
        false => n,
    };
    let [nx, nz] = [width, height].map(kept);
    let span = |i: u32, of: u32, n: u32| {
        let edge = |i: u32| (u64::from(i) * u64::from(of) / u64::from(n)) as usize;
        edge(i)..edge(i + 1)
    };
    let mut heights = Vec::with_capacity((nx * nz) as usize);
    for k in 0..nz {
        for i in 0..nx {
            let (rows, columns) = (span(k, height, nz), span(i, width, nx));
            let count = (rows.len() * columns.len()) as f64;
            let covered = rows.flat_map(|row| {
                let first = row * width as usize;
                columns.clone().map(move |column| first + column)
            });
            let sum: f64 = covered.map(|pixel| f64::from(brightness(pixel))).sum();
            heights.push(((sum / count) as f32).clamp(0.0, 1.0));
        }
    }
    SampledGrid::from_heights([nx, nz], &heights).ok_or_else(|| damaged("it has no heights".into()))
}

#[cfg(not(feature = "png"))]
pub(crate) fn heights(_: &[u8], _: u32, place: &Path) -> Result<SampledGrid, MeshReadError> {
    Err(MeshReadError::Unsupported {
        path: place.into(),
        what: "this was built without the feature png, which reads heights".into(),
    })
}

#[cfg(all(test, feature = "png"))]
mod tests {
    use super::*;

    fn image(size: [u32; 2], depth: png::BitDepth, color: png::ColorType, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(color);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(data).expect("its data");
        writer.finish().expect("its end");
        bytes
    }

    #[test]
    fn images_are_heights() {
        use png::{BitDepth, ColorType};
        let of = |bytes: &[u8], posts| heights(bytes, posts, Path::new("a.png"));
        let sixteen = image(
            [3, 2],
            BitDepth::Sixteen,
            ColorType::Grayscale,
            &[0, 0, 255, 255, 128, 0, 0, 1, 0, 0, 0, 0],
        );
        let grid = of(&sixteen, 16).expect("heights");
        let all = &grid.words()[argil_scene::SAMPLED_HEADER..];
        let expected = [0.0, 1.0, 32_768.0 / 65_535.0, 1.0 / 65_535.0, 0.0, 0.0];
        assert!(
            all.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6),
            "{all:?}"
        );
        // Of colors their brightness; of one bit, black and white.
        let colors = image(
            [2, 2],
            BitDepth::Eight,
            ColorType::Rgb,
            &[255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255],
        );
        let grid = of(&colors, 16).expect("heights");
        let all = &grid.words()[argil_scene::SAMPLED_HEADER..];
        assert!(
            (all[0] - 0.2126).abs() < 1e-4 && (all[3] - 1.0).abs() < 1e-4,
            "{all:?}"
        );
        let bits = image(
            [8, 2],
            BitDepth::One,
            ColorType::Grayscale,
            &[0b1000_0000, 0],
        );
        let grid = of(&bits, 16).expect("heights");
        assert_eq!(grid.words()[argil_scene::SAMPLED_HEADER..][..2], [1.0, 0.0]);
        // Finer than asked for: their means.
        let fine = image(
            [64, 32],
            BitDepth::Eight,
            ColorType::Grayscale,
            &[51; 64 * 32],
        );
        let grid = of(&fine, 16).expect("heights");
        let words = grid.words();
        assert_eq!((words[4], words[6]), (16.0, 8.0));
        assert!(
            words[argil_scene::SAMPLED_HEADER..]
                .iter()
                .all(|h| (h - 0.2).abs() < 1e-6)
        );
        // What is none.
        assert!(of(b"no image", 16).is_err() && of(&sixteen[..40], 16).is_err());
        let line = image([5, 1], BitDepth::Eight, ColorType::Grayscale, &[0; 5]);
        let refused = of(&line, 16).expect_err("a line");
        assert!(
            refused.to_string().contains("two along each side"),
            "{refused}"
        );
    }
}
