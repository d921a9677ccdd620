//! `.npy`, `.nrrd` and `.raw`: all samples of a box.

use super::options::{ExportClass, ExportError, ExportFormat, ExportOptions, ExportReport};
use super::work::{ExportSink, ExportStages, Written, density, write_failed};
use crate::World;
use argil_field::Grid;
use argil_volume::LevelSetLayout;
use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;
use std::io::Write;
use std::path::Path;

/// Layers of constant z that are sampled together.
const LAYERS: u32 = 32;
/// Maximum samples of a file.
const MAX_SAMPLES: u64 = 1 << 34;

pub(super) fn write(
    world: &World,
    layout: LevelSetLayout,
    (format, options): (ExportFormat, &ExportOptions),
    out: &mut &mut dyn ExportSink,
    stages: &mut ExportStages,
) -> Result<Written, ExportError> {
    let voxel = layout.voxel_size;
    let (low, size) = lattice(&layout)?;
    let high = low + size.as_ivec3() - 1;
    let count: u64 = size.to_array().map(u64::from).iter().product();
    if count > MAX_SAMPLES {
        let text = format!(
            "{count} samples: at most {MAX_SAMPLES} are written; use larger voxels, or write a .vdb file"
        );
        return Err(ExportError::Option(text));
    }
    out.write_all(&header(format, low, size, voxel))
        .map_err(write_failed)?;
    let control = &world.engine().control;
    control.begin("layers", size.z.into());
    for z in (0..size.z).step_by(LAYERS as usize) {
        world.check_export_cancelled()?;
        let layers = LAYERS.min(size.z - z);
        let part = Grid {
            min: voxel * low.as_vec3(),
            spacing: Vec3::splat(voxel),
            begin: UVec3::new(0, 0, z),
            size: UVec3::new(size.x, size.y, layers),
        };
        let values = sample(world, &layout, options.class, &part);
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        out.write_all(&bytes).map_err(write_failed)?;
        control.advance(layers.into());
    }
    stages.done("layers");
    Ok((Some([low.to_array(), high.to_array()]), count))
}

/// Returns the first index of a layout's box, and the number of samples along each axis.
pub(super) fn lattice(layout: &LevelSetLayout) -> Result<(IVec3, UVec3), ExportError> {
    if layout.region.is_empty() {
        return Err(ExportError::Option(
            "the scene is empty: there is no box to sample".into(),
        ));
    }
    let low = (layout.region.min / layout.voxel_size).floor().as_ivec3() - 1;
    let high = (layout.region.max / layout.voxel_size).ceil().as_ivec3() + 1;
    Ok((low, (high - low + 1).as_uvec3()))
}

/// Samples a part of a box, x fastest.
pub(super) fn sample(
    world: &World,
    layout: &LevelSetLayout,
    class: ExportClass,
    part: &Grid,
) -> Vec<f32> {
    let mut values = vec![0.0; part.len()];
    world.program().distances_pruned(part, &mut values);
    let [xs, ys, zs] = [0, 1, 2].map(|axis| part.coordinates(axis));
    let band = layout.half_width();
    let rows = values.par_chunks_mut(xs.len()).enumerate();
    rows.for_each(|(row, values)| {
        let (y, z) = (ys[row % ys.len()], zs[row / ys.len()]);
        if layout.is_cut {
            for (value, &x) in values.iter_mut().zip(&xs) {
                *value = value.max(layout.distance_to_cut(Vec3::new(x, y, z)));
            }
        }
        if class == ExportClass::Fog {
            for value in values {
                *value = density(*value, band);
            }
        }
    });
    values
}

fn header(format: ExportFormat, low: IVec3, size: UVec3, voxel: f32) -> Vec<u8> {
    let [nx, ny, nz] = size.to_array();
    match format {
        ExportFormat::Npy => {
            // https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
            let mut text = format!(
                "{{'descr': '<f4', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}"
            );
            // The whole header has a multiple of 64 bytes.
            let length = (10 + text.len() + 1).next_multiple_of(64);
            while 10 + text.len() + 1 < length {
                text.push(' ');
            }
            text.push('\n');
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend((text.len() as u16).to_le_bytes());
            bytes.extend(text.as_bytes());
            bytes
        }
        ExportFormat::Nrrd => {
            // https://teem.sourceforge.net/nrrd/format.html
            let [x, y, z] = (voxel * low.as_vec3()).to_array();
            format!(
                "NRRD0004\ntype: float\ndimension: 3\nsizes: {nx} {ny} {nz}\nendian: little\nencoding: raw\nspace dimension: 3\nspace directions: ({voxel},0,0) (0,{voxel},0) (0,0,{voxel})\nspace origin: ({x},{y},{z})\ncenters: node node node\n\n"
            )
            .into_bytes()
        }
        _ => Vec::new(),
    }
}

/// Returns the text of the file beside raw samples.
pub(super) fn sidecar(report: &ExportReport, path: &Path) -> String {
    let [low, high] = report.bounds.unwrap_or_default();
    let shape = [0, 1, 2].map(|axis| high[axis] - low[axis] + 1);
    let origin = low.map(|c| report.voxel_size * c as f32);
    let mut name = String::new();
    for c in path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .chars()
    {
        match c {
            '"' | '\\' => name.extend(['\\', c]),
            c if c.is_control() => name.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => name.push(c),
        }
    }
    format!(
        "{{\n  \"file\": \"{name}\",\n  \"type\": \"f32\",\n  \"endian\": \"little\",\n  \"order\": \"x fastest\",\n  \"shape\": {shape:?},\n  \"voxel_size\": {},\n  \"origin\": {origin:?}\n}}\n",
        report.voxel_size
    )
}
