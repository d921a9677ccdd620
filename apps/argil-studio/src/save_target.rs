//! Targets of written files: paths, or downloads in a browser.

use anyhow::Context;
use std::io::Write;
use std::path::Path;

/// Writes a file.
///
/// # Errors
/// If the file cannot be written; it then keeps its contents.
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

/// Several files in a folder, or in an archive in a browser.
pub(crate) struct Folder {
    path: std::path::PathBuf,
    /// Files that did not exist before.
    #[cfg(not(target_arch = "wasm32"))]
    made: Vec<std::path::PathBuf>,
    #[cfg(target_arch = "wasm32")]
    archive: zip::ZipWriter<std::io::Cursor<Vec<u8>>>,
}

impl Folder {
    /// Creates a folder.
    ///
    /// # Errors
    /// If it cannot be created.
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

    /// Writes a file into the folder.
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
            // Images are already compressed.
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

    /// Removes the files that were created. Files that were replaced stay as they are.
    pub(crate) fn discard(self) {
        #[cfg(not(target_arch = "wasm32"))]
        for path in self.made {
            // It may have been removed already.
            let _ = std::fs::remove_file(path);
        }
    }

    /// Finishes the folder.
    ///
    /// # Errors
    /// If it cannot be written.
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
