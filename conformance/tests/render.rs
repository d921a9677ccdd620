//! Compares rays and light: the GPU's buffers with the CPU's, and the CPU's rays with a search in tiny steps.
//!
//! *Length.* A test for each pass of an image, with the search that they are compared with.

use argil_abi::{FrameUniform, HIT_INSIDE, HIT_NONE, HIT_OUTSIDE, Hit};
use argil_conformance::Wait;
use argil_conformance::{CaseRng, SceneCase, all_cases, gpu, primary_ray, random_blends, shipped};
use argil_field::{Program, naive};
use argil_gpu::{Gpu, GpuProgram, ImageOutput};
use argil_math::Aabb;
use argil_render::{
    Camera, PrunedField, RenderMode, RenderOutput, RenderSettings, UnprunedField, frame_uniforms,
    render_with_hits,
};
use argil_scene::{Brush, Group, Material, Modifier, Scene, Shape};
use glam::Vec3;
use std::sync::Arc;

/// Returns a scene with thin rods, a blend, a subtraction, a twist and two materials.
fn scene() -> Scene {
    let mut scene = Scene::new();
    scene
        .set_material("red", Material::colored([0.7, 0.1, 0.1]))
        .expect("valid");
    scene
        .set_material(
            "gold",
            Material {
                metallic: 1.0,
                roughness: 0.3,
                ..Material::colored([0.8, 0.6, 0.2])
            },
        )
        .expect("valid");
    let mut push = |b: Brush| scene.push(b).expect("valid");
    push(Brush::new(Shape::sphere(0.5)).with_material("red"));
    push(
        Brush::new(Shape::cuboid([0.3, 0.3, 0.6]))
            .rotated([0.0, 1.0, 0.0], 30.0)
            .smooth(0.1)
            .with_material("gold"),
    );
    push(
        Brush::new(Shape::sphere(0.3))
            .at([0.0, 0.4, 0.2])
            .subtract()
            .smooth(0.05),
    );
    push(Brush::new(Shape::capsule(
        [-0.9, -0.6, 0.0],
        [0.9, 0.8, 0.1],
        0.004,
    )));
    push(
        Brush::new(Shape::rounded_box([0.1, 0.5, 0.1], 0.02))
            .with_modifier(Modifier::Twist {
                degrees_per_unit: 120.0,
            })
            .at([0.7, 0.0, -0.3]),
    );
    scene
}

const FOCUS: Aabb = Aabb::new(Vec3::splat(-1.0), Vec3::ONE);

fn look(settings: &RenderSettings, eye: Vec3, program: &Program) -> Vec<FrameUniform> {
    let camera = Camera {
        eye,
        target: Vec3::new(0.02, 0.01, 0.0),
        field_of_view_degrees: 45.0,
    };
    frame_uniforms(settings, &camera, program, None, FOCUS)
}

fn small(show: RenderMode) -> RenderSettings {
    RenderSettings {
        size: [72, 56],
        mode: show,
        ground: show == RenderMode::Shaded,
        samples: 2,
        ..RenderSettings::default()
    }
}

/// Compares two hit buffers: hits of different kinds, and the largest differences of length, normal and steps among
/// the others.
fn gap(a: &[Hit], b: &[Hit]) -> (usize, f32) {
    let mut other_kind = 0;
    let mut greatest = 0.0f32;
    for (a, b) in a.iter().zip(b) {
        if a.kind != b.kind || a.steps.abs_diff(b.steps) > 1 {
            other_kind += 1;
        } else {
            let gaps = a
                .normal_t
                .iter()
                .zip(&b.normal_t)
                .map(|(a, b)| (a - b).abs());
            greatest = gaps.fold(greatest, f32::max);
        }
    }
    (other_kind, greatest)
}

fn color_gap(a: &RenderOutput, b: &RenderOutput) -> (usize, u8) {
    let gaps = a.rgb.iter().zip(&b.rgb).map(|(a, b)| a.abs_diff(*b));
    gaps.fold((0, 0), |(count, most), gap| {
        (count + usize::from(gap > 2), most.max(gap))
    })
}

