//! All tests of this crate, as one program: its parts are linked once.

mod convergence;
mod edit_session;
mod examples;
mod facade;
mod framing;
mod futures;
mod gpu_more_light;
mod gpu_stills;
mod grow;
#[cfg(feature = "gpu")]
mod host;
#[cfg(feature = "gpu")]
mod host_common;
#[cfg(feature = "gpu")]
mod host_edits;
#[cfg(feature = "gpu")]
mod host_motion;
#[cfg(feature = "gpu")]
mod host_views;
#[cfg(feature = "gpu")]
mod image_textures;
mod iso_levels;
mod lamps;
mod levels;
mod levels_common;
mod levels_walk;
mod light;
mod light_of_images;
mod lights;
mod live_image;
mod openvdb;
mod query;
mod residue;
#[cfg(feature = "gpu")]
mod shader_volume;
mod shadows;
mod still;
mod volume_distances;
mod volume_files;
mod zarr;
