//! The command line.

use argil::gpu::{BrickOrdering, DenseFill};
use argil::mesh::UpAxis;
use argil::render::{LookupStart, NormalSource, RenderMode};
use argil::scene::CameraPose;
use argil::volume::{BrickTest, SampleFormat};
use argil::{Backend, MeshMethod, MeshNormals, Representation};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Malleable environments made of signed distance fields.
#[derive(Parser)]
#[command(name = "argil", version, about, max_term_width = 100)]
pub(crate) struct CommandLine {
    #[command(subcommand)]
    pub command: CliCommand,
}

#[derive(Subcommand)]
pub(crate) enum CliCommand {
    /// Draw one picture, or with --frames an orbit or what moves, timed
    Render(RenderArgs),
    /// Build a volume from a scene's field, timed; with -o, write it
    Bake(BakeArgs),
    /// Turn a scene or a volume into triangles; with -o, write them as GLB, OBJ, PLY or STL
    Mesh(MeshArgs),
    /// Replay edits on a built volume, timed one by one
    Edit(EditArgs),
    /// Bring back a scene whose edits were journalled, after a crash
    Recover(Recover),
    /// Make a scene of a triangle mesh, or of a file in the tree format of "Lipschitz Pruning" (Barbier et al. 2025)
    Import(Import),
    /// Say how far two pictures are apart: PSNR, SSIM, FLIP, and the 2023 study's difference of Laplacians
    Compare(Compare),
    /// Say what is in a scene or a volume
    Info(Info),
    /// Measure all that the 2023 study did and more, and write a report; goes on where it was interrupted
    Study(Companion),
    /// Open the editor
    Studio(Companion),
    /// List what this machine can run on, and what --device auto takes
    Devices(Devices),
    /// Print the JSON schema of scene files
    Schema,
}

#[derive(Args)]
pub(crate) struct RenderArgs {
    /// A scene file, or a volume file that `argil bake` has written
    pub scene: PathBuf,
    /// Where the picture goes; without it the scene's name with .png, in this folder. With --frames, a number is added
    #[arg(short, long, value_name = "PNG")]
    pub output: Option<PathBuf>,
    /// What is marched; without it the field of a scene, and of a volume file what is in it
    #[arg(long, value_enum)]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = RenderMode::Shaded)]
    pub show: RenderMode,
    /// Camera on an orbit: degrees, degrees, multiples of the scene's radius; without it, the scene's own
    #[arg(long, value_name = "AZIMUTH,ELEVATION,DISTANCE", value_parser = orbit, allow_hyphen_values = true)]
    pub camera: Option<CameraPose>,
    /// The second at which what moves stands; without it 0, and with --frames the frames show it moving
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<f32>,
    /// Draw N frames and time each: an orbit, or where something has keyframes and no --time is given, what moves, from its
    /// beginning to its end. Frames are written only where -o is given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: Option<u32>,
    /// Rays a pixel; without it 4 for shaded pictures, else 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: Option<u32>,
    /// Most steps of a primary ray; without it 256 through the field, 4096 through a volume, where a look-up in a tree is
    /// not cut short and a software GPU stops at 50000
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub max_steps: Option<u32>,
    /// The distance below which a ray has hit, in the scene's unit; without it 1e-4 of its radius, or 0.02 voxels
    #[arg(long, value_name = "LENGTH")]
    pub epsilon: Option<f32>,
    /// Half of the normal's central difference, in the scene's unit; without it 5e-4 of its radius, or a voxel
    #[arg(long, value_name = "LENGTH")]
    pub normal_bias: Option<f32>,
    /// Bricks: where normals come from; without it smooth
    #[arg(long, value_enum)]
    pub normals: Option<NormalSource>,
    /// Lay a ground plane under the scene
    #[arg(long, overrides_with = "no_ground")]
    pub ground: bool,
    /// Leave out the scene's own ground plane
    #[arg(long)]
    pub no_ground: bool,
    /// Compile the scene into the shader (GPU only): the ground truth for timings
    #[arg(long)]
    pub specialize: bool,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// How a volume is built, and how an octree is marched.
#[derive(Args, Clone, Default, PartialEq)]
pub(crate) struct VolumeArgs {
    /// Voxels along the longest side of the scene's box; without it 256
    #[arg(long, value_name = "N")]
    pub resolution: Option<u32>,
    /// Bricks, and meshes of the field: the edge of a voxel in the scene's unit, in place of --resolution
    #[arg(long, alias = "voxel", value_name = "LENGTH", value_parser = positive, conflicts_with = "resolution")]
    pub voxel_size: Option<f32>,
    /// Dense: with mips, whose band doubles level by level
    #[arg(long)]
    pub mips: bool,
    /// Bits of a stored distance, 8 or 16; without it 16 for bricks, else 8
    #[arg(long, value_name = "8|16", value_parser = bits)]
    pub bits: Option<SampleFormat>,
    /// A stored 1.0 stands for so many voxels; without it 16 for bricks of 16 bits, else 4
    #[arg(long, value_name = "VOXELS", conflicts_with = "stride")]
    pub band: Option<f32>,
    /// A stored 1.0 stands for 256/N voxels: the 2023 study's texture stride, from 1 to 32
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=32))]
    pub stride: Option<u32>,
    /// Voxels along a brick's side: bricks 4, 8 or 16, without it 8; octree 8, 16 or 32, without it 32
    #[arg(long, value_name = "N")]
    pub brick: Option<u32>,
    /// Bricks: most memory that they may take, in MiB; without it what is free
    #[arg(long, value_name = "MIB")]
    pub memory_budget: Option<u32>,
    /// Octree: levels of nodes; without it as many as are needed
    #[arg(long, value_name = "N")]
    pub depth: Option<u32>,
    /// Octree: which bricks are kept; without it all in which the surface can be
    #[arg(long, value_enum)]
    pub keep: Option<BrickTest>,
    /// Octree: where a ray's look-ups begin; without it at the root
    #[arg(long, value_enum)]
    pub descent: Option<LookupStart>,
    /// Octree on a GPU: how bricks get into order; without it by counting
    #[arg(long, value_enum)]
    pub sort: Option<BrickOrdering>,
    /// Mesh: how triangles are found; without it mc
    #[arg(long, value_enum)]
    pub method: Option<MeshMethod>,
    /// Mesh: draw each triangle with its own normal, as the 2023 study did
    #[arg(long)]
    pub flat: bool,
    /// Dense on a GPU: how the texture is filled; without it by tiles
    #[arg(long, value_enum)]
    pub fill: Option<DenseFill>,
}

