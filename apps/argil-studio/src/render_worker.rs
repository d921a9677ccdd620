//! Renders the scene: a copy that applies the document's actions, and a world for each visible pipeline.

use crate::level_refinement::refine;
use crate::pipeline::Pipeline;
pub(crate) use crate::render_request::{
    Pixels, RenderAnswer, RenderRequest, StoredPages, WorkerImage,
};
use crate::texture_pool::TexturePool;
#[cfg(not(target_arch = "wasm32"))]
use crate::traced_still::TracedStill;
use anyhow::Context;
use argil::render::{RenderMode, RenderSettings};
use argil::scene::{Action, Scene};
use argil::volume::Levels;
use argil::{Engine, RenderReport, RenderedImage, World};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use web_time::Instant;

/// Durations of baking bricks of levels, after an image during movement and around a still one.
const FILL_MS: f64 = 15.0;
const REFINE_MS: f64 = 120.0;

/// A still image is final if it lacks at most one brick for this many rays: other samples would need others.
const FEW: u64 = 2000;

struct KeptWorld {
    /// Its pages come from a store. It is built when the scene is loaded, and stays.
    is_stored: bool,
    pipeline: Pipeline,
    resolution: u32,
    world: World,
    /// Version of the worker's copy.
    version: u64,
    /// Duration of the last image in milliseconds.
    frame_ms: f64,
    /// The request of a still image for which an image of one sample lacked few bricks of levels.
    complete_for: Option<RenderRequest>,
}

/// The render worker.
pub(crate) struct RenderWorker {
    engine: Engine,
    scene: Scene,
    /// Version of the copy.
    version: u64,
    /// Why the copy differs from the document, if it does.
    fault: Option<String>,
    kept: Vec<KeptWorld>,
    /// Textures for images that stay on the GPU, if it is the window's.
    textures: Option<TexturePool>,
    /// The least duration of baking bricks of levels around a still image, in milliseconds.
    refine_ms: f64,
    /// Whether a world is being built.
    is_building: Arc<AtomicBool>,
    /// The still that is being refined.
    #[cfg(not(target_arch = "wasm32"))]
    still: Option<TracedStill>,
}

/// Maximum number of worlds kept: two to compare, and one to return to.
const MAX_KEPT: usize = 3;

impl RenderWorker {
    /// Creates a worker without a scene. Its images go into textures, if there are any.
    pub(crate) fn new(engine: Engine, textures: Option<TexturePool>) -> Self {
        Self {
            engine,
            scene: Scene::new(),
            version: 0,
            fault: None,
            kept: Vec::new(),
            textures,
            refine_ms: REFINE_MS,
            is_building: Arc::default(),
            #[cfg(not(target_arch = "wasm32"))]
            still: None,
        }
    }

    /// Returns a flag that other threads read: whether a world is being built.
    pub(crate) fn is_building(&self) -> Arc<AtomicBool> {
        self.is_building.clone()
    }

    /// Loads another scene, or one whose world is in a store.
    pub(crate) async fn load(&mut self, scene: Scene, version: u64, pages: Option<StoredPages>) {
        (self.scene, self.version) = (scene, version);
        self.fault = None;
        self.kept.clear();
        #[cfg(not(target_arch = "wasm32"))]
        {
            self.still = None;
        }
        if let Some(pages) = pages {
            self.is_building.store(true, Ordering::Relaxed);
            let built = self.build_stored(&pages).await;
            self.is_building.store(false, Ordering::Relaxed);
            match built {
                Ok(world) => self.kept.push(KeptWorld {
                    is_stored: true,
                    pipeline: Pipeline::default(),
                    resolution: 0,
                    world,
                    version,
                    frame_ms: 0.0,
                    complete_for: None,
                }),
                Err(error) => self.fault = Some(format!("{error:#}")),
            }
        }
    }

    async fn build_stored(&self, pages: &StoredPages) -> anyhow::Result<World> {
        let built = self.engine.build(&self.scene)?;
        let mut world = built.with_representation_async(pages.options).await?;
        world.set_tile_source(pages.source.clone(), false);
        Ok(world)
    }

