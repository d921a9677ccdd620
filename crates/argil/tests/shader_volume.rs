//! Bricks and levels in the shaders of a host, against the queries of the same world on the CPU.

use crate::host_common::Host;
use argil::gpu::{GpuError, ShaderVolume, wgpu};
use argil::prelude::*;
use argil::scene::Material;
use argil::{BricksOptions, LevelsOptions, RenderError, Representation};
use glam::Vec3;
use std::error::Error;

type Outcome = Result<(), Box<dyn Error>>;

/// Edge of a voxel.
const VOXEL: f32 = 1.0 / 64.0;

/// What shaders of a host can ask.
fn representations() -> [Representation; 2] {
    let voxel_size = Some(VOXEL);
    let bricks = BricksOptions {
        voxel_size,
        ..BricksOptions::default()
    };
    let levels = LevelsOptions {
        voxel_size,
        ..LevelsOptions::default()
    };
    [bricks.into(), levels.into()]
}

/// Looks at a world from all sides, so that levels bake their finest pages.
fn look_around(world: &mut World) -> Outcome {
    let settings = RenderSettings {
        size: [160, 160],
        mode: RenderMode::Normal,
        ..RenderSettings::default()
    };
    for place in [
        [0.0, 0.0],
        [90.0, 20.0],
        [180.0, -20.0],
        [270.0, 0.0],
        [0.0, 80.0],
        [0.0, -80.0],
    ] {
        let camera = Camera::orbit(world.view_bounds(), [place[0], place[1], 2.2], 50.0);
        world.refine(&camera, &settings)?;
    }
    Ok(())
}

/// A host's shader, with names that the volume's code has, too.
const ASK: &str = "
struct Hit { t: f32 }
@group(0) @binding(0) var<storage, read> cells: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> hits: array<vec4<f32>>;
fn locate(index: u32) -> vec4<f32> { return cells[index]; }
@compute @workgroup_size(64)
fn march(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&cells) / 2u {
        return;
    }
    let p = locate(2u * id.x).xyz;
    let direction = locate(2u * id.x + 1u).xyz;
    let ray = argil_cast_ray(p, direction, 100.0);
    let material = argil_material(p + direction * ray.t);
    hits[4u * id.x] = vec4(argil_distance(p), select(-1.0, ray.t, ray.is_hit), material.roughness, material.metallic);
    hits[4u * id.x + 1u] = vec4(argil_gradient(p), 0.0);
    hits[4u * id.x + 2u] = vec4(ray.normal, 0.0);
    hits[4u * id.x + 3u] = vec4(material.base_color, 0.0);
}
";

/// Compiles the host's shader, and returns the layout of its buffers.
fn pipeline(
    device: &wgpu::Device,
    volume: &ShaderVolume,
) -> (wgpu::ComputePipeline, wgpu::BindGroupLayout) {
    let source = ASK.replace("@group(0)", "@group(1)") + &volume.wgsl(0);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let entry = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let buffers_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[entry(0, true), entry(1, false)],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(volume.layout()), Some(&buffers_layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&layout),
        module: &module,
        entry_point: Some("march"),
        compilation_options: Default::default(),
        cache: None,
    });
    (pipeline, buffers_layout)
}

/// Asks a volume at points and along rays: four answers each.
fn asked(
    host: &Host,
    volume: &ShaderVolume,
    rays: &[[Vec3; 2]],
) -> Result<Vec<[[f32; 4]; 4]>, Box<dyn Error>> {
    let device = &host.device;
    let buffer = |size, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let count = rays.len() as u64;
    let storage = wgpu::BufferUsages::STORAGE;
    let questions = buffer(32 * count, storage);
    let answers = buffer(64 * count, storage | wgpu::BufferUsages::COPY_SRC);
    let staging = buffer(64 * count, wgpu::BufferUsages::MAP_READ);
    let words: Vec<[f32; 4]> = rays
        .iter()
        .flatten()
        .map(|v| v.extend(0.0).into())
        .collect();
    host.queue
        .write_buffer(&questions, 0, bytemuck::cast_slice(&words));
    let (pipeline, buffers_layout) = pipeline(device, volume);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &buffers_layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: questions.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: answers.as_entire_binding(),
            },
        ],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, volume.bind_group(), &[]);
    pass.set_bind_group(1, &group, &[]);
    pass.dispatch_workgroups((rays.len() as u32).div_ceil(64), 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&answers, 0, &staging, 0, 64 * count);
    host.queue.submit([encoder.finish()]);
    staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = staging.slice(..).get_mapped_range()?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// A red ball with a blue ring, smoothly joined, and a bite.
