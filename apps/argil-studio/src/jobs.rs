//! Background jobs, with progress and cancellation.

use crate::files::FileRequest;
use crate::mesh_files::{Load, Named, scene_of};
use crate::ready::ready;
use crate::save_target;
use crate::viewport_camera::ViewportCamera;
use anyhow::Context;
use argil::math::Control;
use argil::mesh::{MeshFormat, MeshWriteOptions, write as write_mesh};
use argil::render::{RenderMode, RenderSettings};
use argil::scene::{NodeId, Scene};
use argil::{BricksOptions, Engine, ExportFormat, LoadedMesh, MeshOptions, Orbit, write_png};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, channel};

/// The result of a job.
pub(crate) enum JobResult {
    /// A file was written.
    Written(String),
    /// Meshes were sampled.
    Loaded(Loaded),
    /// The job was canceled.
    Cancelled,
}

/// The purpose of sampled meshes.
pub(crate) enum JobTarget {
    /// For brushes that name them.
    Known,
    /// To replace the shape of a brush.
    Brush(NodeId),
    /// To be inserted, under a name.
    New(String),
}

/// Sampled meshes.
pub(crate) struct Loaded {
    /// The meshes that could be sampled.
    pub meshes: Vec<LoadedMesh>,
    /// Errors of the others.
    pub faults: Vec<anyhow::Error>,
    /// The document that requested them.
    pub document: u64,
    /// Their purpose.
    pub aim: JobTarget,
}

/// The progress of a job, shared by both threads.
struct JobProgress {
    thousandths: AtomicU32,
    control: Control,
}

impl JobProgress {
    fn new() -> Self {
        Self {
            thousandths: AtomicU32::new(0),
            control: Control::new(),
        }
    }

    fn set(&self, part: f32) -> bool {
        let part = (1000.0 * part) as u32;
        self.thousandths.store(part, Ordering::Relaxed);
        self.is_cancelled()
    }

    fn is_cancelled(&self) -> bool {
        self.control.is_cancelled()
    }

    /// Writes a file, unless the job is canceled first.
    fn put(
        &self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> anyhow::Result<()> {
        save_target::write_output(path, |out| {
            write(out)?;
            if self.is_cancelled() {
                return Err(std::io::ErrorKind::Interrupted.into());
            }
            Ok(())
        })
    }
}

/// A running job.
pub(crate) struct BackgroundJob {
    /// The label.
    pub name: String,
    /// Whether it reads meshes, and the brush it does so for.
    reads: Option<Option<NodeId>>,
    progress: Arc<JobProgress>,
    result: Receiver<anyhow::Result<JobResult>>,
}

impl BackgroundJob {
    /// Returns the progress from 0 to 1; 0 while it is unknown.
    pub(crate) fn part(&self) -> f32 {
        let counted = self.progress.thousandths.load(Ordering::Relaxed) as f32 / 1000.0;
        let stage = self.progress.control.progress();
        let of_stage = stage.filter(|stage| stage.total > 0);
        counted.max(of_stage.map_or(0.0, |stage| stage.done as f32 / stage.total as f32))
    }

    /// Cancels the job. Its current step still runs to the end, in the background.
    pub(crate) fn cancel(&self) {
        self.progress.control.cancel();
    }
}

/// The running jobs.
#[derive(Default)]
pub(crate) struct Jobs(Vec<BackgroundJob>);

/// Images of a turntable.
const FRAMES: u32 = 72;
const PICTURE: [u32; 2] = [1920, 1080];

impl Jobs {
    /// Returns the running jobs.
    pub(crate) fn all(&self) -> &[BackgroundJob] {
        &self.0
    }

    /// Returns true if a job reads meshes.
    pub(crate) fn are_meshes_read(&self) -> bool {
        self.0.iter().any(|job| job.reads.is_some())
    }

    /// Returns the results of the jobs that have finished.
    pub(crate) fn finished(&mut self) -> Vec<anyhow::Result<JobResult>> {
        let mut done = Vec::new();
        self.0.retain(|job| match job.result.try_recv() {
            _ if job.progress.is_cancelled() => {
                done.push(Ok(JobResult::Cancelled));
                false
            }
            Ok(result) => {
                done.push(result.with_context(|| job.name.clone()));
                false
            }
            Err(std::sync::mpsc::TryRecvError::Empty) => true,
            Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                done.push(Err(anyhow::anyhow!("{}: internal error", job.name)));
                false
            }
        });
        done
    }

