//! A flip-book: all layers of a box side by side in one PNG image, as game engines read volumes.

use super::dense::{lattice, sample};
use super::options::{ExportClass, ExportError, ExportOptions};
use super::work::{ExportSink, ExportStages, Written, tiles, write_failed};
use crate::World;
use argil_field::Grid;
use argil_volume::LevelSetLayout;
use glam::{UVec3, Vec3};

/// Maximum pixels along a side of the image, which is that of textures.
const MAX_SIDE: u32 = 16_384;

pub(super) fn write(
    world: &World,
    layout: LevelSetLayout,
    options: &ExportOptions,
    out: &mut &mut dyn ExportSink,
    stages: &mut ExportStages,
) -> Result<Written, ExportError> {
    let (low, size) = lattice(&layout)?;
    let [columns, rows] = tiles(size.z);
    let (width, height) = (columns * size.x, rows * size.y);
    if width.max(height) > MAX_SIDE {
        let text = format!(
            "the layers take {width} × {height} pixels: at most {MAX_SIDE} along a side are written; use larger voxels"
        );
        return Err(ExportError::Option(text));
    }
    let control = &world.engine().control;
    control.begin("layers", size.z.into());
    let mut pixels = vec![0u8; 2 * width as usize * height as usize];
    for z in 0..size.z {
        world.check_export_cancelled()?;
        let part = Grid {
            min: layout.voxel_size * low.as_vec3(),
            spacing: Vec3::splat(layout.voxel_size),
            begin: UVec3::new(0, 0, z),
            size: UVec3::new(size.x, size.y, 1),
        };
        let values = sample(world, &layout, options.class, &part);
        let (left, top) = (z % columns * size.x, z / columns * size.y);
        for (y, row) in values.chunks(size.x as usize).enumerate() {
            // y points up, and rows of an image go down.
            let line = top + size.y - 1 - y as u32;
            let first = 2 * (line as usize * width as usize + left as usize);
            for (pixel, &value) in pixels[first..].as_chunks_mut::<2>().0.iter_mut().zip(row) {
                *pixel = code(value, options.class, layout.half_width()).to_be_bytes();
            }
        }
        control.advance(1);
    }
    stages.done("layers");
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let failed = |error: png::EncodingError| write_failed(std::io::Error::other(error));
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&pixels).map_err(failed)?;
    writer.finish().map_err(failed)?;
    stages.done("write");
    let high = low + size.as_ivec3() - 1;
    let count = size.to_array().map(u64::from).iter().product();
    Ok((Some([low.to_array(), high.to_array()]), count))
}

/// Returns a density from 0 to 65,535, or a distance: 0 at half the band's width inside, 65,535 outside.
fn code(value: f32, class: ExportClass, half_width: f32) -> u16 {
    let share = match class {
        ExportClass::Fog => value,
        ExportClass::LevelSet => 0.5 + 0.5 * value / half_width,
    };
    (65_535.0 * share.clamp(0.0, 1.0)).round() as u16
}