fn scene() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new();
    let material = |base_color, roughness, metallic| Material {
        base_color,
        roughness,
        metallic,
        ..Material::default()
    };
    scene.set_material("red", material([0.8, 0.1, 0.1], 0.3, 0.0))?;
    scene.set_material("blue", material([0.1, 0.2, 0.7], 0.8, 1.0))?;
    scene.push(Brush::new(Shape::sphere(0.7)).with_material("red"))?;
    let ring = Brush::new(Shape::torus(0.8, 0.2)).with_material("blue");
    scene.push(ring.smooth(0.1))?;
    scene.push(bite([0.5, 0.5, 0.5]))?;
    Ok(scene)
}

fn bite(place: [f32; 3]) -> Brush {
    Brush::new(Shape::cuboid([0.3; 3])).at(place).subtract()
}

/// Points in and around the solid, each with a direction, from a fixed seed.
fn rays(count: usize) -> Vec<[Vec3; 2]> {
    let mut state = 7u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    };
    let mut vector = move || Vec3::new(random(), random(), random());
    let ray = |_| [1.6 * vector(), vector().normalize_or(Vec3::X)];
    (0..count).map(ray).collect()
}

/// How many answers are right, of those that count.
#[derive(Default)]
struct Share {
    right: usize,
    all: usize,
}

impl Share {
    fn add(&mut self, is_right: bool) {
        self.all += 1;
        self.right += usize::from(is_right);
    }

    fn is_at_least(&self, share: f64) -> bool {
        self.all > 100 && self.right as f64 >= share * self.all as f64
    }
}

