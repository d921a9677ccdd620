//! The window of the program.

use super::SIZE;
use super::carving::Carving;
use super::renderer::Renderer;
use argil::gpu::{GpuCounters, wgpu};
use argil::mesh::Mesh;
use std::sync::Arc;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};

type Fault = Box<dyn std::error::Error>;

/// What is there while the window is.
struct Opened {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    host: Renderer,
    carving: Carving,
}

struct Program {
    teapot: Mesh,
    /// Frames that remain. `None` until the window is closed.
    frames: Option<u32>,
    drawn: u32,
    opened: Option<Opened>,
    counts: [GpuCounters; 2],
    fault: Option<Fault>,
}

/// Shows a window until it is closed, or for a number of frames.
pub(crate) fn run(teapot: Mesh, frames: Option<u32>) -> Result<[GpuCounters; 2], Fault> {
    let events = EventLoop::new()
        .map_err(|error| format!("{error}: there is no display, so run it with --headless"))?;
    let mut program = Program {
        teapot,
        frames,
        drawn: 0,
        opened: None,
        counts: Default::default(),
        fault: None,
    };
    events.run_app(&mut program)?;
    program.fault.map_or(Ok(program.counts), Err)
}

impl Opened {
    fn new(events: &ActiveEventLoop, teapot: &Mesh) -> Result<Self, Fault> {
        let [width, height] = SIZE;
        let attributes = Window::default_attributes()
            .with_title("Argil in another renderer")
            .with_inner_size(LogicalSize::new(width, height));
        let window = Arc::new(events.create_window(attributes)?);
        let instance = wgpu::Instance::default();
        let surface = instance.create_surface(window.clone())?;
        let host = Renderer::new(&instance, Some(&surface), teapot)?;
        let carving = Carving::new(&host.device, &host.queue, &host.targets())?;
        let mut window_state = Self {
            window,
            surface,
            host,
            carving,
        };
        window_state.resize();
        Ok(window_state)
    }

    fn resize(&mut self) {
        let size = self.window.inner_size();
        let size = [size.width, size.height].map(|side| side.max(1));
        self.host.resize(size);
        let format = self.host.format();
        let configuration = wgpu::SurfaceConfiguration {
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            format,
            color_space: Default::default(),
            width: size[0],
            height: size[1],
            present_mode: wgpu::PresentMode::AutoVsync,
            desired_maximum_frame_latency: 2,
            alpha_mode: wgpu::CompositeAlphaMode::Auto,
            view_formats: Vec::new(),
        };
        self.surface.configure(&self.host.device, &configuration);
    }

    fn draw(&mut self, angle: f32) -> Result<(), Fault> {
        use wgpu::CurrentSurfaceTexture as Current;
        match self.surface.get_current_texture() {
            Current::Success(target) | Current::Suboptimal(target) => {
                let view = target.texture.create_view(&Default::default());
                self.host.draw(&view, angle, &mut self.carving)?;
                self.host.queue.present(target);
            }
            Current::Outdated | Current::Lost => self.resize(),
            // There is nothing to draw into now.
            _ => {}
        }
        Ok(())
    }
}

impl ApplicationHandler for Program {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        match Opened::new(events, &self.teapot) {
            Ok(opened) => self.opened = Some(opened),
            Err(fault) => {
                self.fault = Some(fault);
                events.exit();
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(opened) = &mut self.opened else {
            return;
        };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(_) => opened.resize(),
            WindowEvent::RedrawRequested => {
                if let Err(fault) = opened.draw(0.02 * self.drawn as f32) {
                    self.fault = Some(fault);
                    events.exit();
                }
                self.drawn += 1;
                self.counts = opened.carving.counts();
                if self.frames.is_some_and(|frames| self.drawn >= frames) {
                    events.exit();
                }
                opened.window.request_redraw();
            }
            _ => {}
        }
    }
}
