//! The command line.

use crate::arg_values::{
    bits, brick_size, orbit, pixels, pixels_per_degree, point, positive, seconds, shape, size,
    voxels,
};
use crate::representation_parser::RepresentationsExcept;
use crate::still_args::StillArgs;
#[cfg(feature = "world")]
use crate::world_args::WorldArgs;
use argil::mesh::UpAxis;
use argil::render::{LookupStart, NormalSource, RenderMode};
use argil::scene::CameraPose;
use argil::volume::{BrickOrdering, BrickTest, DenseFill, SampleFormat};
use argil::{Backend, ExportClass, ExportCodec, MeshMethod, MeshNormals, RawType, Representation};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Malleable environments made of signed distance fields.
#[derive(Parser)]
#[command(name = "argil", version, about, max_term_width = 100, after_help = crate::failure::EXIT_CODES)]
pub(crate) struct CommandLine {
    #[command(subcommand)]
    pub command: CliCommand,
}

#[derive(Subcommand)]
pub(crate) enum CliCommand {
    /// Render an image; with --frames, render and time an orbit or an animation
    Render(RenderArgs),
    /// Build a volume from a scene, and time it; with -o, write it
    Bake(BakeArgs),
    /// Extract triangles from a scene or a volume; with -o, write them as GLB, OBJ, PLY, STL or 3MF
    Mesh(MeshArgs),
    /// Apply a file of edits to a built volume, and time each one
    Edit(EditArgs),
    /// Recover a scene from its journal after a crash
    Recover(Recover),
    /// Create a scene from a triangle mesh, a heightmap, or a tree file of "Lipschitz Pruning" (Barbier et al. 2025)
    Import(Import),
    /// Compare two images: PSNR, SSIM, FLIP, and the 2023 study's difference of Laplacians
    Compare(Compare),
    /// Describe a scene, a mesh, or a volume, also of other programs
    Info(Info),
    /// Repeat and extend the 2023 study, and write a report; resumes if it was interrupted
    Study(Companion),
    /// Open the editor
    Studio(Companion),
    /// List the devices of this machine, and which one --device auto selects
    Devices(Devices),
    /// Bake a world as tiles in a folder or an object store, with any number of workers
    #[cfg(feature = "world")]
    World(WorldArgs),
    #[cfg(not(feature = "world"))]
    #[command(hide = true)]
    World(Companion),
    /// Print the JSON schema of scene files
    Schema,
}

#[derive(Args)]
pub(crate) struct RenderArgs {
    /// A scene file, a volume file from `argil bake`, or a world from `argil world`: its folder, or the address of its manifest
    pub scene: PathBuf,
    /// Levels of a scene: take pages from the world of `argil world` in this folder or object store, as far as it has them
    #[cfg(feature = "world")]
    #[arg(long, value_name = "ADDRESS")]
    pub store: Option<String>,
    /// Output image [default: the scene's name with .png, in this folder]. With --frames, a number is added
    #[arg(short, long, value_name = "PNG")]
    pub output: Option<PathBuf>,
    /// What rays march through [default: the field of a scene, or the contents of a volume file]
    #[arg(long, value_enum)]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub still: StillArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// What the image shows
    #[arg(long, value_enum, default_value_t = RenderMode::Shaded)]
    pub show: RenderMode,
    /// Orbit camera: degrees, degrees, multiples of the scene's radius [default: the scene's camera]
    #[arg(long, value_name = "AZIMUTH,ELEVATION,DISTANCE", value_parser = orbit, allow_hyphen_values = true)]
    pub camera: Option<CameraPose>,
    /// Time in seconds at which to evaluate keyframes [default: 0; with --frames, the whole animation]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<f32>,
    /// Render N frames and time each: the animation if the scene has keyframes and --time is not given, else an orbit. Frames are
    /// written only with -o
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: Option<u32>,
    /// With --frames: move the camera along a path of the scene's view
    #[arg(long, value_name = "NAME", requires = "frames")]
    pub path: Option<String>,
    /// Levels: milliseconds for baking after each frame, with whatever is resident [default: until nothing is missing]
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = positive, requires = "frames")]
    pub fill_ms: Option<f32>,
    /// Maximum steps per primary ray [default: 256 for the field, 4096 for volumes; at most 50000 on a software GPU]. An octree
    /// look-up in progress is always completed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub max_steps: Option<u32>,
    /// Distance at which a ray counts as a hit, in the scene's unit [default: 1e-4 of the scene's radius, after many steps a tenth of a pixel, or 0.02 voxels]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = positive)]
    pub epsilon: Option<f32>,
    /// Half the step of the normal's central difference, in the scene's unit [default: 5e-4 of the scene's radius, or a voxel]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = positive)]
    pub normal_bias: Option<f32>,
    /// Bricks: source of normals [default: smooth]
    #[arg(long, value_enum)]
    pub normals: Option<NormalSource>,
    /// Add a ground plane under the scene
    #[arg(long, overrides_with = "no_ground")]
    pub ground: bool,
    /// Omit the scene's ground plane
    #[arg(long)]
    pub no_ground: bool,
    /// Compile the scene into the shader (GPU only)
    #[arg(long)]
    pub specialize: bool,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// How to build a volume, and how to march an octree.
