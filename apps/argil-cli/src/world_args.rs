//! The arguments of `argil world`.

use crate::arg_values::{bits, positive};
use argil::volume::SampleFormat;
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct WorldArgs {
    #[command(subcommand)]
    pub command: WorldCommand,
}

#[derive(Subcommand)]
pub(crate) enum WorldCommand {
    /// Describe what is to be baked: finds which tiles there can be, from bounds alone
    Plan(WorldPlanArgs),
    /// Bake the tiles of a plan, or a part of them, that a store lacks; can be stopped and begun again at any moment
    Bake(WorldBake),
    /// Count what a store has of a plan
    Status(WorldStatus),
    /// Write the manifest, if nothing is missing; can be called again
    Finish(WorldFinish),
    /// Save edits beside a finished world, whose tiles stay as they are
    Edit(WorldEdit),
    /// Write a finished world for other programs: as 3D Tiles 1.1, or as an OME-Zarr folder
    Export(WorldExport),
}

/// What all commands that evaluate the scene share.
#[derive(Args)]
pub(crate) struct WorldRun {
    /// Load meshes from outside the folder of the scene or the plan
    #[arg(long)]
    pub allow_external_meshes: bool,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct WorldPlanArgs {
    /// A scene file
    pub scene: PathBuf,
    /// Edge of a voxel of the finest level in the scene's unit
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = positive)]
    pub voxel_size: f32,
    /// Bits per stored distance, 8 or 16 [default: 16]
    #[arg(long, value_name = "8|16", value_parser = bits)]
    pub bits: Option<SampleFormat>,
    /// The plan [default: the scene's name with .world.json, in this folder]
    #[arg(short, long, value_name = "PLAN")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub how: WorldRun,
}

/// What all commands on a plan share.
#[derive(Args)]
pub(crate) struct OnPlan {
    /// A plan from `argil world plan`
    pub plan: PathBuf,
    /// A folder, or s3://, gs:// or az://; credentials come from the environment
    #[arg(long, value_name = "ADDRESS")]
    pub store: String,
    #[command(flatten)]
    pub how: WorldRun,
}

#[derive(Args)]
pub(crate) struct WorldBake {
    #[command(flatten)]
    pub on: OnPlan,
    /// Bake every COUNT-th tile, from the INDEX-th on [default: from the variables of Slurm, Kubernetes, AWS Batch or Cloud Run,
    /// else all]
    #[arg(long, value_name = "INDEX/COUNT")]
    pub shard: Option<argil_world::Shard>,
    /// Number of jobs, where the environment tells only the job's own number
    #[arg(long, value_name = "N", conflicts_with = "shard", value_parser = clap::value_parser!(u64).range(1..))]
    pub shards: Option<u64>,
}

#[derive(Args)]
pub(crate) struct WorldStatus {
    #[command(flatten)]
    pub on: OnPlan,
    /// Read all tiles, and tell which are damaged
    #[arg(long)]
    pub verify: bool,
}

#[derive(Args)]
pub(crate) struct WorldFinish {
    #[command(flatten)]
    pub on: OnPlan,
    /// Read all tiles first, and remove those that are damaged, so that they are baked again
    #[arg(long)]
    pub verify: bool,
}

#[derive(Args)]
pub(crate) struct WorldEdit {
    /// A finished world: its folder, manifest.json or address
    pub world: String,
    /// The edits, one JSON object per line, as `argil edit` reads them
    #[arg(long, value_name = "FILE")]
    pub edits: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct WorldExport {
    /// A finished world: its folder, manifest.json or address
    pub world: String,
    /// The new folder: NAME.zarr for OME-Zarr, else 3D Tiles
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Edge of a voxel of the finest level that is wanted, in the scene's unit [default: the world's finest]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = positive)]
    pub voxel_size: Option<f32>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}