    fn start(
        &mut self,
        name: String,
        reads: Option<Option<NodeId>>,
        work: impl AsyncFnOnce(&JobProgress) -> anyhow::Result<JobResult> + Send + 'static,
    ) {
        let progress = Arc::new(JobProgress::new());
        let (sender, result) = channel();
        let progress_of_work = progress.clone();
        #[cfg(not(target_arch = "wasm32"))]
        std::thread::spawn(move || {
            // The receiver may be gone.
            let _ = sender.send(pollster::block_on(work(&progress_of_work)));
        });
        #[cfg(target_arch = "wasm32")]
        wasm_bindgen_futures::spawn_local(async move {
            breathe().await;
            let _ = sender.send(work(&progress_of_work).await);
        });
        self.0.push(BackgroundJob {
            name,
            reads,
            progress,
            result,
        });
    }

    /// Samples meshes for a document, one after another.
    pub(crate) fn load(
        &mut self,
        name: String,
        wanted: Vec<Named>,
        mut load: Load,
        (document, aim): (u64, JobTarget),
    ) {
        let brush = match aim {
            JobTarget::Brush(node) => Some(node),
            _ => None,
        };
        if brush.is_some() {
            // An earlier request for the same brush is obsolete.
            self.0.retain(|job| job.reads != Some(brush));
        }
        self.start(name, Some(brush), async move |progress| {
            let (mut meshes, mut faults) = (Vec::new(), Vec::new());
            for (i, named) in wanted.iter().enumerate() {
                breathe().await;
                if progress.set(i as f32 / wanted.len() as f32) {
                    return Ok(JobResult::Cancelled);
                }
                match load(&mut scene_of(named)?) {
                    Ok(loaded) if loaded.is_empty() => faults.push(not_given(named)),
                    Ok(loaded) => meshes.extend(loaded),
                    Err(error) => faults.push(error.into()),
                }
            }
            Ok(JobResult::Loaded(Loaded {
                meshes,
                faults,
                document,
                aim,
            }))
        });
    }

    /// Starts an export.
    pub(crate) fn export(
        &mut self,
        what: FileRequest,
        scene: Scene,
        path: PathBuf,
        how: ExportOptions,
    ) {
        let name = format!("Exporting {}", path.display());
        self.start(name, None, async move |progress| {
            let done = export(what, &scene, &path, how, progress).await;
            match done {
                Err(_) if progress.is_cancelled() => Ok(JobResult::Cancelled),
                done => done,
            }
        });
    }
}

/// Options of an export.
pub(crate) struct ExportOptions {
    /// The engine that renders images.
    pub engine: Engine,
    /// Voxels along the longest side.
    pub resolution: u32,
    /// The camera.
    pub eye: ViewportCamera,
}

/// Yields to other tasks. A browser has one thread for everything.
async fn breathe() {
    #[cfg(target_arch = "wasm32")]
    crate::browser::breathe().await;
}

