//! Layouts and copies whose numbers would lead samplers, which do not check bounds, out of their tables.

use argil_field::Program;
use argil_scene::{Scene, Shape};
use argil_volume::{
    BlockTable, BrickLayout, BrickSettings, BricksError, Encoding, Levels, LevelsLayout,
    MAX_VOXEL_INDEX, SampleFormat, Texels, VoxelGrid,
};
use glam::{IVec3, UVec3, Vec3};

fn grid() -> VoxelGrid {
    VoxelGrid {
        corner: Vec3::ZERO,
        voxel_size: 0.1,
        begin: IVec3::ZERO,
        size: UVec3::splat(64),
        is_clipped: false,
    }
}

#[test]
fn layouts_have_bricks_and_voxels_that_can_be_counted() {
    let settings = |brick_size_voxels| BrickSettings {
        brick_size_voxels,
        ..BrickSettings::default()
    };
    assert!(BrickLayout::new(grid(), &settings(8)).is_ok());
    for size in [0, 1, 7, 9, 65_536, u32::MAX] {
        let found = BrickLayout::new(grid(), &settings(size));
        assert_eq!(found, Err(BricksError::Brick(size)));
    }
    let wrong = [
        VoxelGrid {
            size: UVec3::new(64, 0, 64),
            ..grid()
        },
        VoxelGrid {
            size: UVec3::splat(u32::MAX),
            ..grid()
        },
        VoxelGrid {
            begin: IVec3::splat(i32::MIN),
            ..grid()
        },
        VoxelGrid {
            begin: IVec3::splat(MAX_VOXEL_INDEX - 63),
            ..grid()
        },
        VoxelGrid {
            voxel_size: 0.0,
            ..grid()
        },
        VoxelGrid {
            voxel_size: f32::NAN,
            ..grid()
        },
        VoxelGrid {
            corner: Vec3::new(0.0, f32::INFINITY, 0.0),
            ..grid()
        },
    ];
    for grid in wrong {
        let found = BrickLayout::new(grid, &settings(8));
        assert_eq!(found, Err(BricksError::Grid), "{grid:?}");
    }
}

/// A table over more blocks than its integers count would wrap around.
#[test]
#[should_panic(expected = "blocks from")]
fn tables_refuse_boxes_that_cannot_be_counted() {
    BlockTable::new(IVec3::MIN, IVec3::MAX);
}

/// Samples of two bytes are half as many in the same number of bytes.
#[test]
fn copies_of_levels_keep_the_format_of_samples() {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(1.0)).expect("a sphere");
    let program = Program::lower(&scene).expect("a program");
    let encoding = Encoding {
        format: SampleFormat::Snorm8,
        ..Encoding::default()
    };
    let settings = BrickSettings {
        encoding,
        ..BrickSettings::default()
    };
    let grid = VoxelGrid::fitting(program.aabb(), None, 64).expect("a grid");
    let layout = LevelsLayout::new(grid, &settings).expect("levels");
    let mut levels = Levels::bake(&program, layout, 1 << 30).expect("levels");
    levels.refine_around(&program, Vec3::ZERO, 1e-6);
    let copy = |bits| {
        let pool = Texels::from_bytes(bits, levels.pool().bytes().to_vec())?;
        levels.with_contents(levels.words().to_vec(), levels.children().to_vec(), pool)
    };
    assert!(levels.pool().bytes().len().is_multiple_of(2));
    assert!(copy(SampleFormat::Snorm8).is_some());
    assert!(copy(SampleFormat::Snorm16).is_none());
}
