use std::path::PathBuf;

/// Returns the folder of what can be made again, such as samples of meshes and compiled pipelines, or `None` where there is none.
pub fn cache_folder() -> Option<PathBuf> {
    #[cfg(all(
        not(target_arch = "wasm32"),
        any(feature = "gpu", feature = "mesh-files")
    ))]
    return Some(dirs::cache_dir()?.join("argil"));
    #[cfg(not(all(
        not(target_arch = "wasm32"),
        any(feature = "gpu", feature = "mesh-files")
    )))]
    None
}