    /// Applies actions of the document. If one fails, the worker reports the reason instead of images until a scene
    /// is loaded.
    pub(crate) fn follow(&mut self, actions: &[Action]) {
        for action in actions {
            if let Err(error) = self.scene.perform(action) {
                let fault = format!(
                    "the view is out of sync with the document: {error}; save the scene, and open it again"
                );
                self.fault.get_or_insert(fault);
            }
            self.version += 1;
        }
    }

    /// Sets the time of keyframes.
    pub(crate) fn set_time(&mut self, time: f32) {
        self.scene.set_time(time);
        self.version += 1;
    }

    /// Renders a request.
    pub(crate) async fn draw(&mut self, request: RenderRequest) -> RenderAnswer {
        let start = Instant::now();
        if let Some(fault) = &self.fault {
            return RenderAnswer {
                request,
                pictures: Err(fault.clone()),
                duration_ms: 0.0,
            };
        }
        let mut pictures = Ok(Vec::new());
        #[cfg(not(target_arch = "wasm32"))]
        if let (true, true, [pipeline]) = (
            request.traces_paths,
            request.is_still,
            &request.pipelines[..],
        ) {
            let traced = TracedStill::refined(&mut self.still, &self.scene, self.version, &request);
            pictures = traced
                .map(|still| vec![still.image(*pipeline)])
                .map_err(|error| format!("{error:#}"));
            return RenderAnswer {
                request,
                pictures,
                duration_ms: start.elapsed().as_secs_f64() * 1e3,
            };
        }
        for &pipeline in &request.pipelines {
            match (self.picture(pipeline, &request).await, &mut pictures) {
                (Ok(picture), Ok(all)) => all.push(picture),
                (Err(error), _) => {
                    pictures = Err(format!("{error:#}"));
                    break;
                }
                _ => {}
            }
        }
        RenderAnswer {
            request,
            pictures,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
        }
    }

    async fn picture(
        &mut self,
        pipeline: Pipeline,
        request: &RenderRequest,
    ) -> anyhow::Result<WorkerImage> {
        let edit_ms = self.bring_up(pipeline, request.resolution).await?;
        let kept = self.kept.last_mut().context("the worker has a world")?;
        let world = &mut kept.world;
        let mut settings = settings(world, request);
        // As long as a slow image takes, so that there are few of them before the final one.
        let refine_ms = self.refine_ms.max(kept.frame_ms);
        // Light reads bricks that rays do not meet. All samples are drawn once these are there too.
        let is_known = !request.is_still || kept.complete_for.as_ref() == Some(request);
        let is_refined = is_known || refine(world, request, &settings, refine_ms).await?;
        let is_complete = is_known || is_refined && world.levels().is_none();
        if !is_complete {
            settings.samples = 1;
        }
        let (pixels, report) = match &mut self.textures {
            Some(pool) => {
                let textures = pool.take(settings.size)?;
                let drawn = world.render_into_async(&request.camera, &settings, &textures);
                let report = drawn.await?;
                (Pixels::Gpu(textures), report)
            }
            None => {
                let drawn = world.render_with_distances_async(&request.camera, &settings);
                let (
                    RenderedImage {
                        rgb,
                        statistics,
                        duration_ms,
                        ..
                    },
                    lengths,
                ) = drawn.await?;
                let report = RenderReport {
                    statistics,
                    duration_ms,
                };
                (Pixels::Cpu { rgb, lengths }, report)
            }
        };
        kept.frame_ms = report.duration_ms;
        let missing = world.levels().map_or(0, Levels::request_count) as u64;
        let rays =
            request.size.map(u64::from).iter().product::<u64>() * u64::from(settings.samples);
        let fill_ms = if request.is_still { refine_ms } else { FILL_MS };
        let filled = world.fill_pages(fill_ms)?;
        // What the store lacks does not come.
        let missing = missing.saturating_sub(filled.missing);
        // A brick of a coarse level covers much of the image.
        let lacks_few = is_refined && filled.pending == 0 && missing <= rays / FEW;
        let is_exhausted = is_refined && filled.answered == 0 && filled.pending == 0;
        if lacks_few || is_exhausted {
            kept.complete_for = Some(RenderRequest {
                is_still: true,
                ..request.clone()
            });
        }
        let missing = match is_complete && lacks_few {
            true => 0,
            false => missing.max(1),
        };
        let info = world.volume_info_async().await?;
        let bricks = info.and_then(|info| {
            let tree = info.octree.map(|tree| tree.bricks);
            tree.or(info.bricks.map(|sparse| sparse.bricks))
        });
        Ok(WorkerImage {
            pipeline,
            size: settings.size,
            pixels,
            frame_ms: report.duration_ms,
            edit_ms,
            steps: report.statistics.map(|counted| counted.steps),
            memory_bytes: world.memory_bytes(),
            bricks,
            missing,
            lost: filled.missing,
            paths: None,
            triangles: world.mesh_counts().map(|counts| counts.triangles),
        })
    }

