//! Lists what a device would be given to compile, without a device.

use crate::bricks::{brick_modules, brick_ways};
use crate::dense::{DENSE, tile_side_within};
use crate::host_motion::motion_module;
use crate::image_textures::textures_module;
use crate::march_passes::{march_module, project_module, unindex_module};
use crate::near_lists::near_lists_module;
use crate::pass_module::PassModule;
use crate::query::query_module;
use crate::raster::MESH;
use crate::render::{FIELD, NEAR_FIELD, frame_module};
use crate::resolve::resolve_module;
use crate::texel_format::TexelFormat;
use crate::tile_source::TileSource;
use crate::trace_mode::TraceMode;
use crate::{dense, levels, octree, paths};
use argil_field::{Interpreter, Program};
use argil_volume::SampleFormat;

/// Voxels along the side of a brick, unless another size is asked for.
const DEFAULT_BRICK: u32 = 8;

/// A WGSL module as a device gets it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ShaderModule {
    /// What it is for, such as `Bricks::build`. Unique in a list of modules.
    pub name: String,
    /// The WGSL.
    pub source: String,
    /// Its passes.
    pub entry_points: Vec<ShaderEntryPoint>,
}

/// An entry point of a [`ShaderModule`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ShaderEntryPoint {
    /// The name of the function.
    pub name: &'static str,
    /// The values of overrides.
    pub constants: Vec<(&'static str, f64)>,
}

impl From<PassModule> for ShaderModule {
    fn from(module: PassModule) -> Self {
        let entry_points = module.entry_points.into_iter();
        Self {
            name: module.label.to_owned(),
            source: module.source,
            entry_points: entry_points
                .map(|entry_point| ShaderEntryPoint {
                    name: entry_point.name,
                    constants: entry_point.constants,
                })
                .collect(),
        }
    }
}

/// Returns all modules with compute passes that a hardware device can get for a program, with 8-bit samples in their own
/// format. Each entry point is compiled when it first runs, so a process compiles few of them.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Brush, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Brush::new(Shape::sphere(0.5)))?;
/// let modules = argil_gpu::hardware_modules(&Program::lower(&scene)?);
/// let build = modules.iter().find(|module| module.name == "Bricks::build");
/// assert!(build.is_some_and(|module| module.source.contains("fn fill_bricks")));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn hardware_modules(program: &Program) -> Vec<ShaderModule> {
    let interpreter = Interpreter::full(program)
        .with_subgroups(true)
        .with_turns(true);
    let (field, near) = (interpreter.wgsl(), interpreter.near_wgsl());
    let texels = TexelFormat::Plain(SampleFormat::Snorm8);
    // What every hardware device can do.
    let side = tile_side_within(256, dense::TILE);
    let mut all = brick_modules(interpreter, texels, DEFAULT_BRICK);
    let mut sources = vec![TileSource::of_any(field.clone())];
    sources.push(TileSource::of_lists(near.clone()));
    sources.extend(interpreter.column_wgsl().map(TileSource::of_columns));
    for source in &sources {
        all.push(dense::fill_module(source, texels, side));
        all.push(octree::fill_module(source, texels, side));
    }
    all.extend([
        octree::select_module(&field),
        octree::tree_module(),
        march_module(true),
        march_module(false),
        project_module(&field, false),
        project_module(&near, true),
        unindex_module(),
        query_module(&field, false),
        query_module(&near, true),
        resolve_module(),
        textures_module(),
        motion_module(&interpreter.motion_wgsl()),
    ]);
    let [flat, wide] = brick_ways();
    all.push(near_lists_module(&interpreter.near_lists_wgsl()));
    let ways: [&TraceMode; 8] = [
        &FIELD,
        &NEAR_FIELD,
        &DENSE,
        &octree::OCTREE,
        flat,
        wide,
        &levels::LEVELS,
        &MESH,
    ];
    for way in ways {
        let field = if way.by_lists { &near } else { &field };
        all.extend([false, true].map(|has_more| frame_module(field, way, has_more)));
        // Hardware traces paths through the whole field.
        let paths = way.paths.as_ref().filter(|_| !way.by_lists);
        all.extend(paths.map(|mode| paths::path_module(field, way, mode)));
    }
    all.into_iter().map(ShaderModule::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_scene::{Brush, Scene, Shape};

    /// Names tell modules apart, and each entry point is in its module's source.
    #[test]
    fn modules_have_names_and_their_entry_points() {
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sphere(0.5))).expect("a brush");
        let all = hardware_modules(&Program::lower(&scene).expect("a program"));
        let mut names: Vec<&str> = all.iter().map(|module| &module.name[..]).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len(), "{names:?}");
        for module in &all {
            for entry_point in &module.entry_points {
                let function = format!("fn {}(", entry_point.name);
                assert!(module.source.contains(&function), "{function}");
                for (constant, _) in &entry_point.constants {
                    let is_there = module.source.contains(&format!("override {constant}:"));
                    assert!(is_there, "{}: {constant}", module.name);
                }
            }
        }
    }
}
