//! A path-traced still that is refined while nothing moves, on the CPU.

use crate::pipeline::Pipeline;
use crate::render_worker::{Pixels, RenderRequest, WorkerImage};
use argil::render::{Development, RenderMode, Still, StillOptions, denoised, developed};
use argil::scene::Scene;
use argil::{Engine, World};
use web_time::Instant;

/// Paths of a pixel, after which a still is final.
const PATHS: u32 = 256;
/// Duration of refining before an image is shown.
const STEP_MS: f64 = 200.0;

/// A still, and what it is made of.
pub(crate) struct TracedStill {
    request: RenderRequest,
    /// Version of the scene.
    version: u64,
    world: World,
    still: Still,
    frame_ms: f64,
}

impl TracedStill {
    /// Adds paths to the still of a request, or begins it.
    pub(crate) fn refined<'a>(
        place: &'a mut Option<Self>,
        scene: &Scene,
        version: u64,
        request: &RenderRequest,
    ) -> anyhow::Result<&'a Self> {
        let before = place.take();
        let traced = match before {
            Some(traced) if traced.version == version && traced.request == *request => traced,
            before => {
                let known = before.filter(|traced| traced.version == version);
                let world = match known {
                    Some(traced) => traced.world,
                    None => Engine::cpu().build(scene)?.field(),
                };
                Self {
                    request: request.clone(),
                    version,
                    world,
                    still: Still::new(request.size),
                    frame_ms: 0.0,
                }
            }
        };
        let traced = place.insert(traced);
        traced.refine()?;
        Ok(traced)
    }

    fn refine(&mut self) -> anyhow::Result<()> {
        let settings = self
            .world
            .render_settings(self.request.size, RenderMode::Shaded);
        let options = StillOptions {
            samples: 1,
            ..StillOptions::default()
        };
        let start = Instant::now();
        let spent_ms = || start.elapsed().as_secs_f64() * 1e3;
        while self.still.samples() < PATHS {
            let camera = &self.request.camera;
            self.world
                .refine_still(&mut self.still, camera, &settings, &options)?;
            if spent_ms() > STEP_MS {
                break;
            }
        }
        self.frame_ms += spent_ms();
        Ok(())
    }

    /// Returns what is there, without noise.
    pub(crate) fn image(&self, pipeline: Pipeline) -> WorkerImage {
        let development = Development::of_view(self.world.view());
        WorkerImage {
            pipeline,
            size: self.still.size(),
            pixels: Pixels::Cpu {
                rgb: developed(&denoised(&self.still), self.still.size()[0], &development),
                lengths: self.still.distances(),
            },
            frame_ms: self.frame_ms,
            edit_ms: None,
            steps: None,
            memory_bytes: self.world.memory_bytes(),
            bricks: None,
            missing: u64::from(PATHS - self.still.samples().min(PATHS)),
            lost: 0,
            paths: Some(self.still.samples()),
            triangles: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample_scenes::first;
    use crate::viewport_camera::ViewportCamera;

    /// A still gains paths while nothing changes, and starts over when something does.
    #[test]
    fn stills_are_refined_until_something_changes() {
        let mut request = RenderRequest {
            pipelines: vec![Pipeline::field()],
            show: RenderMode::Shaded,
            resolution: 48,
            camera: ViewportCamera::default().camera(),
            size: [24, 18],
            is_still: true,
            traces_paths: true,
            counts_rays: false,
            version: 0,
        };
        let mut place = None;
        let mut paths = |version: u64, request: &RenderRequest| {
            let still = TracedStill::refined(&mut place, &first(), version, request);
            let image = still.expect("a still").image(Pipeline::field());
            let Pixels::Cpu { rgb, lengths } = &image.pixels else {
                panic!("not on the CPU");
            };
            assert_eq!([rgb.len(), 3 * lengths.len()], [3 * 24 * 18; 2]);
            let done = image.paths.expect("paths");
            assert_eq!(u64::from(done) + image.missing, u64::from(PATHS));
            done
        };
        let mut done = paths(0, &request);
        while done < PATHS {
            let more = paths(0, &request);
            assert!(more > done, "{more}");
            done = more;
        }
        request.size = [18, 24];
        assert!(paths(0, &request) > 0);
        request.size = [24, 18];
        request.camera.eye.x += 0.1;
        assert!(paths(1, &request) > 0);
    }
}