    /// Updates a pipeline's world to the current scene and moves it to the end of the list. Returns the duration of
    /// edits.
    async fn bring_up(
        &mut self,
        pipeline: Pipeline,
        resolution: u32,
    ) -> anyhow::Result<Option<f64>> {
        let is_it =
            |k: &KeptWorld| k.pipeline == pipeline && (k.is_stored || k.resolution == resolution);
        let Some(at) = self.kept.iter().position(is_it) else {
            self.kept.retain(|k| k.pipeline != pipeline);
            if self.kept.len() >= MAX_KEPT
                && let Some(oldest) = self.kept.iter().position(|k| !k.is_stored)
            {
                self.kept.remove(oldest);
            }
            self.is_building.store(true, Ordering::Relaxed);
            let world = self.build(pipeline, resolution).await;
            self.is_building.store(false, Ordering::Relaxed);
            let world = world?;
            self.kept.push(KeptWorld {
                is_stored: false,
                pipeline,
                resolution,
                world,
                version: self.version,
                frame_ms: 0.0,
                complete_for: None,
            });
            return Ok(None);
        };
        let mut kept = self.kept.remove(at);
        let start = Instant::now();
        let is_behind = kept.version != self.version;
        if is_behind {
            // A world that fails here is rebuilt at the next request.
            kept.world.apply_async(&self.scene).await?;
            kept.world.flush_async().await?;
            kept.version = self.version;
            kept.complete_for = None;
        }
        self.kept.push(kept);
        Ok(is_behind.then(|| start.elapsed().as_secs_f64() * 1e3))
    }

    async fn build(&self, pipeline: Pipeline, resolution: u32) -> anyhow::Result<World> {
        let built = self.engine.build(&self.scene)?;
        Ok(built
            .with_representation_async(pipeline.via(resolution))
            .await?)
    }
}

