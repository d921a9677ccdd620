//! Infinite solids that the box clips: a ray that enters through the cut has hit the box's side.

use argil_abi::HIT_NONE;
use argil_conformance::{Wait, gpu, primary_ray};
use argil_field::Program;
use argil_gpu::{GpuProgram, GpuVolume, ImageOutput};
use argil_math::Aabb;
use argil_render::{
    Camera, NormalSource, RenderMode, RenderSettings, frame_uniforms, render_with_hits,
};
use argil_scene::{Brush, Modifier, Scene, Shape};
use argil_volume::{
    BrickLayout, BrickSettings, Bricks, Dense, Encoding, Octree, OctreeLayout, OctreeSettings,
    Volume, VoxelGrid,
};
use glam::Vec3;

/// Independent: the exact field is negative at a hit only where the box clips a solid. The normal there is that of the
/// box's side. Devices agree.
#[test]
fn cuts_have_the_normals_of_the_box() {
    let mut scene = Scene::new();
    let repeat = Modifier::Repeat {
        spacing: [1.0; 3],
        count: None,
    };
    let brush = Brush::new(Shape::sphere(0.3)).with_modifier(repeat);
    scene.push(brush).expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    let region = Aabb::centered(Vec3::splat(1.0));
    let grid = VoxelGrid::fitting(program.aabb(), Some(region), 64).expect("a grid");
    let layout = BrickLayout::new(grid, &BrickSettings::default()).expect("a layout");
    let tree = OctreeSettings {
        brick_size_voxels: 8,
        ..OctreeSettings::default()
    };
    let tree_layout = OctreeLayout::new(grid, &tree).expect("a layout");
    let volumes: [Volume; 4] = [
        Bricks::bake(&program, layout, None)
            .expect("bricks")
            .0
            .into(),
        Dense::bake(&program, grid, Encoding::default(), false).into(),
        Dense::bake(&program, grid, Encoding::default(), true).into(),
        Octree::bake(&program, tree_layout, tree.brick_test)
            .0
            .into(),
    ];
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let camera = Camera::orbit(region, [30.0, 20.0, 2.4], 40.0);
    for (i, volume) in volumes.iter().enumerate() {
        let on_gpu = GpuVolume::upload(&field, volume).wait().expect("a volume");
        for normals in [NormalSource::Voxel, NormalSource::Field] {
            let settings = RenderSettings {
                size: [120, 90],
                mode: RenderMode::Normal,
                normals,
                ..RenderSettings::default()
            };
            let frames = frame_uniforms(&settings, &camera, &program, Some(&grid), region);
            let cpu = render_with_hits(&program, volume, &frames);
            let mut cuts = 0;
            for (pixel, hit) in cpu.hits.iter().enumerate() {
                let (x, y) = (pixel as u32 % 120, pixel as u32 / 120);
                let ray = primary_ray(&frames[0], x, y);
                let p = ray.at(hit.normal_t[3]);
                if hit.kind == HIT_NONE || program.distance(p) > -grid.voxel_size {
                    continue;
                }
                cuts += 1;
                let n = Vec3::from_slice(&hit.normal_t[..3]);
                assert_eq!(n.abs().max_element(), 1.0, "volume {i}, {normals:?}: {n}");
                assert_eq!(n.length(), 1.0, "volume {i}, {normals:?}: {n}");
                assert!(n.dot(ray.direction) < 0.0 && n.dot(p) > 0.99, "{n} at {p}");
            }
            assert!(cuts > 100, "volume {i}: {cuts} pixels");
            let found = on_gpu
                .render(&field, &frames, ImageOutput::CpuWithHits)
                .wait();
            let found = found.expect("an image").0;
            let pairs = cpu.rgb.iter().zip(&found.rgb);
            let differing = pairs.filter(|(a, b)| a.abs_diff(**b) > 12).count();
            assert!(
                differing <= cpu.rgb.len() / 500,
                "volume {i}, {normals:?}: {differing} bytes"
            );
        }
    }
}
