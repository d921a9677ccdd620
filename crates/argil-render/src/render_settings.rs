use crate::camera::{Camera, finite};
use crate::view_light::ViewLight;
use argil_abi::{self as abi, FrameUniform};
use argil_field::Program;
use argil_math::Aabb;
use argil_volume::VoxelGrid;
use glam::Vec3;

/// What an image shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum RenderMode {
    /// Light and materials.
    #[default]
    Shaded,
    /// Normals as colors: x, y, z from −1 to 1 as red, green, blue from 0 to 1.
    Normal,
    /// The length of each ray: near is white, far is black.
    Depth,
    /// The steps of each ray: none to [`RenderSettings::heat_steps`] as blue, green, yellow, red.
    Heat,
    /// The first brick that each ray meets, in a color per brick. For sparse bricks and octrees.
    Bricks,
    /// The first node above bricks that contains a brick along the ray, in a color per node. For octrees.
    Nodes,
    /// The voxel size at each hit, in a color per level. Red where a finer brick is missing. For levels of detail.
    Levels,
}

/// The source of normals for bricks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum NormalSource {
    /// The gradient of the voxel that is hit, which jumps between voxels.
    Voxel,
    /// Differences over one voxel around the hit, which change without jumps.
    #[default]
    Smooth,
    /// Differences of the exact field.
    Field,
}

/// Where look-ups in an octree start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum LookupStart {
    /// At the root, as in the 2023 study.
    #[default]
    Root,
    /// At the deepest node that is shared with the previous look-up.
    Path,
}

/// Settings of an image. Lengths are in the scene's unit.
///
/// ```
/// use argil_render::{RenderMode, RenderSettings};
/// let settings = RenderSettings { size: [640, 480], mode: RenderMode::Normal, ..RenderSettings::default() };
/// assert_eq!(settings.samples, 1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// What to show.
    pub mode: RenderMode,
    /// Maximum steps of a primary ray.
    pub max_steps: u32,
    /// Distance at which a ray counts as a hit. If `None`, 1e-4 of the scene's radius, or 0.02 voxels of a volume. After many steps
    /// through the field, then also a tenth of a pixel.
    pub epsilon: Option<f32>,
    /// Half the step of the normal's central difference. If `None`, 5e-4 of the scene's radius, or a voxel of a
    /// volume.
    pub normal_bias: Option<f32>,
    /// The source of normals for bricks.
    pub normals: NormalSource,
    /// Where look-ups in an octree start.
    pub lookup_start: LookupStart,
    /// Rays per pixel, from 1 to 64.
    pub samples: u32,
    /// Whether there is a ground plane under the scene.
    pub ground: bool,
    /// Height of the ground plane. If `None`, the lowest of a box that contains the scene, which may be lower than the surface.
    /// `World::render` asks the surface.
    pub ground_height: Option<f32>,
    /// Direction to the sun, as azimuth and elevation in degrees.
    pub sun_degrees: [f32; 2],
    /// The light besides the sun's direction.
    pub light: ViewLight,
    /// Steps from which on [`RenderMode::Heat`] is red. If `None`, 256. `World::render` takes a quarter more than the 95th percentile
    /// of the image.
    pub heat_steps: Option<u32>,
    /// Whether the steps of rays are counted, which costs a GPU memory and a pass.
    pub statistics: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            size: [1280, 720],
            mode: RenderMode::Shaded,
            max_steps: 256,
            epsilon: None,
            normal_bias: None,
            normals: NormalSource::default(),
            lookup_start: LookupStart::default(),
            samples: 1,
            ground: false,
            ground_height: None,
            sun_degrees: [60.0, 50.0],
            light: ViewLight::default(),
            heat_steps: None,
            statistics: false,
        }
    }
}

/// Steps that are red if nobody says how many.
const MOST_HEAT: u32 = 256;
/// The part of a pixel within which a ray through the field counts as a hit after many steps.
const CLOSE_PIXELS: f32 = 0.1;

/// Voxels around a volume's solid where rays start, so that the stored distance is not yet negative.
const MARGIN_VOXELS: f32 = 2.0;

