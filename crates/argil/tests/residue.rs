//! Specks: what a median of 7 × 7 pixels removes inside of smooth surfaces.

use argil::prelude::*;
use glam::Vec3;

type Outcome = Result<(), Box<dyn std::error::Error>>;

const SIZE: [u32; 2] = [480, 270];
/// How far the window of a median reaches.
const REACH: i32 = 3;

/// The pixels around one, or `None` where some are beyond the image.
fn around([x, y]: [i32; 2]) -> Option<Vec<usize>> {
    let [width, height] = SIZE.map(|side| side as i32);
    let fits = |at: i32, side: i32| at >= REACH && at < side - REACH;
    (fits(x, width) && fits(y, height)).then(|| {
        let rows = y - REACH..=y + REACH;
        let places = rows.flat_map(|y| (x - REACH..=x + REACH).map(move |x| y * width + x));
        places.map(|place| place as usize).collect()
    })
}

/// The windows in which an image of normals shows one smooth surface, with their middles.
fn smooth_windows(normals: &[u8]) -> Vec<(usize, Vec<usize>)> {
    let normal = |at: usize| {
        let [x, y, z] = [0, 1, 2].map(|k| f32::from(normals[3 * at + k]) / 127.5 - 1.0);
        Vec3::new(x, y, z)
    };
    let [width, height] = SIZE.map(|side| side as i32);
    let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let windows = places.filter_map(|place| {
        let window = around(place)?;
        let pixel = (place[1] * width + place[0]) as usize;
        let is_surface = |at: usize| (normal(at).length() - 1.0).abs() < 0.1;
        let is_smooth = |&at: &usize| is_surface(at) && normal(at).dot(normal(pixel)) > 0.97;
        window.iter().all(is_smooth).then_some((pixel, window))
    });
    windows.collect()
}

/// What a median removes at a pixel, of the color that changes most.
fn residue(rgb: &[u8], pixel: usize, window: &[usize]) -> u8 {
    let channel = |k: usize| {
        let mut all: Vec<u8> = window.iter().map(|&at| rgb[3 * at + k]).collect();
        let middle = all.len() / 2;
        rgb[3 * pixel + k].abs_diff(*all.select_nth_unstable(middle).1)
    };
    [0, 1, 2].map(channel).into_iter().max().unwrap_or_default()
}

/// A residue that is seen.
const SPECK: u8 = 24;

/// The mean residue of an image, the residue that one of a thousand pixels exceeds, and the number of specks.
fn residues(rgb: &[u8], windows: &[(usize, Vec<usize>)]) -> [f64; 3] {
    let all = windows
        .iter()
        .map(|(pixel, window)| residue(rgb, *pixel, window));
    let mut all: Vec<u8> = all.collect();
    all.sort_unstable();
    let sum: u64 = all.iter().map(|&value| u64::from(value)).sum();
    let rare = all[all.len() * 999 / 1000];
    let specks = all.iter().filter(|&&value| value > SPECK).count();
    [
        sum as f64 / all.len() as f64,
        f64::from(rare),
        specks as f64,
    ]
}

/// Images through volumes have no more specks than those of the exact field. Shadows and materials have edges in all of them.
#[test]
fn volumes_have_no_more_specks_than_the_field() -> Outcome {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    for name in ["csg20", "melting", "morph", "trees", "teapot"] {
        let scene = Scene::open(format!("{folder}/{name}.json"))?;
        let world = Engine::cpu().build(&scene)?.field();
        let camera = world.camera();
        let drawn = |world: &World, mode| {
            let settings = world.render_settings(SIZE, mode);
            world.render(&camera, &settings).map(|image| image.rgb)
        };
        let windows = smooth_windows(&drawn(&world, RenderMode::Normal)?);
        assert!(windows.len() > 500, "{name}: {}", windows.len());
        let [mean, rare, specks] = residues(&drawn(&world, RenderMode::Shaded)?, &windows);
        let resolution = 256;
        for representation in [
            BricksOptions::from(resolution).into(),
            Representation::Levels(LevelsOptions::from(resolution)),
        ] {
            let mut world = Engine::cpu()
                .build(&scene)?
                .with_representation(representation)?;
            let settings = world.render_settings(SIZE, RenderMode::Shaded);
            world.refine(&camera, &settings)?;
            let found = residues(&drawn(&world, RenderMode::Shaded)?, &windows);
            let is_near = found[0] <= 1.15 * mean + 0.2
                && found[1] <= 1.15 * rare + 4.0
                && found[2] <= 1.25 * specks + 6.0;
            assert!(
                is_near,
                "{name}, {representation:?}: {found:?} for {mean}, {rare}, {specks}"
            );
        }
    }
    Ok(())
}
