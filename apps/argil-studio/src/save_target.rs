//! Where files go: to their places, or in a browser to its downloads.

use anyhow::Context;
use std::io::Write;
use std::path::Path;

/// Write a file.
///
/// # Errors
/// If it cannot be written; what was there stays.
pub(crate) fn write_output(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> anyhow::Result<()> {
    #[cfg(target_arch = "wasm32")]
    let written = {
        let mut bytes = Vec::new();
        write(&mut bytes).and_then(|()| crate::browser::download(path, &bytes))
    };
    #[cfg(not(target_arch = "wasm32"))]
    let written = argil::scene::write_atomically(path, |out| write(out));
    written.with_context(|| path.display().to_string())
}

/// Several files in a folder, or in a browser in an archive.
pub(crate) struct Folder {
    path: std::path::PathBuf,
    /// What was not there before.
    #[cfg(not(target_arch = "wasm32"))]
    made: Vec<std::path::PathBuf>,
    #[cfg(target_arch = "wasm32")]
    archive: zip::ZipWriter<std::io::Cursor<Vec<u8>>>,
}

impl Folder {
    /// Make one.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(crate) fn new(path: &Path) -> anyhow::Result<Self> {
        #[cfg(not(target_arch = "wasm32"))]
        std::fs::create_dir_all(path).with_context(|| path.display().to_string())?;
        Ok(Self {
            path: path.into(),
            #[cfg(not(target_arch = "wasm32"))]
            made: Vec::new(),
            #[cfg(target_arch = "wasm32")]
            archive: zip::ZipWriter::new(Default::default()),
        })
    }

    /// Write a file into it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn put(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> anyhow::Result<()> {
        #[cfg(target_arch = "wasm32")]
        {
            // Pictures are packed already.
            let stored = zip::write::SimpleFileOptions::default()
                .compression_method(zip::CompressionMethod::Stored);
            self.archive.start_file(name, stored)?;
            write(&mut self.archive)?;
            Ok(())
        }
        #[cfg(not(target_arch = "wasm32"))]
        {
            let path = self.path.join(name);
            let is_new = !path.exists();
            write_output(&path, write)?;
            self.made.extend(is_new.then_some(path));
            Ok(())
        }
    }

    /// It is not wanted any more: take out what was written. What was written over stays as it is now.
    pub(crate) fn discard(self) {
        #[cfg(not(target_arch = "wasm32"))]
        for path in self.made {
            // Who has taken it out already has done the same.
            let _ = std::fs::remove_file(path);
        }
    }

    /// Everything is in it.
    ///
    /// # Errors
    /// If it cannot be handed over.
    pub(crate) fn close(self) -> anyhow::Result<()> {
        #[cfg(target_arch = "wasm32")]
        {
            let bytes = self.archive.finish()?.into_inner();
            crate::browser::download(&self.path, &bytes)
                .with_context(|| self.path.display().to_string())?;
        }
        Ok(())
    }
}
