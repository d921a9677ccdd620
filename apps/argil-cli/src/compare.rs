//! `argil compare`.

use crate::args::Compare;
use crate::output;
use anyhow::{Context, ensure};
use argil_metrics::flip::{FlipMap, flip};
use argil_metrics::{Rgb8Image, differing_pixels, laplacian, psnr, ssim};
use serde_json::json;
use std::path::Path;

pub(crate) fn run(options: &Compare) -> anyhow::Result<()> {
    for place in [&options.flip, &options.laplacian].into_iter().flatten() {
        for input in [&options.a, &options.b] {
            output::check_place(place, input)?;
        }
        let is_png = place
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"));
        ensure!(
            is_png,
            "{}: maps are PNG images; name it .png",
            place.display()
        );
    }
    let full = |place: &Option<std::path::PathBuf>| {
        place.as_deref().and_then(|p| std::path::absolute(p).ok())
    };
    ensure!(
        options.flip.is_none() || full(&options.flip) != full(&options.laplacian),
        "--flip, --laplacian: both maps would be written to one file"
    );
    let (a, b) = (picture(&options.a)?, picture(&options.b)?);
    let place = || format!("{} and {}", options.a.display(), options.b.display());
    let psnr = psnr(&a, &b).with_context(place)?;
    let ssim = ssim(&a, &b)?;
    let seen = flip(&a, &b, options.pixels_per_degree)?;
    let difference = laplacian::difference(&a, &b)?;
    let report = json!({
        "size": a.size(),
        // JSON has no infinity: the PSNR of equal images is null.
        "psnr_db": psnr.is_finite().then_some(psnr),
        "ssim": ssim,
        "flip_mean": seen.mean(),
        "differing_pixels": differing_pixels(&a, &b)?,
        "laplacian_equal_pixels": difference.equal_pixels,
        "laplacian_mean_abs": difference.mean_abs,
        "laplacian_histogram": difference.histogram.to_vec(),
    });
    if let Some(path) = &options.flip {
        save(path, &map(&seen))?;
    }
    if let Some(path) = &options.laplacian {
        save(path, &difference.picture)?;
    }
    if options.json {
        output::json(&report);
        return Ok(());
    }
    for key in [
        "size",
        "psnr_db",
        "ssim",
        "flip_mean",
        "differing_pixels",
        "laplacian_equal_pixels",
        "laplacian_mean_abs",
    ] {
        output::pair(key, &report[key]);
    }
    Ok(())
}

/// Reads an image as 8-bit sRGB.
fn picture(path: &Path) -> anyhow::Result<Rgb8Image> {
    let read = argil::read_png(path)?;
    if read.lost_precision {
        eprintln!(
            "warning: {}: only 8-bit red, green and blue are compared; alpha and extra bits are ignored",
            path.display()
        );
    }
    Rgb8Image::new(read.size, read.rgb)
        .with_context(|| format!("{}: the image has another size", path.display()))
}

fn save(path: &Path, map: &Rgb8Image) -> anyhow::Result<()> {
    Ok(argil::save_png(path, map.size(), map.rgb())?)
}

/// Converts a difference map to an image, from black through red and yellow to white.
fn map(seen: &FlipMap) -> Rgb8Image {
    let [width, height] = seen.size;
    Rgb8Image::of([width, height], |x, y| {
        let v = 3.0 * seen.values[(y * width + x) as usize].sqrt();
        let part = |from: f32| ((v - from).clamp(0.0, 1.0) * 255.0).round() as u8;
        [part(0.0), part(1.0), part(2.0)]
    })
}