/// Bounded. At grazing rays rounding decides, so a few in a thousand may differ in kind. The others agree to the
/// rounding of a central difference. Colors differ by one step of 255, or two at the edge of a shadow.
#[test]
fn gpu_pictures_are_the_cpus() {
    let scene = scene();
    let program = Program::lower(&scene).expect("valid");
    let gpu = gpu();
    let as_hardware = Arc::new(Gpu::open().wait().expect("a device").as_hardware());
    for (gpu, specialized) in [(&gpu, false), (&gpu, true), (&as_hardware, false)] {
        let field = GpuProgram::new(gpu.clone(), &program, specialized).expect("a field");
        for (show, eye) in [
            (RenderMode::Shaded, Vec3::new(1.6, 1.2, 2.2)),
            (RenderMode::Normal, Vec3::new(-2.2, 0.3, 1.0)),
            (RenderMode::Depth, Vec3::new(0.1, 2.9, 0.4)),
            (RenderMode::Heat, Vec3::new(0.05, -0.1, 0.02)),
        ] {
            let frames = look(&small(show), eye, &program);
            let cpu = render_with_hits(&program, &UnprunedField, &frames);
            let (found, duration_ms) = field
                .render(&frames, ImageOutput::CpuWithHits)
                .wait()
                .expect("a picture");
            assert!(duration_ms > 0.0);
            let (other, greatest) = gap(&cpu.hits, &found.hits);
            assert!(
                other <= cpu.hits.len() / 500,
                "{show:?}: {other} hits of another kind"
            );
            // An H200 is 0.021 off: it fuses products and sums.
            assert!(greatest < 0.03, "{show:?}: {greatest}");
            let (differing, most) = color_gap(&cpu, &found);
            assert!(
                differing <= cpu.rgb.len() / 200,
                "{show:?}: {differing} channels differ, by up to {most}"
            );

            // Negative control: the camera moved by less than a pixel is another picture.
            let moved = look(&small(show), eye + Vec3::new(0.02, 0.0, 0.0), &program);
            let moved = render_with_hits(&program, &UnprunedField, &moved);
            assert!(gap(&cpu.hits, &moved.hits).1 > 1e-4);
            assert_ne!(cpu.rgb, moved.rgb);
        }
    }
}

/// Returns the first crossing of the surface, in steps much smaller than any feature.
fn first_crossing(scene: &Scene, origin: Vec3, direction: Vec3) -> Option<f32> {
    let sign = naive::distance(scene, origin).signum();
    let mut t = 0.0;
    while t < 6.0 {
        let d = naive::distance(scene, origin + direction * t) * sign;
        if d <= 0.0 {
            return Some(t);
        }
        t += (0.5 * d as f32).max(2e-4);
    }
    None
}

/// Silhouettes, thin rods, cameras inside a solid and grazing rays: rays find the same hits as a search.
#[test]
fn rays_equal_a_search() {
    let scene = scene();
    let program = Program::lower(&scene).expect("valid");
    let settings = RenderSettings {
        size: [64, 64],
        max_steps: 1024,
        ..RenderSettings::default()
    };
    let mut numbers = CaseRng::new(31);
    for (eye, kind) in [
        (Vec3::new(2.0, 0.9, 1.4), HIT_OUTSIDE),
        (Vec3::new(0.0, 0.0, 2.5), HIT_OUTSIDE),
        (Vec3::new(-0.1, -0.2, 0.1), HIT_INSIDE),
        (Vec3::new(1.5, 0.52, 0.0), HIT_OUTSIDE),
    ] {
        let frame = look(&settings, eye, &program)[0];
        let hits = render_with_hits(&program, &UnprunedField, &[frame]).hits;
        let (mut hit, mut missed, mut wrong) = (0, 0, 0);
        for _ in 0..700 {
            let (x, y) = (
                (numbers.unit() * 64.0) as u32,
                (numbers.unit() * 64.0) as u32,
            );
            let found = &hits[(y * 64 + x) as usize];
            let epsilon = frame.epsilon.max(frame.close_slope * found.normal_t[3]);
            match first_crossing(&scene, eye, primary_ray(&frame, x, y).direction) {
                Some(t) => {
                    hit += 1;
                    // Within epsilon of the surface; along a grazing ray that is earlier by more.
                    let early = found.normal_t[3] <= t + 4.0 * epsilon;
                    let p = eye + primary_ray(&frame, x, y).direction * found.normal_t[3];
                    let near = naive::distance(&scene, p).abs() < 4.0 * f64::from(epsilon);
                    wrong += usize::from(found.kind != kind || !early || !near);
                }
                None => {
                    missed += 1;
                    // A ray that passes within epsilon may count as a hit.
                    let p = eye + primary_ray(&frame, x, y).direction * found.normal_t[3];
                    let near = naive::distance(&scene, p).abs() < 4.0 * f64::from(epsilon);
                    wrong += usize::from(found.kind != HIT_NONE && !near);
                }
            }
        }
        assert_eq!(wrong, 0, "from {eye}: {hit} hits, {missed} misses");
        assert!(hit > 100);
        assert!(kind == HIT_INSIDE || missed > 50);
    }
}

