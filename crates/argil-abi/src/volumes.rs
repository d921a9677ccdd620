//! The uniforms by which shaders read volumes, one for each kind.

use crate::declare::shared_struct;

shared_struct! {
    /// A dense volume of stored distances over a box.
    DenseUniform {
        /// Minimum corner of the box.
        corner: [f32; 3],
        /// The distance that a stored 1.0 means.
        band_width: f32,
        /// Lengths of the box's sides.
        extent: [f32; 3],
        /// Edge of a voxel.
        voxel_size: f32,
        /// Samples along x.
        size_x: u32,
        /// Samples along y.
        size_y: u32,
        /// Samples along z.
        size_z: u32,
        /// Levels of detail, 1 without mips. Each has twice the band of the one before.
        levels: u32,
        /// Units for marching cubes along x.
        grid_x: u32,
        /// Units along y.
        grid_y: u32,
        /// Units along z.
        grid_z: u32,
        /// The code of 1.0.
        max_code: u32,
    }
}

shared_struct! {
    /// An octree of bricks in a box.
    OctreeUniform {
        /// Minimum corner of the box.
        corner: [f32; 3],
        /// The distance that a stored 1.0 means.
        band_width: f32,
        /// Lengths of the box's sides.
        extent: [f32; 3],
        /// Edge of a voxel.
        voxel_size: f32,
        /// Bricks along x.
        grid_x: u32,
        /// Bricks along y.
        grid_y: u32,
        /// Bricks along z.
        grid_z: u32,
        /// Voxels along a brick's side.
        brick_size_voxels: u32,
        /// Levels of nodes above the bricks.
        depth: u32,
        /// Number of Morton codes: 8 to the power of the depth.
        code_count: u32,
        /// A brick whose center is at most this far from the surface is kept.
        max_center_distance: f32,
        /// How much nearer to the surface a brick's samples can be than its center.
        sample_margin: f32,
    }
}

shared_struct! {
    /// Where the blocks of sparse bricks, and the words of their cells, are found. In a uniform it is at a multiple
    /// of 16 bytes.
    CellTable {
        /// The first block of the table's top along x.
        tree_x: i32,
        /// The first block of the table's top along y.
        tree_y: i32,
        /// The first block of the table's top along z.
        tree_z: i32,
        /// Levels of nodes below the top.
        levels: u32,
        /// Entries of the top along x.
        top_x: u32,
        /// Entries of the top along y.
        top_y: u32,
        /// Entries of the top along z.
        top_z: u32,
        /// Index of the first cells of slots among the cells' words, three words each.
        slots_at: u32,
        /// Index of the words of slots.
        words_at: u32,
        /// Cells of all slots.
        cells: u32,
        /// Zero.
        pad0: u32,
        /// Zero.
        pad1: u32,
    }
}

shared_struct! {
    /// Sparse bricks for readers: rays, marching cubes, and repacking.
    BrickUniform {
        /// Minimum corner of the box.
        corner: [f32; 3],
        /// The distance that a stored 1.0 means.
        band_width: f32,
        /// Lengths of the box's sides.
        extent: [f32; 3],
        /// Edge of a voxel.
        voxel_size: f32,
        /// Reciprocals of the pool's samples along each axis.
        inv_pool_size: [f32; 3],
        /// How much a distance can change over a voxel's edge.
        slope: f32,
        /// Voxels of the box along x.
        size_x: u32,
        /// Voxels of the box along y.
        size_y: u32,
        /// Voxels of the box along z.
        size_z: u32,
        /// Voxels along a brick's side.
        brick_size_voxels: u32,
        /// The first voxel of the box along x.
        begin_x: i32,
        /// The first voxel of the box along y.
        begin_y: i32,
        /// The first voxel of the box along z.
        begin_z: i32,
        /// Bricks that fit into the pool.
        capacity: u32,
        /// The first cell of the box along x.
        low_x: i32,
        /// The first cell of the box along y.
        low_y: i32,
        /// The first cell of the box along z.
        low_z: i32,
        /// Bricks of the pool along x.
        pool_x: u32,
        /// The cell after the last of the box along x.
        high_x: i32,
        /// The cell after the last of the box along y.
        high_y: i32,
        /// The cell after the last of the box along z.
        high_z: i32,
        /// Bricks of the pool along y.
        pool_y: u32,
        /// Where blocks and cells are found.
        table: CellTable,
        /// The code of 1.0.
        max_code: u32,
        /// Zero.
        pad0: u32,
        /// Zero.
        pad1: u32,
        /// Zero.
        pad2: u32,
    }
}

