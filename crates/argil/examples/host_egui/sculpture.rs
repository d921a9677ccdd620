//! The world that the user interface shows.

use super::Fault;
use argil::gpu::{Gpu, GpuCounters, HostFrame, HostTargets, wgpu};
use argil::prelude::*;
use argil::scene::{Edit, NodeId};
use std::sync::Arc;

/// What is to be drawn.
#[derive(Clone)]
pub(crate) struct Draw {
    pub(crate) radius: f32,
    pub(crate) blend: f32,
    pub(crate) size: [u32; 2],
    pub(crate) clip_from_world: [[f32; 4]; 4],
}

impl Default for Draw {
    fn default() -> Self {
        Self {
            radius: 0.6,
            blend: 0.1,
            size: [1, 1],
            clip_from_world: [[0.0; 4]; 4],
        }
    }
}

/// A block and a sphere on egui's device, and what each frame asked of the device.
pub(crate) struct Sculpture {
    gpu: Arc<Gpu>,
    scene: Scene,
    sphere: NodeId,
    shape: [f32; 2],
    world: World,
    frame: HostFrame,
    counts: Vec<GpuCounters>,
}

fn sphere([radius, blend]: [f32; 2]) -> Brush {
    Brush::new(Shape::sphere(radius))
        .at([0.5, 0.4, 0.5])
        .smooth(blend)
}

impl Sculpture {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        format: wgpu::TextureFormat,
    ) -> Result<Self, Fault> {
        let gpu = Arc::new(Gpu::from_wgpu(device.clone(), queue.clone())?);
        let mut scene = Scene::new();
        scene.push(Shape::cuboid([0.9, 0.4, 0.9]))?;
        let shape = [0.6, 0.1];
        let sphere = scene.push(sphere(shape))?.node;
        let world = Engine::on_gpu(gpu.clone()).build(&scene)?.bricks(128)?;
        Ok(Self {
            frame: world.host_frame(&HostTargets::new(format))?,
            gpu,
            scene,
            sphere,
            shape,
            world,
            counts: Vec::new(),
        })
    }

    /// Encodes the edits since the last frame, and the frame.
    pub(crate) fn encode(
        &mut self,
        draw: &Draw,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), Fault> {
        let before = self.gpu.counters();
        if self.shape != [draw.radius, draw.blend] {
            self.shape = [draw.radius, draw.blend];
            let (node, desc) = (self.sphere, sphere(self.shape).into());
            self.scene.apply(Edit::Replace { node, desc })?;
            self.world.encode_edits(&self.scene, encoder)?;
        }
        let settings = RenderSettings {
            samples: 1,
            ground: false,
            ..self.world.render_settings(draw.size, RenderMode::Shaded)
        };
        let view = draw.clip_from_world;
        self.world
            .encode_frame(&mut self.frame, view, &settings, encoder)?;
        let mut used = self.gpu.counters().since(before);
        // That of egui, of which the rest is a part.
        used.submissions += 1;
        self.counts.push(used);
        Ok(())
    }

    /// Draws the frame.
    pub(crate) fn composite(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.frame.composite(pass);
    }

    /// Returns what the first frame asked of the device, and the most of those in the second half.
    pub(crate) fn counts(&self) -> [GpuCounters; 2] {
        let later = &self.counts[self.counts.len() / 2..];
        let later = later.iter().copied();
        let later = later.fold(GpuCounters::default(), GpuCounters::most);
        [self.counts.first().copied().unwrap_or_default(), later]
    }
}