/// The rod is thinner than a pixel and than a step near it, and is hit anyway.
#[test]
fn thin_rods_are_not_lost() {
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::capsule(
            [-5.0, 0.0, 0.0],
            [5.0, 0.0, 0.0],
            5e-4,
        )))
        .expect("valid");
    let program = Program::lower(&scene).expect("valid");
    // An odd height: the middle row's rays go through the rod's axis.
    let settings = RenderSettings {
        size: [101, 51],
        ..RenderSettings::default()
    };
    let camera = Camera {
        eye: Vec3::new(0.0, 0.0, 3.0),
        target: Vec3::ZERO,
        field_of_view_degrees: 40.0,
    };
    let hits = render_with_hits(
        &program,
        &UnprunedField,
        &frame_uniforms(&settings, &camera, &program, None, FOCUS),
    )
    .hits;
    assert!(
        hits[25 * 101..26 * 101]
            .iter()
            .all(|h| h.kind == HIT_OUTSIDE)
    );
    assert!(hits[..24 * 101].iter().all(|h| h.kind == HIT_NONE));
}

#[test]
fn an_empty_scene_is_sky_on_both_devices() {
    let mut scene = Scene::new();
    scene.push(Group::new()).expect("valid");
    let program = Program::lower(&scene).expect("valid");
    let frames = look(
        &small(RenderMode::Shaded),
        Vec3::new(0.0, 1.0, 3.0),
        &program,
    );
    let cpu = render_with_hits(&program, &UnprunedField, &frames);
    let (found, _) = GpuProgram::new(gpu(), &program, false)
        .expect("a field")
        .render(&frames, ImageOutput::CpuWithHits)
        .wait()
        .expect("a picture");
    assert_eq!((cpu.hit_pixels, found.hit_pixels), (0, 0));
    assert_eq!(color_gap(&cpu, &found).0, 0);
}

/// Renders every scene of the repository, and one with a thousand brushes: long programs, loops and searches, in
/// small images.
#[test]
fn shipped_scenes_and_long_programs_are_the_same_on_both_devices() {
    let mut cases = shipped();
    let mut many = Scene::new();
    let mut numbers = CaseRng::new(32);
    for _ in 0..1000 {
        many.push(
            Brush::new(Shape::sphere(0.12))
                .at(numbers.point(1.0).to_array())
                .smooth(0.03),
        )
        .expect("valid");
    }
    cases.push(SceneCase {
        name: "a thousand balls".into(),
        scene: many,
    });
    let gpu = gpu();
    for SceneCase { name, scene } in cases {
        let program = Program::lower(&scene).expect("a program");
        let frame = scene.view.bounds.unwrap_or([[-1.0; 3], [1.0; 3]]);
        let focus = Aabb::new(frame[0].into(), frame[1].into());
        let camera = Camera::orbit(focus, [40.0, 25.0, 3.0], 40.0);
        let settings = RenderSettings {
            size: [24, 16],
            mode: RenderMode::Normal,
            ..RenderSettings::default()
        };
        let frames = frame_uniforms(&settings, &camera, &program, None, focus);
        let cpu = render_with_hits(&program, &UnprunedField, &frames);
        let (found, _) = GpuProgram::new(gpu.clone(), &program, false)
            .expect("a field")
            .render(&frames, ImageOutput::CpuWithHits)
            .wait()
            .expect("a picture");
        let (other, greatest) = gap(&cpu.hits, &found.hits);
        assert!(
            other <= 2 && greatest < 0.05,
            "{name}: {other} hits of another kind, {greatest}"
        );
        assert!(
            cpu.hits.iter().filter(|h| h.kind == HIT_OUTSIDE).count() > 20,
            "{name}"
        );
    }
}

