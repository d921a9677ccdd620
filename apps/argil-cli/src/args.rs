//! The command line.

use argil::Placement;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Malleable environments made of signed distance fields.
#[derive(Parser)]
#[command(name = "argil", version, about, max_term_width = 100)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Draw one picture, or with --frames an orbit that is timed
    Render(Render),
    /// Read a scene in the tree format of "Lipschitz Pruning" (Barbier et al. 2025) and write it as a scene
    Import(Import),
    /// Say what is in a scene
    Info(Info),
    /// List what this machine can run on, and what --device auto takes
    Devices(Devices),
    /// Print the JSON schema of scene files
    Schema,
}

#[derive(Args)]
pub struct Render {
    /// A scene file
    pub scene: PathBuf,
    /// Where the picture goes; without it the scene's name with .png, in this folder. With --frames, a number is added
    #[arg(short, long, value_name = "PNG")]
    pub output: Option<PathBuf>,
    /// What is marched
    #[arg(long, value_enum, default_value_t = Via::Field)]
    pub via: Via,
    #[command(flatten)]
    pub on: On,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = Show::Shaded)]
    pub show: Show,
    /// Camera on an orbit: degrees, degrees, multiples of the scene's radius; without it, the scene's own
    #[arg(long, value_name = "AZIMUTH,ELEVATION,DISTANCE", value_parser = orbit, allow_hyphen_values = true)]
    pub camera: Option<Placement>,
    /// Draw an orbit of N frames and time each; frames are written only where -o is given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: Option<u32>,
    /// Rays a pixel; without it 4 for shaded pictures, else 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: Option<u32>,
    /// Most steps of a primary ray
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub max_steps: u32,
    /// The distance below which a ray has hit, in the scene's unit; without it 1e-4 of its radius
    #[arg(long, value_name = "LENGTH")]
    pub epsilon: Option<f32>,
    /// Half of the normal's central difference, in the scene's unit; without it 5e-4 of its radius
    #[arg(long, value_name = "LENGTH")]
    pub normal_bias: Option<f32>,
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

/// Where to run.
#[derive(Args)]
pub struct On {
    /// auto takes a hardware GPU where there is one, else the CPU
    #[arg(long, value_enum, default_value_t = Device::Auto)]
    pub device: Device,
    /// Threads of the CPU path; without it, all cores
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

#[derive(Args)]
pub struct Import {
    /// A tree file
    pub tree: PathBuf,
    /// Where the scene goes
    #[arg(short, long, value_name = "SCENE")]
    pub output: PathBuf,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub struct Info {
    /// A scene file
    pub scene: PathBuf,
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub struct Devices {
    /// Print one JSON object on stdout and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Via {
    /// The exact field
    Field,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Device {
    Auto,
    Cpu,
    Gpu,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Show {
    /// Light on materials
    Shaded,
    /// Normals as colours
    Normal,
    /// Near white, far black
    Depth,
    /// Steps a ray: 0 to 256 as blue, green, yellow, red
    Heat,
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

fn orbit(text: &str) -> Result<Placement, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(str::trim)
        .map(str::parse)
        .collect::<Result<_, _>>()
        .unwrap_or_default();
    let Ok(orbit) = <[f32; 3]>::try_from(numbers) else {
        return Err("expected AZIMUTH,ELEVATION,DISTANCE, such as 30,20,3".into());
    };
    let placement = Placement::Orbit(orbit);
    placement.check().map_err(|fault| fault.reason)?;
    Ok(placement)
}