/// Returns the frame of each sample, which both devices read. With a voxel grid, lengths are measured in its
/// voxels, and rays are cut to its box. `focus` is the box that is viewed. It determines lengths that depend on the
/// scene's size.
pub fn frame_uniforms(
    settings: &RenderSettings,
    camera: &Camera,
    program: &Program,
    voxel_grid: Option<&VoxelGrid>,
    focus: Aabb,
) -> Vec<FrameUniform> {
    let (focus, radius) = finite(focus);
    let [width, height] = settings.size;
    let [right, up, forward] = camera.axes();
    let half_height = (0.5 * camera.field_of_view_degrees).to_radians().tan();
    let half_width = half_height * width as f32 / height as f32;
    let default_length = |of_radius: f32, of_voxel: f32| {
        voxel_grid.map_or(of_radius * radius, |voxel_grid| {
            of_voxel * voxel_grid.voxel_size
        })
    };
    let epsilon = settings.epsilon.unwrap_or(default_length(1e-4, 0.02));
    let normal_bias = settings
        .normal_bias
        .unwrap_or_else(|| match settings.normals {
            NormalSource::Field => 5e-4 * radius,
            _ => default_length(5e-4, 1.0),
        });
    // Light is gathered above the surface, because a volume's surface is not quite the field's, which casts the
    // shadows.
    let lift = voxel_grid.map_or(8.0 * epsilon, |voxel_grid| 1.5 * voxel_grid.voxel_size);
    let solid = program.aabb();
    let bounds = ray_box(settings.mode, solid, voxel_grid, epsilon);
    let below = if solid.is_finite() { solid } else { focus };
    let ground_y = settings.ground_height.unwrap_or(below.min.y);
    let far_from_eye = |corner: Vec3| corner.distance(camera.eye);
    let depth_far = focus.corners().map(far_from_eye).into_iter();
    let depth_far = match settings.mode {
        RenderMode::Heat => settings.heat_steps.unwrap_or(MOST_HEAT).max(1) as f32,
        _ => depth_far.fold(0.0, f32::max),
    };
    let pixel_width = 2.0 * half_height / height as f32;
    let samples = settings.samples.clamp(1, 64);
    (0..samples)
        .map(|sample| {
            let [jitter_x, jitter_y] = offset(sample, samples);
            let mut frame = FrameUniform {
                eye: camera.eye.to_array(),
                inv_lipschitz: 1.0 / program.lipschitz(),
                right: (right * half_width).to_array(),
                jitter_x,
                up: (up * half_height).to_array(),
                jitter_y,
                forward: forward.to_array(),
                ground_y,
                box_min: bounds.min.to_array(),
                epsilon,
                box_max: bounds.max.to_array(),
                normal_bias,
                radius,
                width,
                height,
                first_row: 0,
                max_steps: settings.max_steps,
                mode: mode_word(settings.mode),
                sample_weight: 1.0 / samples as f32,
                far: 60.0 * radius,
                depth_near: focus.distance(camera.eye),
                depth_far,
                pixel_width,
                close_slope: close_slope(settings, voxel_grid) * pixel_width,
                records: if settings.statistics {
                    abi::RECORD_COUNTS
                } else {
                    0
                },
                first_step: 0,
                step_count: settings.max_steps,
                light_offset: lift,
                normals: normals_word(settings.normals),
                has_ground: u32::from(settings.ground),
                descent: match settings.lookup_start {
                    LookupStart::Root => abi::DESCENT_ROOT,
                    LookupStart::Path => abi::DESCENT_PATH,
                },
                ..FrameUniform::default()
            };
            settings.light.write(settings.sun_degrees, &mut frame);
            frame
        })
        .collect()
}

/// Returns the part of a pixel within which a ray counts as a hit after many steps.
fn close_slope(settings: &RenderSettings, voxel_grid: Option<&VoxelGrid>) -> f32 {
    match (settings.epsilon, voxel_grid) {
        (None, None) => CLOSE_PIXELS,
        _ => 0.0,
    }
}

/// Returns the box that rays are cut to: the solid's, a little larger, because a ray should not start within
/// epsilon of a flat side. An empty scene returns a box that no ray meets.
fn ray_box(show: RenderMode, solid: Aabb, voxel_grid: Option<&VoxelGrid>, epsilon: f32) -> Aabb {
    let margin = voxel_grid.map_or(4.0 * epsilon, |voxel_grid| {
        MARGIN_VOXELS * voxel_grid.voxel_size
    });
    let held = voxel_grid.map_or(Aabb::ALL, VoxelGrid::aabb);
    let shows_boxes = matches!(show, RenderMode::Bricks | RenderMode::Nodes);
    let bounds = if solid.is_empty() {
        NOWHERE
    } else if shows_boxes && voxel_grid.is_some() {
        // Bricks extend beyond their contents.
        held
    } else {
        let cut = solid.grown(margin).intersection(held);
        if cut.is_empty() { NOWHERE } else { cut }
    };
    let limit = Vec3::splat(argil_field::WORLD_LIMIT);
    Aabb::new(bounds.min.max(-limit), bounds.max.min(limit))
}

fn mode_word(show: RenderMode) -> u32 {
    match show {
        RenderMode::Shaded => abi::MODE_SHADED,
        RenderMode::Normal => abi::MODE_NORMAL,
        RenderMode::Depth => abi::MODE_DEPTH,
        RenderMode::Heat => abi::MODE_HEAT,
        RenderMode::Bricks => abi::MODE_BRICKS,
        RenderMode::Nodes => abi::MODE_NODES,
        RenderMode::Levels => abi::MODE_LEVELS,
    }
}

fn normals_word(normals: NormalSource) -> u32 {
    match normals {
        NormalSource::Voxel => abi::NORMALS_VOXEL,
        NormalSource::Smooth => abi::NORMALS_SMOOTH,
        NormalSource::Field => abi::NORMALS_FIELD,
    }
}

/// A box that no ray meets.
const NOWHERE: Aabb = Aabb::new(Vec3::splat(1e8), Vec3::splat(1e8));

/// Returns a sample's position in its pixel: the center for one sample, and the R2 sequence for more (Roberts, "The
/// unreasonable effectiveness of quasirandom sequences", 2018).
fn offset(sample: u32, samples: u32) -> [f32; 2] {
    if samples == 1 {
        return [0.5, 0.5];
    }
    let n = sample as f32;
    [
        (0.5 + n * 0.754_877_7).fract(),
        (0.5 + n * 0.569_840_3).fract(),
    ]
}