#[derive(Args, Clone, Default, PartialEq)]
pub(crate) struct VolumeArgs {
    /// Voxels along the longest side of the scene's box [default: 256; levels: 16384 at the finest level]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub resolution: Option<u32>,
    /// Bricks, levels, and meshes of the field: edge of a voxel in the scene's unit, instead of --resolution
    #[arg(long, alias = "voxel", value_name = "LENGTH", allow_negative_numbers = true, value_parser = positive, conflicts_with = "resolution")]
    pub voxel_size: Option<f32>,
    /// Dense: build mips, whose band doubles with each level
    #[arg(long)]
    pub mips: bool,
    /// Bits per stored distance, 8 or 16 [default: 16 for bricks, 32 in files for other programs, else 8]
    #[arg(long, value_name = "8|16", value_parser = bits)]
    pub bits: Option<SampleFormat>,
    /// Width of the stored band in voxels, on each side of the surface [default: 16 for bricks of 16 bits, 3 in files for other programs, else 4]
    #[arg(long, value_name = "VOXELS", allow_negative_numbers = true, value_parser = voxels, conflicts_with = "stride")]
    pub band: Option<f32>,
    /// The 2023 study's texture stride, from 1 to 32: a band of 256/N voxels
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=32))]
    pub stride: Option<u32>,
    /// Voxels along a brick's side: bricks 4, 8 or 16 [default: 8]; octree 8, 16 or 32 [default: 32]
    #[arg(long, value_name = "N", value_parser = brick_size)]
    pub brick: Option<u32>,
    /// Bricks, levels: maximum memory in MiB; a request that needs more is refused [default: what is free; levels 160]
    #[arg(long, value_name = "MIB", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub memory_budget: Option<u32>,
    /// Levels: the size of a voxel that a ray accepts, from 0.125 to 1024 pixels; for a mesh, of an image of 720 rows [default: 1]
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, value_parser = pixels)]
    pub pixel_error: Option<f32>,
    /// Octree: levels of nodes [default: as many as it needs]
    #[arg(long, value_name = "N")]
    pub depth: Option<u32>,
    /// Octree: which bricks to keep [default: all that the surface can pass through]
    #[arg(long, value_enum)]
    pub keep: Option<BrickTest>,
    /// Octree: where a ray's look-ups start [default: root]
    #[arg(long, value_enum)]
    pub descent: Option<LookupStart>,
    /// Octree on a GPU: how to order bricks [default: prefix-sum]
    #[arg(long, value_enum)]
    pub sort: Option<BrickOrdering>,
    /// Mesh: how to extract triangles; flat parts get as many as others: --max-triangles merges them [default: mc]
    #[arg(long, value_enum)]
    pub method: Option<MeshMethod>,
    /// Mesh: shade each triangle with its own normal, as the 2023 study did
    #[arg(long)]
    pub flat: bool,
    /// Dense on a GPU: how to fill the texture [default: tiled]
    #[arg(long, value_enum)]
    pub fill: Option<DenseFill>,
}

