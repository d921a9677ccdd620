//! Keeps compiled pipelines in a file from process to process, where the device can.

use std::path::{Path, PathBuf};

/// The pipelines of a device, and the file that they come from.
#[derive(Debug)]
pub(crate) struct PipelineCache {
    cache: wgpu::PipelineCache,
    path: PathBuf,
    /// The checksum of what the file holds.
    saved: Option<u32>,
}

/// Bytes of a checksum in front of what the device has returned.
const HEAD: usize = 4;

/// Returns what a device has stored in a file, or `None` if the file is damaged or missing.
fn read(path: &Path) -> Option<(u32, Vec<u8>)> {
    let mut bytes = std::fs::read(path).ok()?;
    let data = bytes.split_off(HEAD.min(bytes.len()));
    let checksum = u32::from_le_bytes(bytes.try_into().ok()?);
    (crc32fast::hash(&data) == checksum).then_some((checksum, data))
}

/// Replaces a file as a whole. Another process can read it at any time.
fn write(path: &Path, checksum: u32, data: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(path);
    std::fs::create_dir_all(folder)?;
    let temporary = path.with_extension(format!("{}.new", std::process::id()));
    let written = std::fs::write(&temporary, [&checksum.to_le_bytes(), data].concat());
    let replaced = written.and_then(|()| std::fs::rename(&temporary, path));
    if replaced.is_err() {
        // What is left is removed if it can be.
        let _ = std::fs::remove_file(&temporary);
    }
    replaced
}

impl PipelineCache {
    /// Opens the cache of a device in a folder. Returns `None` where the device cannot return pipelines. A damaged file is replaced.
    pub(crate) fn open(
        device: &wgpu::Device,
        adapter: &wgpu::AdapterInfo,
        folder: &Path,
    ) -> Option<Self> {
        let has_cache = device.features().contains(wgpu::Features::PIPELINE_CACHE);
        let key = wgpu::util::pipeline_cache_key(adapter).filter(|_| has_cache)?;
        let path = folder.join(key);
        let stored = read(&path);
        let descriptor = wgpu::PipelineCacheDescriptor {
            label: Some("argil"),
            data: stored.as_ref().map(|(_, data)| &data[..]),
            fallback: true,
        };
        // SAFETY: the data comes from a pipeline cache of a device with this key, and its checksum holds. The driver
        // checks that it belongs to its version.
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        Some(Self {
            cache,
            path,
            saved: stored.map(|(checksum, _)| checksum),
        })
    }

    /// Returns the cache for the descriptor of a pipeline.
    pub(crate) fn get(&self) -> &wgpu::PipelineCache {
        &self.cache
    }

    /// Writes the file, if it holds something else.
    pub(crate) fn save(&self) {
        if let Some(data) = self.cache.get_data() {
            let checksum = crc32fast::hash(&data);
            if self.saved != Some(checksum) {
                // The next process compiles again what cannot be written.
                let _ = write(&self.path, checksum, &data);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Gpu;

    #[test]
    fn damaged_files_are_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("deep").join("pipelines");
        assert!(read(&path).is_none());
        let data = [1, 2, 3, 4, 5, 6, 7];
        write(&path, crc32fast::hash(&data), &data).expect("a file");
        assert_eq!(read(&path).map(|(_, data)| data), Some(data.to_vec()));
        let stored = std::fs::read(&path).expect("a file");
        for damaged in [
            &stored[..5],
            &stored[..2],
            &[],
            &[&[0], &stored[1..]].concat(),
        ] {
            std::fs::write(&path, damaged).expect("a file");
            assert!(read(&path).is_none(), "{damaged:?}");
        }
    }

    /// A process leaves a file, and the next one opens with it.
    #[test]
    fn pipelines_stay_in_a_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let open = || {
            let gpu = pollster::block_on(Gpu::open()).expect("a device");
            gpu.with_pipeline_cache(folder.path())
        };
        let gpu = open();
        let can_keep = gpu.pipeline_cache().is_some();
        let source = "@compute @workgroup_size(1) fn a() {}";
        let module = crate::pass_module::PassModule::new("one", &[source], vec![], &[], &["a"]);
        let passes = crate::pass_module::Passes::new(&gpu, module).expect("a layout");
        passes.get(&gpu, "a").expect("a pass");
        drop(gpu);
        let files = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(files, usize::from(can_keep));
        let saved = |gpu: &Gpu| gpu.pipeline_cache.as_ref().and_then(|cache| cache.saved);
        assert_eq!(saved(&open()).is_some(), can_keep);
    }
}