/// Bounded. Rays with pruned programs find the same hits as with the unpruned program. Pruned distances are
/// bit-equal, but rays reach the surface with other steps.
#[test]
fn pruned_rays_equal_unpruned_ones() {
    let mut cases = shipped();
    cases.extend(all_cases());
    cases.extend((70..80).map(|seed| random_blends(seed, 40)));
    let mut rays = 0;
    for SceneCase { name, scene } in cases {
        let program = Program::lower(&scene).expect("a program");
        let held = program
            .aabb()
            .intersection(Aabb::centered(Vec3::splat(3.0)));
        for orbit in [[30.0, 20.0, 2.4], [200.0, -35.0, 0.8], [110.0, 3.0, 0.02]] {
            let camera = Camera::orbit(held, orbit, 45.0);
            let mut settings = RenderSettings {
                size: [90, 70],
                mode: RenderMode::Normal,
                max_steps: 2048,
                ..RenderSettings::default()
            };
            let frames = frame_uniforms(&settings, &camera, &program, None, held);
            // Not a part of a pixel, within which normals may be others.
            settings.epsilon = Some(frames[0].epsilon);
            let frames = frame_uniforms(&settings, &camera, &program, None, held);
            let whole = render_with_hits(&program, &UnprunedField, &frames).hits;
            let pruned = render_with_hits(&program, &PrunedField, &frames).hits;
            let epsilon = frames[0].epsilon;
            let (mut other, mut away, mut turned) = (0, 0, 0);
            for (a, b) in whole.iter().zip(&pruned) {
                other += usize::from(a.kind != b.kind);
                if a.kind != b.kind || a.kind == HIT_NONE {
                    continue;
                }
                rays += 1;
                // Both have come within epsilon; along a grazing ray that may be some way.
                let (n, m) = (Vec3::from_slice(&a.normal_t), Vec3::from_slice(&b.normal_t));
                let gap = (a.normal_t[3] - b.normal_t[3]).abs();
                away += usize::from(gap > 20.0 * epsilon + 1e-3 * a.normal_t[3]);
                turned += usize::from(n.dot(m) < 0.99);
            }
            let allowed = whole.len() / 100;
            assert!(
                other <= allowed && away <= allowed && turned <= allowed,
                "{name} from {orbit:?}: {other} of another kind, {away} elsewhere, {turned} turned"
            );
        }
    }
    assert!(rays > 100_000, "{rays}");
}

/// Returns where a ray first hits one of several spheres of a radius, and the minimum gap to the spheres before
/// that.
fn nearest_sphere(spheres: &[Vec3], radius: f32, origin: Vec3, direction: Vec3) -> (f32, f32) {
    let (mut first, mut passed) = (f32::INFINITY, f32::INFINITY);
    for &center in spheres {
        let along = (center - origin).dot(direction);
        let apart = (center - origin - along * direction).length() - radius;
        if apart < 0.0 {
            let half = (radius * radius - (apart + radius) * (apart + radius)).sqrt();
            first = first.min(along - half);
        } else {
            passed = passed.min(apart);
        }
    }
    (first, passed)
}

