//! Pages far from the scene's origin are as precise as those near it.

use argil_field::Program;
use argil_scene::{Brush, EditError, Group, Modifier, Pose, Scene, Shape};
use argil_volume::{BrickSettings, Levels, LevelsLayout, VoxelGrid, is_brick};
use glam::{DVec3, IVec3, UVec3, Vec3};

/// Voxels in a unit: 1/32 m.
const PER_METER: i32 = 32;
/// From a village to the other one, in meters: 131 km.
const FAR: i32 = 1 << 17;

/// Adds a few houses with roofs and chimneys, turned, and stones that are instances.
fn push_village(scene: &mut Scene, at: [f32; 3]) -> Result<(), EditError> {
    let village = scene.push(Group::new().at(at))?.node;
    for i in 0..12u16 {
        let place = [
            6.0 + 5.0 * f32::from(i % 4),
            3.0 + 0.123 * f32::from(i),
            6.0 + 5.3 * f32::from(i / 4),
        ];
        let turned = Group::new().rotated([0.1, 1.0, 0.05], f32::from(i) * 37.3);
        let house = scene.push_into(village, turned.at(place))?.node;
        scene.push_into(house, Shape::cuboid([1.5, 1.0, 1.1]))?;
        let roof = Brush::new(Shape::cuboid([1.2, 1.2, 1.3])).rotated([0.0, 0.0, 1.0], 45.0);
        scene.push_into(house, roof.at([0.0, 1.0, 0.0]).smooth(0.1))?;
        scene.push_into(
            house,
            Brush::new(Shape::cuboid([0.2, 0.9, 0.2])).at([0.7, 2.4, 0.3]),
        )?;
        let door = Brush::new(Shape::cuboid([0.4, 0.7, 0.2])).at([0.0, -0.2, 1.1]);
        scene.push_into(house, door.subtract())?;
    }
    let poses = (0..30u16).map(|i| Pose {
        position: [
            f32::from(i % 6) * 4.1 + 3.3,
            1.0,
            f32::from(i / 6) * 3.7 + 3.1,
        ],
        degrees: f32::from(i) * 61.0,
        scale: 0.5 + 0.1 * f32::from(i % 3),
    });
    let poses: Vec<Pose> = poses.collect();
    let stones = Brush::new(Shape::cuboid([0.4, 0.3, 0.5]));
    scene.push_into(
        village,
        stones.with_modifier(Modifier::Instances {
            poses: poses.into(),
        }),
    )?;
    Ok(())
}

fn wide_layout() -> Result<LevelsLayout, Box<dyn std::error::Error>> {
    let grid = VoxelGrid {
        corner: Vec3::ZERO,
        voxel_size: 1.0 / PER_METER as f32,
        begin: IVec3::ZERO,
        size: UVec3::new(((FAR + 64) * PER_METER) as u32, 2048, 2048),
        is_clipped: true,
    };
    Ok(LevelsLayout::new(grid, &BrickSettings::default())?)
}

/// Two villages that are the same have the same pages, to the bit, 131 km apart.
#[test]
fn a_village_far_out_has_the_pages_of_one_at_the_origin() -> Result<(), Box<dyn std::error::Error>>
{
    let mut scene = Scene::new();
    push_village(&mut scene, [0.0; 3])?;
    push_village(&mut scene, [FAR as f32, 0.0, 0.0])?;
    let program = Program::lower(&scene)?;
    let mut levels = Levels::bake(&program, wide_layout()?, 1 << 30)?;
    // All levels down to the finest, along lines through both villages.
    for i in 0..60u16 {
        let point = DVec3::new(3.0 + 0.4 * f64::from(i), 3.0, 4.0 + f64::from(i * 7 % 20));
        for offset in [0, FAR] {
            let point = point + DVec3::new(f64::from(offset), 0.0, 0.0);
            while levels.request(0, point.as_vec3()) {
                levels.fill(&program, None);
            }
        }
    }
    let shift = FAR * PER_METER;
    let pages = levels.pages();
    let pool = levels.pool().of::<i16>().expect("16 bits");
    let mut compared = [0; 8];
    for (slot, page) in pages.iter().enumerate().filter(|(_, page)| page.level < 8) {
        let mut origin = page.origin;
        origin[0] += shift;
        let far = pages
            .iter()
            .position(|other| (other.level, other.origin) == (page.level, origin));
        let Some(far) = far.filter(|_| page.origin[0] < shift / 2) else {
            continue;
        };
        for i in 0..8 {
            let [near, far] = [8 * slot + i, 8 * far + i].map(|cell| levels.words()[cell]);
            assert_eq!(is_brick(near), is_brick(far));
            let [near, far] = [near, far].map(|word| {
                let begin = 729 * word as usize;
                pool.get(begin..begin + 729).filter(|_| is_brick(word))
            });
            assert!(
                near == far,
                "page at {:?} of level {}",
                page.origin,
                page.level
            );
            compared[page.level as usize] += u32::from(near.is_some());
        }
    }
    let total: u32 = compared.iter().sum();
    assert!(
        total > 100 && compared.iter().all(|&count| count > 0),
        "{compared:?}"
    );
    Ok(())
}

/// Stored distances 100 km out are right to a thousandth of a voxel and half a code, by arithmetic of their own.
#[test]
fn distances_far_out_are_right_to_a_thousandth_of_a_voxel() -> Result<(), Box<dyn std::error::Error>>
{
    let center = DVec3::new(100_000.0, 12.0, 9.0);
    let inner = [0.123_456, 0.234_567, -0.345_678];
    let sphere = Brush::new(Shape::sphere(1.0)).at(inner);
    let mut scene = Scene::new();
    let group = scene
        .push(Group::new().at(center.as_vec3().to_array()))?
        .node;
    scene.push_into(group, sphere)?;
    let program = Program::lower(&scene)?;
    let layout = wide_layout()?;
    let mut levels = Levels::bake(&program, layout, 1 << 30)?;
    let exact = center + Vec3::from(inner).as_dvec3();
    for up in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::splat(-0.577)] {
        while levels.request(0, (exact + up).as_vec3()) {
            levels.fill(&program, None);
        }
    }
    let voxel = 1.0 / f64::from(PER_METER);
    let pool = levels.pool().of::<i16>().expect("16 bits");
    let mut count = 0;
    for (slot, page) in levels.pages().iter().enumerate() {
        if page.level > 0 {
            continue;
        }
        for i in 0..8i32 {
            let word = levels.words()[8 * slot + i as usize];
            let Some(samples) = pool.get(729 * word as usize..).filter(|_| is_brick(word)) else {
                continue;
            };
            let corner = IVec3::from(page.origin) + 8 * IVec3::new(i & 1, i >> 1 & 1, i >> 2);
            for (index, &code) in samples[..729].iter().enumerate() {
                let index = index as i32;
                let place = corner + IVec3::new(index % 9, index / 9 % 9, index / 81);
                let d = (place.as_dvec3() * voxel).distance(exact) - 1.0;
                let band = 16.0 * voxel;
                let stored = f64::from(code) / 32_767.0 * band;
                let off = (stored - d.clamp(-band, band)).abs() / voxel;
                assert!(
                    off < 1e-3 + 0.5 * 16.0 / 32_767.0,
                    "{off} voxels at {place}"
                );
                count += 1;
            }
        }
    }
    assert!(count > 2000, "{count}");
    Ok(())
}
