//! Cases that are ready to be sampled.
//!
//! *Practice.* [`PreparedCase::prepare`] builds a world and runs the case once without timing it, which compiles shaders.
//! [`PreparedCase::sample`] takes one sample, so that samples of several cases can alternate.
//! [`PreparedCase::finish`] measures what does not depend on time.

use crate::configuration::{Configuration, ConfigurationKind, DENSE, MESH};
use crate::counters;
use crate::experiment::StudyCase;
use crate::first_use;
use crate::image_error;
use crate::outcome::Outcome;
use crate::peer::Peer;
use crate::plan::Plan;
use crate::scenes::scene;
use crate::surface_error::{lost, stored, surface, surface_points};
use crate::task::{FrameSeries, STILL_PATHS, Task};
use crate::views::{camera, settings};
use anyhow::Context;
use argil::render::{Camera, RenderMode, RenderSettings, StillOptions};
use argil::scene::{Brush, Scene, Shape};
use argil::{
    Engine, MeshMethod, MeshNormals, MeshOptions, MeshOutput, Orbit, RenderedImage, Representation,
    World,
};
use std::time::{Duration, Instant};

/// Where cases run.
#[derive(Clone, Copy)]
pub(crate) struct Setup<'a> {
    /// The engine.
    pub engine: &'a Engine,
    /// The amount of measurements.
    pub plan: &'a Plan,
    /// The program of another renderer, if there is one.
    pub peer: Option<&'a Peer>,
}

/// What a case's samples are taken from.
enum State {
    Build(Option<World>),
    Frames {
        world: World,
        cameras: Vec<Camera>,
        settings: RenderSettings,
        hit_pixels: usize,
    },
    Picture(World, Option<RenderedImage>),
    Still(World),
    Edits {
        world: Option<World>,
        scene: Scene,
        places: Vec<[f32; 3]>,
        radius: f32,
    },
    Mesh(World, MeshOptions, Option<MeshOutput>),
    Untimed(World),
    FirstUse,
    Peer {
        repetitions: u32,
        /// How long the timed part of the last run took, which was its end.
        timed: Duration,
    },
}

/// A case that is ready to be sampled.
pub(crate) struct PreparedCase<'a> {
    case: &'a StudyCase,
    setup: Setup<'a>,
    scene: Scene,
    way: Configuration,
    state: State,
    out: Outcome,
}

impl<'a> PreparedCase<'a> {
    /// Builds what a case needs, and runs it once without timing it.
    ///
    /// # Errors
    /// If it fails.
    pub(crate) fn prepare(case: &'a StudyCase, setup: Setup<'a>) -> anyhow::Result<Self> {
        let before = counters::counts(setup.engine);
        let scene = scene(&case.scene)?;
        let way = resolved(case.way, setup.engine, &scene)?;
        let mut prepared = Self {
            case,
            setup,
            scene,
            way,
            state: State::FirstUse,
            out: Outcome::default(),
        };
        prepared.state = prepared.first_state()?;
        prepared.run_once()?;
        for (name, count) in counters::since(&before, &counters::counts(setup.engine)) {
            prepared
                .out
                .set(&format!("{name}_of_preparation"), count as f64);
        }
        Ok(prepared)
    }

    fn build(&self) -> anyhow::Result<World> {
        let build = self.setup.engine.build(&self.scene)?;
        let mut world = build.with_representation(self.way.via())?;
        if self.way.kind == ConfigurationKind::Compiled {
            world.specialize()?;
        }
        Ok(world)
    }

    fn first_state(&self) -> anyhow::Result<State> {
        Ok(match self.case.task {
            Task::Build(_) => State::Build(Some(self.build()?)),
            Task::Frames(series) => self.frames(self.build()?, series),
            Task::Picture(_) => State::Picture(self.build()?, None),
            Task::Still(_) => State::Still(self.build()?),
            Task::Stored(_) | Task::CountLostBricks => State::Untimed(self.build()?),
            Task::Surface(_) => {
                let field = self.setup.engine.build(&self.scene)?.field();
                State::Mesh(field, mesh_options(self.way)?, None)
            }
            Task::Edits(count, radius) => {
                let world = self.build()?;
                State::Edits {
                    places: surface_points(&world, count),
                    radius: radius * world.view_bounds().size().max_element(),
                    scene: scene(&self.case.scene)?,
                    world: Some(world),
                }
            }
            Task::FirstUse(_) => State::FirstUse,
            Task::Peer(_) => State::Peer {
                repetitions: self
                    .peer()?
                    .try_out(&self.case.scene, self.way.resolution)?,
                timed: Duration::ZERO,
            },
        })
    }

