//! Long work beside the window: with its progress, and an end before its time.

use crate::eye::Eye;
use crate::files::Ask;
use anyhow::Context;
use argil::{
    BricksOptions, Engine, Format, MeshOptions, Orbit, Scene, Settings, Show, Via, WriteOptions,
    load_meshes, save_mesh,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, channel};

/// What a job came to.
pub enum Done {
    /// Something was written.
    Written(String),
    /// A mesh was sampled.
    Imported(Box<Scene>),
    /// It was told to end.
    Cancelled,
}

/// How far it is, seen from both sides.
#[derive(Default)]
struct Progress {
    thousandths: AtomicU32,
    is_cancelled: AtomicBool,
}

impl Progress {
    fn set(&self, part: f32) -> bool {
        let part = (1000.0 * part) as u32;
        self.thousandths.store(part, Ordering::Relaxed);
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

/// One that runs.
pub struct Job {
    /// In words.
    pub name: String,
    progress: Arc<Progress>,
    result: Receiver<anyhow::Result<Done>>,
}

impl Job {
    /// From 0 to 1; 0 while it is not known.
    pub fn part(&self) -> f32 {
        self.progress.thousandths.load(Ordering::Relaxed) as f32 / 1000.0
    }

    /// Let it end soon, with nothing done.
    pub fn cancel(&self) {
        self.progress.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether it was told to end.
    pub fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled.load(Ordering::Relaxed)
    }
}

/// All that run.
#[derive(Default)]
pub struct Jobs(Vec<Job>);

/// Pictures of a turn.
const FRAMES: u32 = 72;
const PICTURE: [u32; 2] = [1920, 1080];

impl Jobs {
    /// Those that run.
    pub fn all(&self) -> &[Job] {
        &self.0
    }

    /// What is done now.
    pub fn finished(&mut self) -> Vec<anyhow::Result<Done>> {
        let mut done = Vec::new();
        self.0.retain(|job| match job.result.try_recv() {
            Ok(_) if job.is_cancelled() => {
                done.push(Ok(Done::Cancelled));
                false
            }
            Ok(result) => {
                done.push(result.with_context(|| job.name.clone()));
                false
            }
            Err(std::sync::mpsc::TryRecvError::Empty) => true,
            Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                done.push(Err(anyhow::anyhow!("{}: a fault in Argil", job.name)));
                false
            }
        });
        done
    }

    fn start(
        &mut self,
        name: String,
        work: impl FnOnce(&Progress) -> anyhow::Result<Done> + Send + 'static,
    ) {
        let progress = Arc::new(Progress::default());
        let (sender, result) = channel();
        let own = progress.clone();
        let run = move || {
            // Who asked may be gone.
            let _ = sender.send(work(&own));
        };
        #[cfg(not(target_arch = "wasm32"))]
        std::thread::spawn(run);
        #[cfg(target_arch = "wasm32")]
        run();
        self.0.push(Job {
            name,
            progress,
            result,
        });
    }

    /// Sample the meshes of a scene.
    pub fn import(&mut self, path: &Path, mut scene: Scene, folder: PathBuf) {
        let name = format!("Importing {}", path.display());
        self.start(name, move |_| {
            load_meshes(&mut scene, &folder, true)?;
            Ok(Done::Imported(Box::new(scene)))
        });
    }

    /// Write what was asked for.
    pub fn export(&mut self, what: Ask, scene: Scene, path: PathBuf, how: (u32, Eye)) {
        let name = format!("Exporting {}", path.display());
        self.start(name, move |progress| {
            export(what, &scene, &path, how, progress)
        });
    }
}

fn export(
    what: Ask,
    scene: &Scene,
    path: &Path,
    (resolution, eye): (u32, Eye),
    progress: &Progress,
) -> anyhow::Result<Done> {
    let world = Engine::cpu().build(scene)?;
    let mut written = path.display().to_string();
    match what {
        Ask::Mesh => {
            let meshed = world.mesh(&MeshOptions {
                resolution,
                ..MeshOptions::default()
            })?;
            if progress.set(0.5) {
                return Ok(Done::Cancelled);
            }
            let counts = meshed.report.triangles;
            let format = Format::of(path).context("the name ends in .glb, .obj, .ply or .stl")?;
            save_mesh(&meshed.mesh, format, &WriteOptions::default(), path)?;
            written += &format!(", {counts} triangles");
        }
        Ask::Volume => {
            let options = BricksOptions {
                resolution,
                ..BricksOptions::default()
            };
            let world = world.via(scene, Via::Bricks(options))?;
            if progress.set(0.5) {
                return Ok(Done::Cancelled);
            }
            world.save(scene, path)?;
        }
        Ask::Turntable => {
            std::fs::create_dir_all(path).with_context(|| path.display().to_string())?;
            let settings = settings(&world);
            for (i, camera) in Orbit::around(eye.camera(), FRAMES).enumerate() {
                if progress.set(i as f32 / FRAMES as f32) {
                    return Ok(Done::Cancelled);
                }
                let drawn = world.draw(&camera, &settings)?;
                drawn.save(path.join(format!("frame-{i:03}.png")))?;
            }
            written += &format!(", {FRAMES} pictures");
        }
        _ => {
            let drawn = world.draw(&eye.camera(), &settings(&world))?;
            if progress.set(0.9) {
                return Ok(Done::Cancelled);
            }
            drawn.save(path)?;
        }
    }
    Ok(Done::Written(format!("{written}: written")))
}

fn settings(world: &argil::World) -> Settings {
    world.settings(PICTURE, Show::Shaded)
}