/// How many answers are right, by what was asked, and the share that must be.
type Shares = [(&'static str, Share, f64); 7];

/// Compares what shaders answer with the exact field on the CPU.
fn compared(host: &Host, world: &World, volume: &ShaderVolume) -> Result<Shares, Box<dyn Error>> {
    let rays = rays(12_000);
    let answers = asked(host, volume, &rays)?;
    let query = world.query();
    let voxel = VOXEL;
    // Far from the surface, voxels of levels are larger.
    let is_levels = world.levels().is_some();
    let [mut distances, mut bounds, mut slopes] = <[Share; 3]>::default();
    let [mut hits, mut lengths, mut normals, mut materials] = <[Share; 4]>::default();
    for ([p, direction], [first, gradient, normal, base]) in rays.into_iter().zip(answers) {
        let [d, t, roughness, metallic] = first;
        let (exact, slope) = query.gradient(p.into());
        if exact.abs() < 3.0 * voxel {
            distances.add((d - exact).abs() < 0.1 * voxel);
            let unit = |v: &[f32]| Vec3::from_slice(v).normalize_or_zero();
            slopes.add(unit(&gradient[..3]).dot(unit(&slope)) > 0.95);
        } else {
            let more = if is_levels { 0.25 * exact.abs() } else { 0.0 };
            let is_bound = d.abs() <= exact.abs() + 0.1 * voxel + more;
            bounds.add(is_bound && (d < 0.0) == (exact < 0.0) && d != 0.0);
        }
        let hit = query.cast_ray(p.into(), direction.into(), 100.0);
        hits.add(hit.is_some() == (t >= 0.0));
        if let Some(hit) = hit.filter(|_| t >= 0.0) {
            lengths.add((t - hit.distance).abs() < 0.5 * voxel);
            let toward = if exact < 0.0 { -1.0 } else { 1.0 };
            let normal = toward * Vec3::from_slice(&normal[..3]);
            normals.add(normal.dot(hit.normal.into()) > 0.9);
            let color = Vec3::from_slice(&base[..3]);
            let rest = [
                roughness - hit.material.roughness,
                metallic - hit.material.metallic,
            ];
            let is_right = color.distance(hit.material.base_color.into()) < 0.1;
            materials.add(is_right && rest.iter().all(|d| d.abs() < 0.15));
        }
    }
    Ok([
        ("distances", distances, 0.97),
        ("bounds", bounds, 1.0),
        ("gradients", slopes, 0.9),
        ("hits", hits, 0.99),
        ("lengths", lengths, 0.97),
        ("normals", normals, 0.95),
        ("materials", materials, 0.95),
    ])
}

/// Fails if too many answers are wrong.
fn compare(host: &Host, world: &World, volume: &ShaderVolume) -> Outcome {
    let kind = world.representation().name();
    for (name, share, least) in compared(host, world, volume)? {
        let Share { right, all } = share;
        println!("{kind}, {name}: {right} of {all}");
        assert!(
            share.is_at_least(least),
            "{kind}, {name}: {right} of {all} are right"
        );
    }
    Ok(())
}

/// What shaders answer is what the field says, also after edits, and names of the host stay free.
#[test]
fn shaders_ask_what_the_field_says() -> Outcome {
    let host = Host::new([8, 8])?;
    let (_, engine) = host.engine()?;
    for representation in representations() {
        let mut scene = scene()?;
        let mut world = engine.build(&scene)?.with_representation(representation)?;
        let mut volume = world.shader_volume()?;
        if world.levels().is_some() {
            // The coarsest pages answer, before an image asked for others.
            let [.., (_, lengths, _), _, _] = compared(&host, &world, &volume)?;
            assert!(lengths.all > 100 && !lengths.is_at_least(0.5), "fine pages");
        }
        look_around(&mut world)?;
        world.update_shader_volume(&mut volume)?;
        compare(&host, &world, &volume)?;
        scene.push(bite([-0.4, -0.3, 0.6]))?;
        world.apply(&scene)?;
        look_around(&mut world)?;
        world.update_shader_volume(&mut volume)?;
        compare(&host, &world, &volume)?;
        // The box and the pool grow.
        scene.push(Brush::new(Shape::sphere(0.8)).at([1.5, 0.0, 0.0]))?;
        world.apply(&scene)?;
        look_around(&mut world)?;
        assert!(world.update_shader_volume(&mut volume)?, "the same memory");
        compare(&host, &world, &volume)?;
    }
    Ok(())
}

/// Other representations, and worlds on the CPU, are refused.
#[test]
fn other_worlds_are_refused() -> Outcome {
    let host = Host::new([8, 8])?;
    let (_, engine) = host.engine()?;
    let scene = scene()?;
    let names = representations().map(|kind| kind.name());
    let mut bound = Vec::new();
    for representation in Representation::all(32) {
        let name = representation.name();
        let world = engine.build(&scene)?.with_representation(representation)?;
        match world.shader_volume() {
            Ok(volume) => bound.push((name, volume)),
            Err(RenderError::Gpu(GpuError::NoShaderVolume { name: refused })) => {
                assert_eq!(refused, name)
            }
            Err(error) => return Err(error.into()),
        }
    }
    assert_eq!(
        bound.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
        names
    );
    for representation in representations() {
        let world = engine.build(&scene)?.with_representation(representation)?;
        for (name, volume) in &mut bound {
            match world.update_shader_volume(volume) {
                Ok(_) => assert_eq!(*name, representation.name()),
                Err(RenderError::Gpu(GpuError::OtherShaderVolume)) => {
                    assert_ne!(*name, representation.name());
                }
                Err(error) => return Err(error.into()),
            }
        }
    }
    let world = Engine::cpu().build(&scene)?.bricks(32)?;
    assert!(matches!(world.shader_volume(), Err(RenderError::NotOnGpu)));
    Ok(())
}