    fn peer(&self) -> anyhow::Result<&'a Peer> {
        self.setup.peer.context("no peer was given")
    }

    fn frames(&self, world: World, series: FrameSeries) -> State {
        let size = series.size.unwrap_or_else(|| self.setup.plan.size());
        let mode = if series.is_lit {
            RenderMode::Shaded
        } else {
            RenderMode::Normal
        };
        let defaults = world.render_settings(size, mode);
        let settings = RenderSettings {
            samples: 1,
            ground: series.is_lit && defaults.ground,
            lookup_start: self.case.way.descent(),
            // A GPU counts in frames that are not timed: one of ten.
            statistics: !self.setup.plan.is_gpu,
            ..defaults
        };
        let first = camera(&world, series.eye);
        State::Frames {
            cameras: Orbit::cameras(first, series.count).collect(),
            world,
            settings,
            hit_pixels: 0,
        }
    }

    /// Runs the case without timing it, so that shaders are compiled and memory was accessed.
    fn run_once(&mut self) -> anyhow::Result<()> {
        let plan = self.setup.plan;
        match &mut self.state {
            State::Frames {
                world,
                cameras,
                settings,
                ..
            } => {
                let count = cameras.len().div_ceil(10) as u32;
                for camera in cameras
                    .first()
                    .into_iter()
                    .flat_map(|&c| Orbit::cameras(c, count))
                {
                    world.render(&camera, settings)?;
                }
            }
            State::Still(_) if plan.is_gpu => self.sample(0)?,
            State::Picture(..) if plan.is_hardware() => self.sample(0)?,
            State::Mesh(world, options, meshed) => *meshed = Some(world.mesh(options)?),
            State::Edits { .. } if plan.is_gpu => {
                self.sample(0)?;
                self.restart()?;
            }
            _ => {}
        }
        self.out = Outcome::default();
        Ok(())
    }

    /// Returns the number of samples to take.
    pub(crate) fn rounds(&self) -> usize {
        match (&self.state, self.case.task) {
            (State::Frames { cameras, .. }, _) => cameras.len(),
            (State::Edits { places, .. }, _) => places.len(),
            (_, Task::Build(runs) | Task::Peer(runs) | Task::Still(runs)) => runs as usize,
            (_, Task::Surface(_)) => 3,
            (_, Task::Picture(_)) => 1,
            (_, Task::FirstUse(_)) => 1 + usize::from(self.setup.plan.is_hardware()),
            _ => 0,
        }
    }

    /// Takes a sample.
    ///
    /// # Errors
    /// If it fails.
    pub(crate) fn sample(&mut self, round: usize) -> anyhow::Result<()> {
        let before = counters::counts(self.setup.engine);
        self.timed(round)?;
        for (name, count) in counters::since(&before, &counters::counts(self.setup.engine)) {
            self.out.add(name, count as f64);
        }
        Ok(())
    }

    fn timed(&mut self, round: usize) -> anyhow::Result<()> {
        let out = &mut self.out;
        match &mut self.state {
            State::Build(world) => {
                let built = world.take().context("an earlier build failed")?;
                let built = built.rebuilt_as(&self.scene, self.way.via())?;
                let times = built.build_timings();
                out.add("build_ms", times.duration_ms);
                for (stage, ms) in &times.stages_ms {
                    out.add(&format!("{stage}_ms"), *ms);
                }
                *world = Some(built);
            }
            State::Frames {
                world,
                cameras,
                settings,
                hit_pixels,
            } => {
                let camera = cameras.get(round).context("no such frame")?;
                let start = Instant::now();
                let drawn = world.render(camera, settings)?;
                out.add("frame_wall_ms", start.elapsed().as_secs_f64() * 1e3);
                out.add("frame_ms", drawn.duration_ms);
                out.add_statistics(&drawn);
                *hit_pixels += drawn.hit_pixels;
            }
            State::Picture(world, image) => {
                let Task::Picture(look) = self.case.task else {
                    anyhow::bail!("no image to render");
                };
                let settings = settings(world, self.setup.plan, (&self.case.way, &look));
                let drawn = world.render(&camera(world, look.eye), &settings)?;
                out.add("frame_ms", drawn.duration_ms);
                *image = Some(drawn);
            }
            State::Still(world) => still(world, self.setup.plan, out)?,
            State::Edits {
                world,
                scene,
                places,
                radius,
            } => {
                let place = *places.get(round).context("no such edit")?;
                scene.push(Brush::new(Shape::sphere(*radius)).at(place).subtract())?;
                edit(world.as_mut().context("no world")?, scene, out)?;
            }
            State::Mesh(world, options, meshed) => {
                let mesh = world.mesh(options)?;
                out.add("mesh_ms", mesh.duration_ms);
                *meshed = Some(mesh);
            }
            State::FirstUse => {
                if let Task::FirstUse(kind) = self.case.task {
                    first_use::sample(kind, &self.scene, out)?;
                }
            }
            State::Peer { repetitions, timed } => {
                let peer = self.setup.peer.context("no peer was given")?;
                let size = (self.way.resolution, *repetitions);
                *timed = peer.sample(&self.case.scene, size, out)?;
            }
            State::Untimed(_) => {}
        }
        Ok(())
    }

    /// Returns how long the timed part of the last sample took, if it was only the end of it.
    pub(crate) fn timed_end(&self) -> Option<Duration> {
        match self.state {
            State::Peer { timed, .. } => Some(timed),
            _ => None,
        }
    }

    /// Drops the samples, to take them again.
    ///
    /// # Errors
    /// If a world must be built again, and that fails.
    pub(crate) fn restart(&mut self) -> anyhow::Result<()> {
        self.out.samples.clear();
        match &mut self.state {
            State::Frames { hit_pixels, .. } => *hit_pixels = 0,
            State::Edits {
                world,
                scene: original,
                ..
            } => {
                *original = scene(&self.case.scene)?;
                let edited = world.take().context("no world")?;
                *world = Some(edited.rebuilt_as(original, self.way.via())?);
            }
            _ => {}
        }
        Ok(())
    }

    /// Measures what does not depend on time, and returns all results.
    ///
    /// # Errors
    /// If it fails.
    pub(crate) fn finish(self) -> anyhow::Result<Outcome> {
        let mut out = self.out;
        let plan = self.setup.plan;
        match (self.state, self.case.task) {
            (State::Build(world), _) => out.about(&world.context("a build failed")?)?,
            (
                State::Frames {
                    world,
                    hit_pixels,
                    cameras,
                    settings,
                },
                _,
            ) => {
                let statistics = true;
                let counted = RenderSettings {
                    statistics,
                    ..settings
                };
                for camera in cameras.iter().step_by(10).filter(|_| plan.is_gpu) {
                    out.add_statistics(&world.render(camera, &counted)?);
                }
                out.set("hit_pixels", hit_pixels as f64);
                out.about(&world)?;
            }
            (State::Picture(world, drawn), Task::Picture(look)) => {
                let drawn = drawn.context("no image was rendered")?;
                image_error::picture((&world, drawn), self.case, plan, look, &mut out)?;
            }
            (State::Edits { world, .. }, _) => {
                let world = world.context("no world")?;
                out.set("brushes", world.program().brush_count() as f64);
                out.about(&world)?;
            }
            (State::Mesh(world, _, meshed), Task::Surface(count)) => {
                let meshed = meshed.context("no mesh was extracted")?;
                surface(&world, &meshed, count, &mut out)?;
            }
            (State::Untimed(world), Task::Stored(count)) => stored(&world, count, &mut out)?,
            (State::Untimed(world), _) => lost(&world, &mut out)?,
            _ => {}
        }
        Ok(out)
    }
}

