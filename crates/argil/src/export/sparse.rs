//! `.vdb` and `.nvdb`.

use super::options::{ExportClass, ExportError, ExportFormat, ExportOptions};
use super::work::{ExportSink, ExportStages, Written, density, write_failed};
use crate::World;
use argil_vdb::nvdb::{self, NanoType};
use argil_vdb::vdb::{self, WriteOptions};
use argil_vdb::{AnyGrid, Grid, GridClass, GridHeader, Leaf, Mask, Transform, Tree, Upper};
use argil_volume::{LevelSetBaker, LevelSetLayout, LevelSetLeaf};
use rayon::prelude::*;

/// Voxels along the side of an upper node.
const UPPER_VOXELS: u32 = 4096;

pub(super) fn write(
    world: &World,
    layout: LevelSetLayout,
    (format, options): (ExportFormat, &ExportOptions),
    out: &mut &mut dyn ExportSink,
    stages: &mut ExportStages,
) -> Result<Written, ExportError> {
    let control = &world.engine().control;
    control.begin("regions", 0);
    let baker = LevelSetBaker::new(world.program(), layout, UPPER_VOXELS, control);
    world.check_export_cancelled()?;
    stages.done("regions");
    control.begin("leaves", baker.task_count() as u64);
    let band = layout.half_width();
    let mut tree = Tree::new(band);
    let mut colors = Tree::new([0.0; 3]);
    for part in baker.parts() {
        let leaves = baker.bake(part, options.colors, control);
        world.check_export_cancelled()?;
        let (of_distances, of_colors): (Vec<_>, Vec<_>) =
            leaves.into_par_iter().map(|leaf| split(leaf, band)).unzip();
        if !of_distances.is_empty() {
            tree.uppers
                .push(Upper::from_leaves(part, band, of_distances));
        }
        let of_colors: Vec<_> = of_colors.into_iter().flatten().collect();
        if !of_colors.is_empty() {
            colors
                .uppers
                .push(Upper::from_leaves(part, [0.0; 3], of_colors));
        }
    }
    stages.done("leaves");
    tree.flood_signs();
    if options.class == ExportClass::Fog {
        to_densities(&mut tree);
    }
    stages.done("signs");
    let statistics = tree.statistics();
    let transform = Transform::uniform(f64::from(layout.voxel_size), [0.0; 3]);
    let (name, class) = match options.class {
        ExportClass::LevelSet => ("surface", GridClass::LevelSet),
        ExportClass::Fog => ("density", GridClass::FogVolume),
    };
    control.begin("file", 0);
    let grid = Grid::new(GridHeader::new(name, class, transform), tree);
    if format == ExportFormat::Nvdb {
        let kind = match options.bits {
            8 => NanoType::Fp8,
            16 => NanoType::Fp16,
            _ => NanoType::Float,
        };
        nvdb::write(out, &grid, kind).map_err(write_failed)?;
    } else {
        let mut grids: Vec<AnyGrid> = vec![grid.into()];
        if options.colors {
            let header = GridHeader::new("Cd", GridClass::Unknown, transform);
            grids.push(Grid::new(header, colors).into());
        }
        let how = WriteOptions {
            codec: options.codec.into(),
            is_half: options.bits == 16,
            ..WriteOptions::default()
        };
        vdb::write(out, &grids, &how).map_err(write_failed)?;
    }
    stages.done("write");
    let count = statistics.active_voxels;
    Ok(((count > 0).then_some(statistics.bounds), count))
}

/// Splits baked samples into a leaf of distances and one of colors. Voxels in the band are active.
fn split(baked: LevelSetLeaf, band: f32) -> (Leaf<f32>, Option<Leaf<[f32; 3]>>) {
    let LevelSetLeaf {
        origin,
        mut values,
        colors,
    } = baked;
    let mut active = Mask::default();
    for (word, values) in active.0.iter_mut().zip(values.as_chunks_mut::<64>().0) {
        for (bit, value) in values.iter_mut().enumerate() {
            let is_near = value.abs() < band;
            *word |= u64::from(is_near) << bit;
            *value = if is_near {
                *value
            } else {
                band.copysign(*value)
            };
        }
    }
    let colors = colors.map(|mut values| {
        for (place, color) in values.iter_mut().enumerate() {
            if !active.is_on(place) {
                *color = [0.0; 3];
            }
        }
        Leaf {
            origin,
            active: active.clone(),
            values,
        }
    });
    let leaf = Leaf {
        origin,
        active,
        values,
    };
    (leaf, colors)
}

/// Turns a level set into densities: everything inside is active.
fn to_densities(tree: &mut Tree<f32>) {
    let band = tree.background;
    tree.background = 0.0;
    let of = |value: &mut f32| {
        *value = density(*value, band);
        *value > 0.0
    };
    for tile in &mut tree.tiles {
        tile.is_active = of(&mut tile.value);
    }
    for upper in &mut tree.uppers {
        for (place, value) in upper.tiles.iter_mut().enumerate() {
            upper.active.set(place, of(value));
        }
        upper.lowers.par_iter_mut().for_each(|lower| {
            for (place, value) in lower.tiles.iter_mut().enumerate() {
                lower.active.set(place, of(value));
            }
            for leaf in &mut lower.leaves {
                for (place, value) in leaf.values.iter_mut().enumerate() {
                    leaf.active.set(place, of(value));
                }
            }
        });
    }
}
