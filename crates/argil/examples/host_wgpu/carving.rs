//! What the host draws besides its own: a block that is carved in each frame.

use argil::gpu::{Gpu, GpuCounters, HostFrame, wgpu};
use argil::prelude::*;
use argil::scene::{Edit, NodeId};
use std::sync::Arc;

/// Holes that stay. The oldest closes again.
const HOLES: usize = 20;

/// A world on the device of the host, and what it asked of the device in each frame.
pub(crate) struct Carving {
    gpu: Arc<Gpu>,
    scene: Scene,
    holes: Vec<NodeId>,
    world: World,
    frame: HostFrame,
    counts: Vec<GpuCounters>,
}

impl Carving {
    /// Builds the block on a device, to be drawn into some targets.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        targets: &argil::gpu::HostTargets,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let gpu = Arc::new(Gpu::from_wgpu(device.clone(), queue.clone())?);
        let mut scene = Scene::new();
        scene.push(Shape::cuboid([1.4, 0.5, 1.4]).at([0.0, -0.35, 0.0]))?;
        let world = Engine::on_gpu(gpu.clone()).build(&scene)?.bricks(128)?;
        Ok(Self {
            frame: world.host_frame(targets)?,
            gpu,
            scene,
            holes: Vec::new(),
            world,
            counts: Vec::new(),
        })
    }

    /// Carves, and encodes the edit and the frame.
    pub(crate) fn encode(
        &mut self,
        size: [u32; 2],
        clip_from_world: [[f32; 4]; 4],
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), Box<dyn std::error::Error>> {
        if self.holes.len() == HOLES {
            let node = self.holes.remove(0);
            self.scene.apply(Edit::Remove { node })?;
        }
        let angle = 0.4 * self.counts.len() as f32;
        let place = [1.2 * angle.cos(), 0.2, 1.2 * angle.sin()];
        let hole = Shape::sphere(0.3).at(place).subtract().smooth(0.05);
        self.holes.push(self.scene.push(hole)?.node);

        let settings = RenderSettings {
            samples: 1,
            ground: false,
            ..self.world.render_settings(size, RenderMode::Shaded)
        };
        let before = self.gpu.counters();
        self.world.encode_edits(&self.scene, encoder)?;
        self.world
            .encode_frame(&mut self.frame, clip_from_world, &settings, encoder)?;
        let mut used = self.gpu.counters().since(before);
        // That of the host, of which the rest is a part.
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