/// Among very many spheres, rays find the one that a formula gives.
#[test]
fn rays_find_the_nearest_of_very_many() {
    let radius = 0.008;
    let mut numbers = CaseRng::new(19);
    let spheres: Vec<Vec3> = (0..30_000).map(|_| numbers.point(1.0)).collect();
    let mut scene = Scene::new();
    for center in &spheres {
        let solid = Brush::new(Shape::sphere(radius)).at(center.to_array());
        scene.push(solid).expect("a brush");
    }
    let program = Program::lower(&scene).expect("a program");
    let camera = Camera::orbit(FOCUS, [30.0, 20.0, 2.4], 45.0);
    let settings = RenderSettings {
        size: [90, 70],
        mode: RenderMode::Normal,
        max_steps: 4096,
        epsilon: Some(1e-4),
        ..RenderSettings::default()
    };
    let frame = frame_uniforms(&settings, &camera, &program, None, FOCUS)[0];
    let hits = render_with_hits(&program, &PrunedField, &[frame]).hits;
    let epsilon = frame.epsilon;
    let (mut met, mut missed) = (0, 0);
    for (i, hit) in hits.iter().enumerate() {
        let ray = primary_ray(&frame, i as u32 % 90, i as u32 / 90);
        let (t, passed) = nearest_sphere(&spheres, radius, camera.eye, ray.direction);
        let is_hit = hit.kind == HIT_OUTSIDE;
        if passed < 2.0 * epsilon {
            // One that it passes within epsilon may count.
            continue;
        }
        assert_eq!(is_hit, t < f32::INFINITY, "ray {i}: {t}, {hit:?}");
        if is_hit {
            met += 1;
            let early = t - hit.normal_t[3];
            // A grazing ray comes within epsilon long before.
            let most = (2.0 * radius * 2.0 * epsilon).sqrt() + 1e-4;
            assert!((-1e-4..most).contains(&early), "ray {i}: {t}, {hit:?}");
        } else {
            missed += 1;
        }
    }
    assert!(met > 500 && missed > 500, "{met} met, {missed} missed");
}

/// Light from nearby pieces equals light from the whole field, also if all nearby pieces are in a group.
#[test]
fn light_of_many_is_the_whole_fields() {
    for is_grouped in [false, true] {
        let mut numbers = CaseRng::new(31);
        let mut scene = Scene::new();
        scene
            .set_material("red", Material::colored([0.8, 0.1, 0.1]))
            .expect("a material");
        let group = match is_grouped {
            true => {
                let group = Group::new().rotated([0.0, 1.0, 0.0], 30.0).smooth(0.01);
                scene.push(group).expect("a group").node
            }
            false => Scene::ROOT,
        };
        for i in 0..1200 {
            let size = numbers.between(0.01, 0.05);
            let shape = if i % 2 == 0 {
                Shape::sphere(size)
            } else {
                Shape::cuboid([size, 0.5 * size, size])
            };
            let mut solid = Brush::new(shape).at(numbers.point(0.9).to_array());
            if i % 3 == 0 {
                solid = solid.with_material("red");
            }
            scene.push_into(group, solid).expect("a brush");
        }
        let program = Program::lower(&scene).expect("a program");
        assert!(program.operand_count() >= 1200);
        let camera = Camera::orbit(FOCUS, [30.0, 20.0, 3.4], 45.0);
        let settings = RenderSettings {
            size: [96, 72],
            epsilon: Some(1e-4),
            ..RenderSettings::default()
        };
        let frame = frame_uniforms(&settings, &camera, &program, None, FOCUS);
        let near = render_with_hits(&program, &PrunedField, &frame);
        let whole = render_with_hits(&program, &UnprunedField, &frame);
        let pixels = near.rgb.chunks(3).zip(whole.rgb.chunks(3));
        let off = |(a, b): (&[u8], &[u8])| {
            let all = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
            all.max().unwrap_or(0)
        };
        let differ = pixels.filter(|&pair| off(pair) > 3).count();
        assert!(near.hit_pixels > 500, "{}", near.hit_pixels);
        assert!(differ < 10, "{differ} of {} differ", 96 * 72);
    }
}
