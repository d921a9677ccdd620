//! Compares normals of bricks with the exact field's.

use argil_abi::{HIT_NONE, Hit};
use argil_conformance::Wait;
use argil_conformance::{gpu, primary_ray, shipped, voxel_grid};
use argil_field::Program;
use argil_gpu::{GpuProgram, GpuVolume, ImageOutput};
use argil_math::Aabb;
use argil_render::{
    Camera, NormalSource, RenderMode, RenderSettings, frame_uniforms, render_with_hits,
};
use argil_volume::{BrickLayout, BrickSettings, Bricks, Encoding};
use glam::Vec3;

/// Returns the angles in degrees between an image's normals and the field's at the same points, ascending, away
/// from silhouettes and creases.
fn errors(program: &Program, frame: &argil_abi::FrameUniform, hits: &[Hit], bias: f32) -> Vec<f32> {
    let (width, height) = (frame.width, frame.height);
    let mut all = Vec::new();
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let at = |x: u32, y: u32| &hits[(y * width + x) as usize];
            let hit = at(x, y);
            let around = [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)];
            let t = hit.normal_t[3];
            if hit.kind == HIT_NONE
                || around
                    .iter()
                    .any(|h| h.kind == HIT_NONE || (h.normal_t[3] - t).abs() > 0.02 * t)
            {
                continue;
            }
            let ray = primary_ray(frame, x, y);
            let p = ray.at(t);
            let n = Vec3::new(hit.normal_t[0], hit.normal_t[1], hit.normal_t[2]);
            let of =
                |axis: Vec3| program.distance(p + axis * bias) - program.distance(p - axis * bias);
            let exact = Vec3::new(of(Vec3::X), of(Vec3::Y), of(Vec3::Z)).normalize_or_zero();
            if exact.dot(-ray.direction) < 0.2 {
                continue;
            }
            all.push(n.angle_between(exact).to_degrees());
        }
    }
    all.sort_by(f32::total_cmp);
    all
}

#[test]
fn normals_equal_the_fields() {
    for case in shipped()
        .iter()
        .filter(|c| ["csg20", "teapot"].contains(&c.name.as_str()))
    {
        let program = Program::lower(&case.scene).expect("a program");
        let voxel_grid = voxel_grid(&case.scene, &program, 512);
        let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
        let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
        let held = program.aabb().intersection(voxel_grid.aabb());
        let camera = Camera::orbit(held, [30.0, 20.0, 2.4], 40.0);
        for normals in [
            NormalSource::Voxel,
            NormalSource::Smooth,
            NormalSource::Field,
        ] {
            let settings = RenderSettings {
                size: [320, 240],
                mode: RenderMode::Normal,
                normals,
                max_steps: 4096,
                ..RenderSettings::default()
            };
            let frames = frame_uniforms(&settings, &camera, &program, Some(&voxel_grid), held);
            let hits = render_with_hits(&program, &bricks, &frames).hits;
            let all = errors(
                &program,
                &frames[0],
                &hits,
                1e-4 * Aabb::half_diagonal(held),
            );
            let mean = all.iter().sum::<f32>() / all.len() as f32;
            let at = |share: usize| all[all.len() * share / 100];
            println!(
                "{} {normals:?}: {} pixels, mean {mean:.3} degrees, 50 of 100 within {:.3}, 95 {:.3}, 99 {:.3}",
                case.name,
                all.len(),
                at(50),
                at(95),
                at(99)
            );
            assert!(all.len() > 10_000);
            if normals == NormalSource::Voxel {
                // Negative control: gradients that jump from voxel to voxel are told apart.
                assert!(mean > 0.2 && at(99) > 3.0, "{mean}, {}", at(99));
            } else {
                assert!(
                    mean <= 0.5 && at(99) <= 3.0,
                    "{}: {mean}, {}",
                    case.name,
                    at(99)
                );
            }
        }
    }
}

/// If half of a pixel is wider than the stored band, a ray still ends where its normal has samples: 8 bits, ±4
/// voxels, and an image so small that a pixel spans 13 voxels.
#[test]
fn a_small_picture_of_a_narrow_band_has_normals() {
    let case = shipped().into_iter().find(|c| c.name == "csg20");
    let case = case.expect("a scene that ships");
    let program = Program::lower(&case.scene).expect("a program");
    let voxel_grid = voxel_grid(&case.scene, &program, 512);
    let settings = BrickSettings {
        encoding: Encoding::default(),
        ..BrickSettings::default()
    };
    let layout = BrickLayout::new(voxel_grid, &settings).expect("a layout");
    let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
    let held = program.aabb().intersection(voxel_grid.aabb());
    let camera = Camera::orbit(held, [30.0, 20.0, 2.4], 40.0);
    let settings = RenderSettings {
        size: [64, 48],
        mode: RenderMode::Normal,
        max_steps: 4096,
        ..RenderSettings::default()
    };
    let frames = frame_uniforms(&settings, &camera, &program, Some(&voxel_grid), held);
    let pixel_voxels =
        frames[0].pixel_width * camera.eye.distance(held.center()) / voxel_grid.voxel_size;
    assert!(pixel_voxels > 9.0, "{pixel_voxels}");
    let cpu = render_with_hits(&program, &bricks, &frames).hits;
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let on_gpu = GpuVolume::upload(&field, &bricks.into())
        .wait()
        .expect("a volume");
    let gpu = on_gpu
        .render(&field, &frames, ImageOutput::CpuWithHits)
        .wait()
        .expect("a picture")
        .0
        .hits;
    for (device, hits) in [("cpu", cpu), ("gpu", gpu)] {
        let bias = 1e-4 * Aabb::half_diagonal(held);
        let all = errors(&program, &frames[0], &hits, bias);
        let mean = all.iter().sum::<f32>() / all.len() as f32;
        let far = all.iter().filter(|&&degrees| degrees > 20.0).count();
        println!(
            "{device}: {} pixels, mean {mean:.2} degrees, {far} off",
            all.len()
        );
        assert!(all.len() > 100 && mean < 2.0, "{device}: {mean}");
        assert!(far <= all.len() / 100, "{device}: {far}");
    }
}