fn settings(world: &World, request: &RenderRequest) -> RenderSettings {
    let supports = request.pipelines.iter().all(|p| p.supports(request.show));
    let show = if supports {
        request.show
    } else {
        RenderMode::Normal
    };
    let usual = world.render_settings(request.size, show);
    let is_heat = show == RenderMode::Heat;
    RenderSettings {
        samples: if request.is_still { usual.samples } else { 1 },
        max_steps: usual.max_steps.min(if is_heat { 256 } else { u32::MAX }),
        heat_steps: Some(256),
        statistics: request.counts_rays,
        ..usual
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample_scenes::first;
    use crate::viewport_camera::ViewportCamera;
    use argil::scene::{Brush, Edit, Shape};

    fn request(pipeline: Pipeline) -> RenderRequest {
        RenderRequest {
            pipelines: vec![pipeline],
            show: RenderMode::Normal,
            resolution: 48,
            camera: ViewportCamera::default().camera(),
            size: [80, 60],
            is_still: true,
            traces_paths: false,
            counts_rays: true,
            version: 0,
        }
    }

    fn rgb_of(image: &WorkerImage) -> Vec<u8> {
        match &image.pixels {
            Pixels::Cpu { rgb, .. } => rgb.clone(),
            Pixels::Gpu(_) => Vec::new(),
        }
    }

    fn picture(painter: &mut RenderWorker, pipeline: Pipeline) -> Vec<u8> {
        let answer = pollster::block_on(painter.draw(request(pipeline)));
        rgb_of(&answer.pictures.expect("a picture").remove(0))
    }

    #[test]
    fn a_copy_that_parts_from_the_document_is_loud() {
        let mut painter = RenderWorker::new(Engine::cpu(), None);
        pollster::block_on(painter.load(first(), 0, None));
        let node = first()
            .push(Brush::new(Shape::sphere(0.1)))
            .expect("a brush")
            .node;
        painter.follow(&[Action::Edit(Edit::Remove { node })]);
        let answer = pollster::block_on(painter.draw(request(Pipeline::field())));
        let fault = answer.pictures.expect_err("a fault");
        assert!(fault.contains("is not in the scene"), "{fault}");
        pollster::block_on(painter.load(first(), 0, None));
        picture(&mut painter, Pipeline::field());
    }

    /// However little time an image has, the last one is as sharp as if it had all.
    #[test]
    fn an_image_is_final_when_nothing_is_missing() {
        let mut painter = RenderWorker::new(Engine::cpu(), None);
        painter.refine_ms = 0.1;
        pollster::block_on(painter.load(first(), 0, None));
        let look = request(Pipeline::default());
        let last = (0..10_000).find_map(|_| {
            let answer = pollster::block_on(painter.draw(look.clone()));
            let image = answer.pictures.expect("a picture").remove(0);
            (image.missing == 0).then(|| rgb_of(&image))
        });
        let scene = first();
        let whole = Engine::cpu().build(&scene).expect("a world");
        let mut whole = whole
            .with_representation(Pipeline::default().via(look.resolution))
            .expect("levels");
        let settings = settings(&whole, &look);
        whole.refine(&look.camera, &settings).expect("levels");
        let image = whole.render(&look.camera, &settings).expect("a picture");
        let last = last.expect("an end");
        let apart = last.iter().zip(&image.rgb).filter(|(a, b)| a != b).count();
        // The last few bricks of other samples are missing.
        assert!(100 * apart < last.len(), "{apart} of {}", last.len());
    }

    #[test]
    fn what_is_drawn_follows_the_document() {
        let entry = Brush::new(Shape::sphere(0.3)).at([0.3, 0.6, 0.5]);
        let edit = Action::Edit(Edit::Insert {
            parent: Scene::ROOT,
            index: first().node(Scene::ROOT).children().len(),
            desc: entry.into(),
        });
        let mut edited = first();
        edited.perform(&edit).expect("an edit");
        for pipeline in Pipeline::all() {
            let mut painter = RenderWorker::new(Engine::cpu(), None);
            pollster::block_on(painter.load(first(), 0, None));
            let before = picture(&mut painter, pipeline);
            painter.follow(std::slice::from_ref(&edit));
            let after = picture(&mut painter, pipeline);
            let apart = |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a != b).count();
            let shown = apart(&before, &after);
            assert!(shown > 100, "{pipeline:?}: {shown}");
            let mut fresh = RenderWorker::new(Engine::cpu(), None);
            pollster::block_on(fresh.load(edited.clone(), 0, None));
            let off = apart(&picture(&mut fresh, pipeline), &after);
            // Its voxel grid may lie otherwise.
            assert!(8 * off < shown, "{pipeline:?}: {off} of {shown}");
            painter.follow(&[Action::Undo]);
            let off = apart(&picture(&mut painter, pipeline), &before);
            assert!(
                20 * off < shown,
                "{pipeline:?}: {off} of {shown} after undo"
            );
        }
    }
}