/// How volumes for other programs are written.
#[derive(Args)]
#[command(next_help_heading = "Volumes for other programs")]
pub(crate) struct ExportArgs {
    /// What values mean [default: level-set]
    #[arg(long, value_enum)]
    pub class: Option<ExportClass>,
    /// .vdb, .nvdb: keep the field's values where they are bounds of the distance, as in blends [default: they are divided
    /// by the field's slope]
    #[arg(long)]
    pub keep_bounds: bool,
    /// .vdb: how values are compressed [default: none]
    #[arg(long, value_enum)]
    pub codec: Option<ExportCodec>,
    /// .vdb: also write the materials' colors, as a grid named Cd
    #[arg(long)]
    pub colors: bool,
}

#[derive(Args)]
pub(crate) struct BakeArgs {
    /// A scene file, or a volume file, whose scene is built again
    pub scene: PathBuf,
    /// Output: .argil for Argil, or .vdb, .nvdb, .npy, .nrrd, .raw, .png (a flip-book) or .zarr for other programs; without it, the volume is only
    /// timed
    #[arg(short, long, value_name = "VOLUME")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub export: ExportArgs,
    /// What to build [default: bricks, or dense with --mips or --fill]
    #[arg(long, value_parser = RepresentationsExcept(&["field", "levels", "mesh"]))]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// Time in seconds at which to evaluate keyframes [default: 0]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<f32>,
    /// Build N times, and time each build
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: u32,
    /// Octree: also count the bricks that the study's test loses and the conservative test keeps
    #[arg(long)]
    pub count_lost: bool,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct MeshArgs {
    /// A scene file, or a volume file from `argil bake`
    pub scene: PathBuf,
    /// Output file: .glb, .gltf, .obj, .ply, .stl or .3mf; without it, the triangles are only counted and timed
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// What to mesh: field, dense, bricks or levels [default: the field of a scene, or the contents of a volume file]
    #[arg(long, value_parser = RepresentationsExcept(&["octree", "mesh"]))]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// Distance from the solid at which to extract the surface, in the scene's unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub iso: f32,
    /// Simplify to at most N triangles, or to as few as keep the surface closed
    #[arg(long, alias = "triangles", value_name = "N", value_parser = clap::value_parser!(u32).range(4..))]
    pub max_triangles: Option<u32>,
    /// Also write N coarser meshes, each with a quarter of the triangles of the one before, as NAME-1.glb and so on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16), requires = "output")]
    pub lods: Option<u32>,
    /// Source of normals
    #[arg(long, value_enum, default_value_t = MeshNormals::Field)]
    pub normals: MeshNormals,
    /// Give each triangle its own three vertices, as the 2023 study did
    #[arg(long, alias = "unshared")]
    pub unindexed: bool,
    /// Up axis and handedness of the file [default: y-up; .glb is always y-up]
    #[arg(long, value_enum)]
    pub axes: Option<UpAxis>,
    /// Unit of the file, if the scene's unit is a meter [default: m; .glb is always in meters]
    #[arg(long, value_enum)]
    pub unit: Option<MeshUnit>,
    /// Time in seconds at which to evaluate keyframes [default: 0]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<f32>,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MeshUnit {
    /// Meters
    M,
    /// Centimeters
    Cm,
    /// Millimeters
    Mm,
    /// Inches
    In,
}

#[derive(Args)]
pub(crate) struct EditArgs {
    /// A scene file, which is baked first, or a volume file
    pub scene: PathBuf,
    /// The edits, one JSON object per line. "edit" is insert (into, index, entry), remove (node), replace (node, entry), move
    /// (node, into, index), transform (node, by), set_visible (node, visible), set_material (name, material),
    /// set_view (all of the view), rename_meshes (paths), undo, redo, begin_stroke or end_stroke. A node is a path such as brushes[2].brushes[0]
    #[arg(long, value_name = "FILE")]
    pub edits: PathBuf,
    /// Output volume
    #[arg(short, long, value_name = "VOLUME")]
    pub output: Option<PathBuf>,
    /// Output scene
    #[arg(long, value_name = "SCENE")]
    pub scene_output: Option<PathBuf>,
    /// Record each edit in this file, for `argil recover` after a crash. Removed once --scene-output is written
    #[arg(long, value_name = "JOURNAL")]
    pub journal: Option<PathBuf>,
    /// What to bake a scene to [default: bricks, which are edited in place; others are rebuilt after each edit]
    #[arg(long, value_parser = RepresentationsExcept(&["mesh"]))]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// Compare the bricks at the end with a fresh bake, and fail if a cell differs
    #[arg(long)]
    pub check: bool,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct Recover {
    /// The journal that `argil edit --journal` or the editor left
    pub journal: PathBuf,
    /// Output scene
    #[arg(short, long, value_name = "SCENE")]
    pub output: PathBuf,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Where to run.
#[derive(Args)]
pub(crate) struct DeviceArgs {
    /// Device: auto selects a hardware GPU if there is one, else the CPU
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub device: Backend,
    /// Load meshes from outside the scene's folder
    #[arg(long, alias = "allow-outside")]
    pub allow_external_meshes: bool,
    /// Threads of the CPU path [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

#[derive(Args)]
pub(crate) struct Import {
    /// A mesh (.glb, .gltf, .obj, .ply, .stl, .3mf), a volume (.vdb, .nvdb, .npy, .nrrd, .raw), a heightmap (.png), or a tree file
    pub file: PathBuf,
    /// Output scene
    #[arg(short, long, value_name = "SCENE")]
    pub output: PathBuf,
    /// Mesh: samples along the longest side of its box, from 16 to 512 [default: 128]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=512))]
    pub resolution: Option<u32>,
    /// Mesh: turn parts with open edges into walls of this thickness, instead of closing them. The result goes next to the
    /// scene, as <SCENE>-thick.ply
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub thickness: Option<f32>,
    #[command(flatten)]
    pub volume: VolumeImportArgs,
    /// Mesh: let the scene name a file outside its folder. Every command that reads the scene then needs this flag too
    #[arg(long, alias = "allow-outside")]
    pub allow_external_meshes: bool,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// How volumes of other programs are read.
#[derive(Args)]
#[command(next_help_heading = "Volumes of other programs")]
pub(crate) struct VolumeImportArgs {
    /// .vdb, .nvdb: name of the grid [default: the first with single numbers]
    #[arg(long, value_name = "NAME")]
    pub grid: Option<String>,
    /// What values mean [default: what the file says, else level-set]
    #[arg(long, value_enum)]
    pub class: Option<ExportClass>,
    /// The value at the surface [default: 0, or half of the largest density, which lies inside of densities that Argil wrote]
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub iso: Option<f32>,
    /// .raw: number of values along x, y and z. x is fastest
    #[arg(long, value_name = "X,Y,Z", value_parser = shape)]
    pub shape: Option<[u32; 3]>,
    /// .raw: type of the values [default: f32]
    #[arg(long, value_enum)]
    pub r#type: Option<RawType>,
    /// .npy, .nrrd, .raw: edge of a voxel [default: the file's, or such that the longest side is 2]
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub voxel_size: Option<f32>,
    /// .npy, .nrrd, .raw: position of the first value [default: the file's, or such that the box is centered]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point)]
    pub origin: Option<[f32; 3]>,
}

#[derive(Args)]
pub(crate) struct Compare {
    /// The reference, a PNG image
    pub a: PathBuf,
    /// A PNG image of the same size
    pub b: PathBuf,
    /// Write FLIP's map of visible differences, from black to white
    #[arg(long, value_name = "PNG")]
    pub flip: Option<PathBuf>,
    /// Write the difference of the images' Laplacians
    #[arg(long, value_name = "PNG")]
    pub laplacian: Option<PathBuf>,
    /// FLIP: pixels per degree of the viewer's field of view. The default is a screen 3840 pixels and 0.7 m wide, 0.7 m away
    #[arg(long, value_name = "N", default_value_t = argil_metrics::flip::PIXELS_PER_DEGREE, value_parser = pixels_per_degree)]
    pub pixels_per_degree: f32,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct Info {
    /// A scene, volume or mesh file
    pub scene: PathBuf,
    /// Load meshes from outside the scene's folder
    #[arg(long, alias = "allow-outside")]
    pub allow_external_meshes: bool,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments for another program of Argil.
#[derive(Args)]
#[command(disable_help_flag = true)]
pub(crate) struct Companion {
    /// Arguments of the program; `--help` lists them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<std::ffi::OsString>,
}

#[derive(Args)]
pub(crate) struct Devices {
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}