/// Makes a still of a world.
fn still(world: &World, plan: &Plan, out: &mut Outcome) -> anyhow::Result<()> {
    let settings = world.render_settings(plan.size(), RenderMode::Shaded);
    let options = StillOptions {
        samples: STILL_PATHS,
        ..StillOptions::default()
    };
    let start = Instant::now();
    world.still(&world.camera(), &settings, &options)?;
    out.add("still_ms", start.elapsed().as_secs_f64() * 1e3);
    Ok(())
}

fn edit(world: &mut World, scene: &Scene, out: &mut Outcome) -> anyhow::Result<()> {
    let start = Instant::now();
    let applied = world.apply(scene)?;
    let counts = world.flush()?;
    out.add("edit_ms", start.elapsed().as_secs_f64() * 1e3);
    if !applied.rebuilt {
        out.add("edited_bricks", counts.filled as f64);
    }
    out.add(
        "dirty_volume",
        f64::from(applied.dirty_box.size().element_product()),
    );
    Ok(())
}

/// Resolves a configuration whose resolution depends on another's size.
fn resolved(way: Configuration, engine: &Engine, scene: &Scene) -> anyhow::Result<Configuration> {
    if way.kind != ConfigurationKind::MeshAsLarge {
        return Ok(way);
    }
    let bytes = |way: Configuration| -> anyhow::Result<f64> {
        let world = engine.build(scene)?.with_representation(way.via())?;
        Ok(world.memory_bytes() as f64)
    };
    let target = bytes(Configuration::of(DENSE, way.resolution))?;
    let mut resolution = 64.0;
    // The number of triangles grows almost quadratically; less where thin parts appear only at higher resolutions.
    for _ in 0..3 {
        let needed = bytes(Configuration::of(MESH, resolution as u32))?.max(1.0);
        resolution = (resolution * (target / needed).sqrt())
            .clamp(16.0, 1024.0)
            .round();
    }
    Ok(Configuration::of(MESH, resolution as u32))
}

fn mesh_options(way: Configuration) -> anyhow::Result<MeshOptions> {
    let Representation::Mesh(via) = way.via() else {
        anyhow::bail!("surface errors need triangles");
    };
    Ok(MeshOptions {
        method: via.method,
        resolution: via.resolution,
        normals: if via.flat {
            MeshNormals::Face
        } else {
            MeshNormals::Field
        },
        materials: false,
        unindexed: via.flat && via.method == MeshMethod::MarchingCubes,
        ..MeshOptions::default()
    })
}
