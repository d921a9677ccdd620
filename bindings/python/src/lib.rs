//! The native part of the Python package `argil`. Its front in `python/argil` has the names, the docs and the types.

mod arrays;
mod ask;
mod axes;
mod bricks;
mod errors;
mod function;
mod mesh;
mod node;
mod outlines;
mod part;
mod pictures;
mod scene;
mod solid;
mod tree;
mod work;
mod worlds;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    use super::*;

    #[pymodule_export]
    use super::errors::SceneError;
    #[pymodule_export]
    use super::function::sample_function;
    #[pymodule_export]
    use super::mesh::Mesh;
    #[pymodule_export]
    use super::node::Node;
    #[pymodule_export]
    use super::outlines::{image_profile, text_outlines};
    #[pymodule_export]
    use super::pictures::{encode_png, write_gif, write_png};

    #[pymodule_export]
    use super::worlds::{
        bake_world, edit_world, export_world, finish_world, plan_world, read_world_plan,
        world_status,
    };

    #[pymodule_export]
    use super::bricks::Bricks;
    #[pymodule_export]
    use super::scene::{Scene, SceneNode};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
