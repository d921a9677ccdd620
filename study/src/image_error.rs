//! Images, and their errors against the field's.

use crate::configuration::ConfigurationKind;
use crate::experiment::StudyCase;
use crate::outcome::Outcome;
use crate::plan::Plan;
use crate::scenes::scene;
use crate::task::Look;
use crate::views::{camera, exact_settings, settings};
use anyhow::Context;
use argil::{RenderedImage, World};
use argil_metrics::{Rgb8Image, depth, flip, laplacian, psnr, ssim};
use image::RgbImage;

fn image(drawn: RenderedImage) -> anyhow::Result<RgbImage> {
    let [width, height] = drawn.size;
    RgbImage::from_raw(width, height, drawn.rgb)
        .context("the image data does not match the image size")
}

/// Converts an image for metrics and for storage.
fn measured(image: &RgbImage) -> anyhow::Result<Rgb8Image> {
    let measured = Rgb8Image::new(image.dimensions().into(), image.as_raw().clone());
    measured.context("the image data does not match the image size")
}

fn kept(image: &Rgb8Image) -> anyhow::Result<RgbImage> {
    let [width, height] = image.size();
    RgbImage::from_raw(width, height, image.rgb().to_vec())
        .context("the image data does not match the image size")
}

/// Stores an image, its statistics and its error.
///
/// # Errors
/// If the device fails.
pub(crate) fn picture(
    (world, drawn): (&World, RenderedImage),
    case: &StudyCase,
    plan: &Plan,
    look: Look,
    out: &mut Outcome,
) -> anyhow::Result<()> {
    let (camera, settings) = (
        camera(world, look.eye),
        settings(world, plan, (&case.way, &look)),
    );
    out.set("hit_pixels", drawn.hit_pixels as f64);
    let statistics = drawn.statistics.context("nothing was counted")?;
    for (name, spread) in [
        ("steps", statistics.steps),
        ("descents", statistics.descents),
    ] {
        out.set(&format!("{name}_mean"), spread.mean);
        out.set(&format!("{name}_p95"), spread.p95);
        out.set(&format!("{name}_max"), spread.max);
    }
    out.about(world)?;
    let drawn_image = image(drawn)?;
    let seen_own = measured(&drawn_image)?;
    if look.is_compared && case.way.kind != ConfigurationKind::Field {
        // The reference is the field, rendered by the same device.
        let scene = scene(&case.scene)?;
        let reference = world.engine().build(&scene)?.field();
        let exact = exact_settings(&reference, plan, &look);
        let right = measured(&image(reference.render(&camera, &exact)?)?)?;
        out.set("psnr_db", psnr(&right, &seen_own)?.min(200.0));
        out.set("ssim", ssim(&right, &seen_own)?);
        let seen = flip::flip(&right, &seen_own, flip::PIXELS_PER_DEGREE)?;
        out.set("flip_mean", seen.mean());
        let edges = laplacian::difference(&right, &seen_own)?;
        out.set("laplacian_equal_pixels", edges.equal_pixels as f64);
        out.set("laplacian_mean_abs", edges.mean_abs);
        let histogram = edges.histogram.iter().map(|&n| n as f64).collect();
        out.samples.insert("laplacian_histogram".into(), histogram);
        let depths = depth::compare(
            &reference.ray_distances(&camera, &exact)?,
            &world.ray_distances(&camera, &settings)?,
        );
        let radius = f64::from(world.view_bounds().half_diagonal());
        out.spread("depth", &depths.both, radius);
        out.set("missed_pixels", depths.missed as f64);
        out.set("added_pixels", depths.added as f64);
        let edges = kept(&edges.picture)?;
        out.pictures.push(("laplacian".into(), edges));
    }
    if look.is_compared && case.way.kind == ConfigurationKind::Field {
        // The study's figure 29: the difference from a blank image.
        let edges = laplacian::laplacian(&seen_own);
        let equal = edges.pixels().iter().filter(|p| **p == [0; 3]).count();
        out.set("laplacian_equal_pixels", equal as f64);
        out.pictures.push(("laplacian".into(), kept(&edges)?));
    }
    out.pictures.push(("picture".into(), drawn_image));
    Ok(())
}
