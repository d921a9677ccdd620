//! All tests of this crate, as one program: its parts are linked once.

mod gltf_files;
mod hostile_files;
mod marching;
mod mesh_offsets;
mod mesh_sdf;
mod text_files;
mod three_mf;
