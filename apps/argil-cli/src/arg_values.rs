//! Reads values of flags.

use argil::scene::CameraPose;
use argil::volume::SampleFormat;

pub(crate) fn bits(text: &str) -> Result<SampleFormat, String> {
    match text {
        "8" => Ok(SampleFormat::Snorm8),
        "16" => Ok(SampleFormat::Snorm16),
        _ => Err("expected 8 or 16".into()),
    }
}

pub(crate) fn brick_size(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(size @ (4 | 8 | 16 | 32)) => Ok(size),
        _ => Err("expected 4, 8, 16 or 32".into()),
    }
}

pub(crate) fn pixels(text: &str) -> Result<f32, String> {
    let fits = |n: &f32| (0.125..=1024.0).contains(n);
    let number = text.parse().ok().filter(fits);
    number.ok_or_else(|| "expected pixels, from 0.125 to 1024".into())
}

pub(crate) fn voxels(text: &str) -> Result<f32, String> {
    positive(text).map_err(|_| "expected a number of voxels above 0".into())
}

pub(crate) fn positive(text: &str) -> Result<f32, String> {
    let fits = |n: &f32| *n > 0.0 && n.is_finite();
    let number = text.parse().ok().filter(fits);
    number.ok_or_else(|| "expected a length above 0".into())
}

pub(crate) fn pixels_per_degree(text: &str) -> Result<f32, String> {
    let fits = |n: &f32| (4.0..=400.0).contains(n);
    let number = text.parse().ok().filter(fits);
    number.ok_or_else(|| "expected pixels per degree, from 4 to 400".into())
}

pub(crate) fn seconds(text: &str) -> Result<f32, String> {
    let seconds = text.parse().ok();
    let fits = |s: &f32| (0.0..=86_400.0).contains(s);
    seconds
        .filter(fits)
        .ok_or_else(|| "expected seconds, from 0 to 86400".into())
}

pub(crate) fn light(text: &str) -> Result<f32, String> {
    positive(text).map_err(|_| "expected an amount of light above 0".into())
}

pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(sides) if sides.iter().all(|s| (1..=16_384).contains(s)) => Ok(sides),
        Some(_) => Err("each side must be 1 to 16384".into()),
        None => Err("expected WIDTHxHEIGHT in pixels, such as 1280x720".into()),
    }
}

pub(crate) fn orbit(text: &str) -> Result<CameraPose, String> {
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

pub(crate) fn shape(text: &str) -> Result<[u32; 3], String> {
    three(text).ok_or_else(|| "expected X,Y,Z, such as 64,64,32".into())
}

pub(crate) fn point(text: &str) -> Result<[f32; 3], String> {
    let point = three::<f32>(text).filter(|point| point.iter().all(|c| c.is_finite()));
    point.ok_or_else(|| "expected X,Y,Z, such as 0,-1.5,2".into())
}

fn three<T: std::str::FromStr>(text: &str) -> Option<[T; 3]> {
    let numbers: Result<Vec<T>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    <[T; 3]>::try_from(numbers.ok()?).ok()
}
