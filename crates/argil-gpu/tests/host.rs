//! Runs the shader for other engines, `docs/march-bricks.md`, on its own device.

use argil_field::Program;
use argil_scene::Scene;
use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid};
use glam::{IVec3, Vec3};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

const SHADER: &str = include_str!("../../../docs/march-bricks.wgsl");

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Bound {
    low: [i32; 3],
    brick_size_voxels: u32,
    count: [i32; 3],
    rays: u32,
    corner: [f32; 3],
    voxel_size: f32,
    lipschitz: f32,
    padding: [f32; 3],
}

#[expect(
    clippy::too_many_lines,
    reason = "a program of wgpu's, which is told step by step"
)]
fn marched(bricks: &Bricks, rays: &[[Vec3; 2]]) -> Vec<f32> {
    let instance = wgpu::Instance::default();
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
    let adapter = adapter.expect("an adapter, or lavapipe");
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: adapter.limits(),
        ..Default::default()
    }))
    .expect("a device");

    let layout = bricks.layout();
    let [low, high]: [IVec3; 2] = [layout.first_cell(), layout.end_cell()];
    let bound = Bound {
        low: low.to_array(),
        brick_size_voxels: layout.brick_size_voxels(),
        count: (high - low).to_array(),
        rays: rays.len() as u32,
        corner: layout.voxel_grid().corner.to_array(),
        voxel_size: layout.voxel_grid().voxel_size,
        lipschitz: bricks.lipschitz(),
        padding: [0.0; 3],
    };
    let samples = layout.brick_samples() as usize;
    let mut distances = vec![0.0f32; samples * bricks.len()];
    for brick in bricks.iter() {
        let first = brick.index() as usize * samples;
        for (to, from) in distances[first..].iter_mut().zip(brick.distances()) {
            *to = from;
        }
    }
    let rays: Vec<[f32; 4]> = rays
        .iter()
        .flatten()
        .map(|v| v.extend(0.0).to_array())
        .collect();
    let words = bricks.words_between(low, high);
    let storage = wgpu::BufferUsages::STORAGE;
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&BufferInitDescriptor {
            label: None,
            contents,
            usage,
        })
    };
    let hits = vec![0.0f32; rays.len() / 2];
    let buffers = [
        buffer(bytemuck::bytes_of(&bound), wgpu::BufferUsages::UNIFORM),
        buffer(bytemuck::cast_slice(&words), storage),
        buffer(bytemuck::cast_slice(&distances), storage),
        buffer(bytemuck::cast_slice(&rays), storage),
        buffer(
            bytemuck::cast_slice(&hits),
            storage | wgpu::BufferUsages::COPY_SRC,
        ),
    ];
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("march-bricks.wgsl"),
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
        .zip(&buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let read = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: size_of_val(&hits[..]) as u64,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups((hits.len() as u32).div_ceil(64), 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&buffers[4], 0, &read, 0, read.size());
    queue.submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |mapped| {
        mapped.expect("what was read");
    });
    let polled = device.poll(wgpu::PollType::wait_indefinitely());
    polled.expect("the device");
    let view = read.slice(..).get_mapped_range().expect("what was read");
    bytemuck::cast_slice(&view).to_vec()
}

/// Traces a ray through the exact field by sphere tracing. Returns the distance to the hit, and the minimum
/// distance on the way.
fn traced(program: &Program, [origin, direction]: [Vec3; 2], end: f32) -> (Option<f32>, f32) {
    let (mut t, mut least) = (0.0, f32::INFINITY);
    while t < end {
        let d = program.distance(origin + t * direction);
        least = least.min(d);
        if d < 1e-4 {
            return (Some(t), least);
        }
        t += d / program.lipschitz();
    }
    (None, least)
}

/// Rays of the shader end where the exact field is 0, within a fraction of a voxel. No ray misses a hit, and rays
/// that start near the surface, where bounds are near 0, arrive too.
#[test]
fn a_custom_shader_hits_the_fields_surface() {
    for name in ["csg20", "temple"] {
        let path = format!("{}/../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let scene = Scene::open(path).expect("a scene that ships");
        let program = Program::lower(&scene).expect("a program");
        let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 192).expect("a voxel grid");
        let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
        let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
        let held = voxel_grid.aabb();
        let (center, size) = (held.center(), held.half_diagonal());
        let mut rays = Vec::new();
        for i in 0..900u32 {
            let along = |k: u32| ((i * k) % 1_499) as f32 / 1_499.0 - 0.5;
            let from = Vec3::new(along(101), along(307), along(571));
            let to = 0.8 * held.size() * Vec3::new(along(211), along(401), along(97));
            let origin = center + 2.2 * size * (from + Vec3::splat(1e-3)).normalize();
            rays.push([origin, (center + to - origin).normalize()]);
        }
        // From beside the surface, along it and a little away.
        let skimming: Vec<[Vec3; 2]> = rays
            .iter()
            .filter_map(|&[origin, direction]| {
                let t = traced(&program, [origin, direction], 6.0 * size).0?;
                let p = origin + t * direction;
                let normal = program.gradient(p).1.try_normalize()?;
                let aside = normal.any_orthonormal_vector() + 0.1 * normal;
                Some([p + 2.5 * voxel_grid.voxel_size * normal, aside.normalize()])
            })
            .take(250)
            .collect();
        rays.extend(skimming);
        let found = marched(&bricks, &rays);
        let (mut hits, mut odd) = (0, 0);
        for (&ray, &found) in rays.iter().zip(&found) {
            let (exact, least) = traced(&program, ray, 6.0 * size);
            let is_hit = found >= 0.0;
            if is_hit {
                hits += 1;
                let d = program.distance(ray[0] + found * ray[1]);
                let most = 0.75 * voxel_grid.voxel_size;
                assert!(d.abs() < most, "{name} {ray:?}: {found}, {d} of {most}");
            }
            match exact {
                Some(t) if is_hit => {
                    odd += u32::from((t - found).abs() > 2.0 * voxel_grid.voxel_size)
                }
                Some(_) => odd += 1,
                // Past an edge, within what bricks tell.
                None if is_hit => assert!(least < 0.75 * voxel_grid.voxel_size, "{name} {ray:?}"),
                None => {}
            }
        }
        assert!(hits > 400, "{name}: {hits}");
        // Rays that graze an edge may meet it or pass.
        assert!(
            odd * 100 < rays.len() as u32,
            "{name}: {odd} of {}",
            rays.len()
        );
    }
}