async fn export(
    what: FileRequest,
    scene: &Scene,
    path: &Path,
    how: ExportOptions,
    progress: &JobProgress,
) -> anyhow::Result<JobResult> {
    let mut written = path.display().to_string();
    match what {
        FileRequest::Mesh => {
            let engine = Engine::cpu().with_control(&progress.control);
            let world = engine.build(scene)?.field();
            let options = MeshOptions {
                resolution: how.resolution,
                ..MeshOptions::default()
            };
            let meshed = world.mesh_async(&options).await?;
            breathe().await;
            if progress.set(0.5) {
                return Ok(JobResult::Cancelled);
            }
            let counts = meshed.report.triangles;
            let format = MeshFormat::from_path(path).with_context(|| {
                format!("the name must end in {}", MeshFormat::extensions("or"))
            })?;
            progress.put(path, |out| {
                write_mesh(&meshed.mesh, format, &MeshWriteOptions::default(), out)
            })?;
            written += &format!(", {counts} triangles");
        }
        FileRequest::Volume if ExportFormat::from_path(path).is_some() => {
            let voxels = export_volume(scene, path, how.resolution, progress).await?;
            written += &format!(", {voxels} voxels");
        }
        FileRequest::Volume => {
            let options = BricksOptions {
                resolution: how.resolution,
                ..BricksOptions::default()
            };
            let world = Engine::cpu()
                .build(scene)?
                .with_representation_async(options)
                .await?;
            breathe().await;
            if progress.set(0.5) {
                return Ok(JobResult::Cancelled);
            }
            progress.put(path, |out| ready(world.write_async(out)))?;
        }
        FileRequest::Turntable => {
            let world = how.engine.build(scene)?.field();
            let settings = settings(&world);
            let mut folder = save_target::Folder::new(path)?;
            for (i, camera) in Orbit::cameras(how.eye.camera(), FRAMES).enumerate() {
                breathe().await;
                if progress.set(i as f32 / FRAMES as f32) {
                    folder.discard();
                    return Ok(JobResult::Cancelled);
                }
                let drawn = world.render_async(&camera, &settings).await?;
                folder.put(&format!("frame-{i:03}.png"), |out| {
                    write_png(drawn.size, &drawn.rgb, out)
                })?;
            }
            folder.close()?;
            written += &format!(", {FRAMES} frames");
        }
        _ => {
            let world = how.engine.build(scene)?.field();
            let drawn = world
                .render_async(&how.eye.camera(), &settings(&world))
                .await?;
            if progress.set(0.9) {
                return Ok(JobResult::Cancelled);
            }
            progress.put(path, |out| write_png(drawn.size, &drawn.rgb, out))?;
        }
    }
    Ok(JobResult::Written(format!("Exported {written}")))
}

/// Writes a volume for other programs, and returns the number of its voxels.
async fn export_volume(
    scene: &Scene,
    path: &Path,
    resolution: u32,
    progress: &JobProgress,
) -> anyhow::Result<u64> {
    let format = ExportFormat::from_path(path).context("unknown volume format")?;
    let engine = Engine::cpu().with_control(&progress.control);
    let world = engine.build(scene)?.field();
    let options = argil::ExportOptions {
        resolution,
        ..argil::ExportOptions::default()
    };
    let mut bytes = Cursor::new(Vec::new());
    let report = world.export_to(&mut bytes, format, &options)?;
    breathe().await;
    progress.put(path, |out| out.write_all(bytes.get_ref()))?;
    Ok(report.voxels)
}

fn not_given((path, _): &Named) -> anyhow::Error {
    anyhow::anyhow!("the mesh {path} is missing: open its file too, or drop it on the page")
}

fn settings(world: &argil::World) -> RenderSettings {
    world.render_settings(PICTURE, RenderMode::Shaded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cancelled_writes_nothing_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.obj");
        let write = |text: &'static str| move |out: &mut dyn Write| out.write_all(text.as_bytes());
        let progress = JobProgress::new();
        progress.put(&path, write("before")).expect("a file");
        progress.control.cancel();
        assert!(progress.put(&path, write("after")).is_err());
        assert_eq!(std::fs::read_to_string(&path).expect("a file"), "before");
        let left = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(left, 1);
    }

    #[test]
    fn what_is_wanted_last_of_a_brush_is_what_comes() {
        let mut jobs = Jobs::default();
        let node = Scene::new()
            .push(argil::scene::Group::new())
            .expect("a node")
            .node;
        for resolution in [512, 32] {
            let load = Box::new(|_: &mut Scene| Ok(Vec::new()));
            let named = ("a.obj".to_owned(), resolution);
            jobs.load(
                format!("{resolution}"),
                vec![named],
                load,
                (0, JobTarget::Brush(node)),
            );
        }
        let names: Vec<&str> = jobs.all().iter().map(|job| job.name.as_str()).collect();
        assert_eq!(names, ["32"]);
        assert!(jobs.are_meshes_read());
    }

    #[test]
    fn what_is_cancelled_is_over_at_once() {
        let mut jobs = Jobs::default();
        let (hold, held) = channel::<()>();
        jobs.start("Waiting".into(), None, async move |_| {
            // Until the test has seen what it came for.
            let _ = held.recv();
            Ok(JobResult::Written("late".into()))
        });
        assert!(jobs.finished().is_empty());
        jobs.all()[0].cancel();
        assert!(matches!(jobs.finished()[..], [Ok(JobResult::Cancelled)]));
        assert!(jobs.all().is_empty());
        drop(hold);
    }
}