shared_struct! {
    /// Sparse bricks while some of their blocks are built.
    BrickBuildUniform {
        /// Minimum corner of the grid.
        corner: [f32; 3],
        /// Edge of a voxel.
        voxel_size: f32,
        /// The first cell of the box along x.
        low_x: i32,
        /// The first cell of the box along y.
        low_y: i32,
        /// The first cell of the box along z.
        low_z: i32,
        /// Voxels along a brick's side.
        brick_size_voxels: u32,
        /// The cell after the last of the box along x.
        high_x: i32,
        /// The cell after the last of the box along y.
        high_y: i32,
        /// The cell after the last of the box along z.
        high_z: i32,
        /// 1 if there are no bricks outside the box.
        is_clipped: u32,
        /// Where blocks and cells are found.
        table: CellTable,
        /// A cell whose center is at most this far from the surface may have a brick: half of its diagonal.
        max_center_distance: f32,
        /// Half of a voxel's diagonal.
        half_diagonal: f32,
        /// The field's Lipschitz constant.
        lipschitz: f32,
        /// The largest distance that an empty cell stores.
        far: f32,
        /// Bricks of the pool along x.
        pool_x: u32,
        /// Bricks of the pool along y.
        pool_y: u32,
        /// Bricks that fit into the pool.
        capacity: u32,
        /// Bricks that a dispatch samples.
        chunk: u32,
        /// Dispatches that sample bricks.
        chunks: u32,
        /// Mixed bricks that fit into the tables.
        mixed: u32,
        /// Zero.
        pad0: u32,
        /// Zero.
        pad1: u32,
    }
}

shared_struct! {
    /// Levels of detail for rays from one point.
    LevelsUniform {
        /// The camera's position in its voxel of level 0, in those voxels.
        eye_inner: [f32; 3],
        /// Edge of a voxel of level 0.
        voxel_size: f32,
        /// Minimum corner of the box.
        box_min: [f32; 3],
        /// How far an interpolated distance can be from the true one, in voxels.
        error_voxels: f32,
        /// Maximum corner of the box.
        box_max: [f32; 3],
        /// How much a distance can change over a voxel's edge, in voxels.
        steepness: f32,
        /// The voxel of level 0 that contains the camera, along x.
        eye_x: i32,
        /// The same along y.
        eye_y: i32,
        /// The same along z.
        eye_z: i32,
        /// The coarsest level.
        root: u32,
        /// The first voxel of level 0 along x.
        first_x: i32,
        /// The first voxel along y.
        first_y: i32,
        /// The first voxel along z.
        first_z: i32,
        /// Index of the pages' records among the cells' words.
        records_at: u32,
        /// The last voxel of level 0 along x.
        last_x: i32,
        /// The last voxel along y.
        last_y: i32,
        /// The last voxel along z.
        last_z: i32,
        /// Index of the bricks' materials among the cells' words.
        materials_at: u32,
        /// The first page of the coarsest level along x.
        root_x: i32,
        /// The first page along y.
        root_y: i32,
        /// The first page along z.
        root_z: i32,
        /// Index of the materials of mixed bricks among the cells' words.
        mixed_at: u32,
        /// Pages of the coarsest level along x.
        roots_x: u32,
        /// Pages along y.
        roots_y: u32,
        /// Pages along z.
        roots_z: u32,
        /// Bricks of the pool along x.
        pool_x: u32,
        /// Bricks of the pool along y.
        pool_y: u32,
        /// The size of a voxel that a ray accepts, in pixels.
        pixel_error: f32,
        /// The distance that a stored 1.0 means, in voxels.
        band_voxels: f32,
        /// Zero.
        pad0: u32,
    }
}
