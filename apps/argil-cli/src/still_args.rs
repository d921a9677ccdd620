//! Flags of stills.

use crate::arg_values::{light, seconds};
use clap::{Args, ValueEnum};

/// How light is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Integrator {
    /// From the sun and the sky to each surface, in one step
    #[default]
    Direct,
    /// Along paths that surfaces reflect again and again
    Path,
}

/// Rays per pixel, and path tracing.
#[derive(Args)]
pub(crate) struct StillArgs {
    /// How light is found: path traces a still, through the field, bricks or a dense volume. Ctrl-C writes what is there
    #[arg(long, value_enum, default_value_t = Integrator::Direct)]
    pub integrator: Integrator,
    /// Rays per pixel, at most 64, or paths, at most 1048576 [default: 4 for shaded images, 64 paths, else 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_048_576))]
    pub samples: Option<u32>,
    /// Paths: stop this long after the command began. On a GPU, when each pixel has a path
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub time_limit: Option<f32>,
    /// Paths: remove noise, by surfaces' normals, distances and colors
    #[arg(long)]
    pub denoise: bool,
    /// Paths: leave out what is behind everything
    #[arg(long)]
    pub transparent: bool,
    /// Paths: the most light that a path may bring after its first surface. Removes bright dots, and light with them [default: none]
    #[arg(long, value_name = "LIGHT", allow_negative_numbers = true, value_parser = light)]
    pub firefly_clamp: Option<f32>,
}