#[derive(Args)]
pub(crate) struct BakeArgs {
    /// A scene file, or a volume file whose scene is built anew
    pub scene: PathBuf,
    /// Where the volume goes; without it, it is timed and dropped
    #[arg(short, long, value_name = "VOLUME")]
    pub output: Option<PathBuf>,
    /// What is built; without it sparse bricks, or a dense volume where --mips or --fill is given
    #[arg(long, value_enum)]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// The second at which what moves stands; without it 0
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<f32>,
    /// Build N times and time each
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: u32,
    /// Octree: also count the bricks that are lost, which the conservative test would keep
    #[arg(long)]
    pub count_lost: bool,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct MeshArgs {
    /// A scene file, or a volume file that `argil bake` has written
    pub scene: PathBuf,
    /// Where the triangles go: .glb, .obj, .ply or .stl; without it they are counted, timed and dropped
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// What is meshed: field, dense or bricks; without it the field of a scene, and of a volume file what is in it
    #[arg(long, value_enum)]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// The distance from the solid at which the surface is taken, in the scene's unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub iso: f32,
    /// Leave out triangles until there are N, or as few as keep the surface closed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..))]
    pub triangles: Option<u32>,
    /// Write N coarser meshes besides, each of a quarter of the triangles of the one before, as NAME-1.glb and so on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16), requires = "output")]
    pub lods: Option<u32>,
    /// Where normals come from
    #[arg(long, value_enum, default_value_t = MeshNormals::Field)]
    pub normals: MeshNormals,
    /// Give each triangle corners of its own, as the 2023 study did
    #[arg(long)]
    pub unshared: bool,
    /// Which way is up in the file, and which hand its axes are; without it y-up, which .glb always is
    #[arg(long, value_enum)]
    pub axes: Option<UpAxis>,
    /// The file's unit, where the scene's is a meter; without it meters, which .glb always is in
    #[arg(long, value_enum)]
    pub unit: Option<MeshUnit>,
    /// The second at which what moves stands; without it 0
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<f32>,
    /// Print one JSON object on stdout and nothing else there
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
    /// The edits, one JSON object a line: insert, remove, replace, move, set_visible, transform, set_material, undo, redo,
    /// begin_stroke and end_stroke, as the README shows
    #[arg(long, value_name = "FILE")]
    pub edits: PathBuf,
    /// Where the edited volume goes
    #[arg(short, long, value_name = "VOLUME")]
    pub output: Option<PathBuf>,
    /// Where the edited scene goes
    #[arg(long, value_name = "SCENE")]
    pub scene_output: Option<PathBuf>,
    /// Record each edit there when it is done, for `argil recover` after a crash; removed once --scene-output is written
    #[arg(long, value_name = "JOURNAL")]
    pub journal: Option<PathBuf>,
    /// What a scene is baked to; without it bricks, which are edited in place. Others are made again after each edit
    #[arg(long, value_enum)]
    pub via: Option<Representation>,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub on: DeviceArgs,
    /// Compare the bricks at the end with a fresh bake: fails if a cell differs
    #[arg(long)]
    pub check: bool,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct Recover {
    /// What `argil edit --journal` has left
    pub journal: PathBuf,
    /// Where the scene goes
    #[arg(short, long, value_name = "SCENE")]
    pub output: PathBuf,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Where to run.
#[derive(Args)]
pub(crate) struct DeviceArgs {
    /// auto takes a hardware GPU where there is one, else the CPU
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub device: Backend,
    /// Load meshes that a scene names from outside of its folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Threads of the CPU path; without it, all cores
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

#[derive(Args)]
pub(crate) struct Import {
    /// A tree file, a mesh: .obj, .glb, .ply or .stl, or a heightmap: .png
    pub file: PathBuf,
    /// Where the scene goes
    #[arg(short, long, value_name = "SCENE")]
    pub output: PathBuf,
    /// Mesh: samples along the longest side of its box, from 16 to 512; without it 128
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=512))]
    pub resolution: Option<u32>,
    /// Mesh: parts with open edges become walls of this thickness, instead of being closed; the result is written beside the
    /// scene, as <SCENE>-thick.ply
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub thickness: Option<f32>,
    /// Mesh: let the scene name a file outside of its folder; whatever reads the scene then needs this flag too
    #[arg(long)]
    pub allow_outside: bool,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct Compare {
    /// A PNG picture, the reference
    pub a: PathBuf,
    /// One of the same size
    pub b: PathBuf,
    /// Write FLIP's map of the differences that a viewer sees, from black to white
    #[arg(long, value_name = "PNG")]
    pub flip: Option<PathBuf>,
    /// Write the difference of the pictures' Laplacians
    #[arg(long, value_name = "PNG")]
    pub laplacian: Option<PathBuf>,
    /// How close FLIP's viewer is; without it a screen of 3840 pixels, 0.7 m wide, seen from 0.7 m
    #[arg(long, value_name = "N", default_value_t = argil_metrics::flip::PIXELS_PER_DEGREE, value_parser = pixels_per_degree)]
    pub pixels_per_degree: f32,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct Info {
    /// A scene, volume or mesh file
    pub scene: PathBuf,
    /// Load meshes that a scene names from outside of its folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// What another program of Argil is given.
#[derive(Args)]
#[command(disable_help_flag = true)]
pub(crate) struct Companion {
    /// Its arguments; `--help` lists them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<std::ffi::OsString>,
}

#[derive(Args)]
pub(crate) struct Devices {
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

fn bits(text: &str) -> Result<SampleFormat, String> {
    match text {
        "8" => Ok(SampleFormat::Snorm8),
        "16" => Ok(SampleFormat::Snorm16),
        _ => Err("a stored distance takes 8 or 16 bits".into()),
    }
}

fn positive(text: &str) -> Result<f32, String> {
    let fits = |n: &f32| *n > 0.0 && n.is_finite();
    let number = text.parse().ok().filter(fits);
    number.ok_or_else(|| "expected a length above 0".into())
}

fn pixels_per_degree(text: &str) -> Result<f32, String> {
    let fits = |n: &f32| (4.0..=400.0).contains(n);
    let number = text.parse().ok().filter(fits);
    number.ok_or_else(|| "expected pixels a degree, from 4 to 400".into())
}

fn seconds(text: &str) -> Result<f32, String> {
    let seconds = text.parse().ok();
    let fits = |s: &f32| (0.0..=86_400.0).contains(s);
    seconds
        .filter(fits)
        .ok_or_else(|| "expected seconds, from 0 to 86400".into())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(sides) if sides.iter().all(|s| (1..=16_384).contains(s)) => Ok(sides),
        Some(_) => Err("both sides must be from 1 to 16384".into()),
        None => Err("expected WIDTHxHEIGHT in pixels, such as 1280x720".into()),
    }
}

fn orbit(text: &str) -> Result<CameraPose, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(str::trim)
        .map(str::parse)
        .collect::<Result<_, _>>()
        .unwrap_or_default();
    let Ok(orbit) = <[f32; 3]>::try_from(numbers) else {
        return Err("expected AZIMUTH,ELEVATION,DISTANCE, such as 30,20,3".into());
    };
    let placement = CameraPose::Orbit(orbit);
    placement.check().map_err(|fault| fault.reason)?;
    Ok(placement)
}
