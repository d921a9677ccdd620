//! The command that repeats a case.

use crate::configuration::{Configuration, ConfigurationKind};
use crate::experiment::StudyCase;
use crate::plan::Plan;
use crate::scenes::{is_shipped, scene};
use crate::task::{CLOSE_SAMPLES, STILL_PATHS, StudyCamera, Task};
use argil::Engine;
use argil::math::Aabb;
use argil::render::{NormalSource, RenderMode};
use argil::volume::VoxelGrid;

/// Returns the flags of a camera.
fn placed(eye: StudyCamera) -> &'static str {
    match eye {
        StudyCamera::Outside => "",
        StudyCamera::Inside => " --camera 25,10,0.3",
        StudyCamera::Grazing => " --camera 70,3,0.9",
    }
}

/// Returns the edge of a voxel.
fn voxel(name: &str, way: Configuration) -> Option<f32> {
    let scene = scene(name).ok()?;
    let world = Engine::cpu().build(&scene).ok()?.field();
    let frame = scene
        .view
        .bounds
        .map(|[a, b]| Aabb::new(a.into(), b.into()));
    let voxel_grid = VoxelGrid::fitting(world.program().aabb(), frame, way.resolution);
    Some(voxel_grid.ok()?.voxel_size)
}

/// Returns the command that repeats a case. `None` if the scene is not a file.
pub(crate) fn command(case: &StudyCase, plan: &Plan) -> Option<String> {
    if !is_shipped(&case.scene) || case.way.kind == ConfigurationKind::MeshAsLarge {
        return None;
    }
    let flags = case.way.flags(plan.is_gpu);
    let device = if plan.is_gpu { "gpu" } else { "cpu" };
    let scene = format!("scenes/{}.json", case.scene);
    let [width, height] = plan.size();
    Some(match case.task {
        Task::Build(_) | Task::CountLostBricks | Task::Stored(_) if !case.way.is_field() => {
            let flags = flags
                .replace(" --descent root", "")
                .replace(" --descent path", "");
            format!("argil bake {scene}{flags} --device {device}")
        }
        Task::Frames(series) if case.way.kind != ConfigurationKind::FidgetWgpu => {
            let [width, height] = series.size.unwrap_or([width, height]);
            let show = if series.is_lit {
                "--show shaded --samples 1"
            } else {
                "--show normal --no-ground"
            };
            format!(
                "argil render {scene}{flags} --device {device} --size {width}x{height} {show} --frames {}{}",
                series.count,
                placed(series.eye)
            )
        }
        Task::Still(_) => format!(
            "argil render {scene}{flags} --device {device} --size {width}x{height} --integrator path --samples {STILL_PATHS}"
        ),
        Task::Surface(_) => {
            let flags = flags
                .replace("--via mesh ", "")
                .replace("--flat", "--normals face");
            format!("argil mesh {scene}{flags} --device {device}")
        }
        Task::Picture(look) => {
            let show = case.parameters();
            let show = show.iter().find(|(key, _)| *key == "show");
            let show = show
                .and_then(|(_, value)| value.as_str())
                .unwrap_or("shaded");
            let mut more = placed(look.eye).to_owned();
            if look.show == RenderMode::Heat {
                more += " --max-steps 256";
            }
            match look.normals {
                NormalSource::Voxel => more += " --normals voxel",
                NormalSource::Field => more += " --normals field",
                _ => {}
            }
            if let Some(voxels) = look.bias_voxels {
                let length = voxels * voxel(&case.scene, case.way)?;
                more += &format!(" --normal-bias {length}");
            }
            let samples = if look.is_close {
                CLOSE_SAMPLES
            } else {
                more.insert_str(0, " --no-ground");
                1
            };
            format!(
                "argil render {scene}{flags} --device {device} --size {width}x{height} --show {show} --samples {samples}{more}"
            )
        }
        _ => return None,
    })
}
