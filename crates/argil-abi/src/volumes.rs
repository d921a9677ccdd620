//! The uniforms by which shaders read volumes, one for each kind.

use crate::declare::shared_struct;

shared_struct! {
    /// A dense volume of stored distances over a box.
    DenseVolume {
        /// Least corner of the box.
        corner: [f32; 3],
        /// The length that a stored 1.0 stands for.
        range: f32,
        /// Lengths of the box's sides.
        extent: [f32; 3],
        /// The edge of a voxel.
        voxel: f32,
        /// Texels along x.
        size_x: u32,
        /// Texels along y.
        size_y: u32,
        /// Texels along z.
        size_z: u32,
        /// Levels of detail, 1 without mips; each has twice the range of the one before.
        levels: u32,
        /// Units of cells that are cut into triangles at once, along x.
        grid_x: u32,
        /// Such units along y.
        grid_y: u32,
        /// Such units along z.
        grid_z: u32,
        /// The stored integer of 1.0.
        quanta: u32,
    }
}

shared_struct! {
    /// An octree of bricks in a box.
    OctreeVolume {
        /// Least corner of the box.
        corner: [f32; 3],
        /// The length that a stored 1.0 stands for.
        range: f32,
        /// Lengths of the box's sides.
        extent: [f32; 3],
        /// The edge of a voxel.
        voxel: f32,
        /// Bricks along x.
        grid_x: u32,
        /// Bricks along y.
        grid_y: u32,
        /// Bricks along z.
        grid_z: u32,
        /// Voxels along a brick's side.
        brick: u32,
        /// Levels of nodes above the bricks.
        depth: u32,
        /// Morton codes there are: 8 to the depth.
        code_count: u32,
        /// A brick whose center is no farther than this from the surface is kept.
        reach: f32,
        /// By how much a brick's texels can be nearer to the surface than its center.
        spread: f32,
    }
}

shared_struct! {
    /// Where the blocks of sparse bricks, and the words of their cells, are found. In a uniform it stands at a multiple of 16 bytes.
    CellTable {
        /// The first block of the top of the tree of blocks along x.
        tree_x: i32,
        /// The first block of the top of the tree of blocks along y.
        tree_y: i32,
        /// The first block of the top of the tree of blocks along z.
        tree_z: i32,
        /// Levels of nodes below the top.
        levels: u32,
        /// Entries of the top along x.
        top_x: u32,
        /// Entries of the top along y.
        top_y: u32,
        /// Entries of the top along z.
        top_z: u32,
        /// Where the first cells of slots stand among the cells' words, three each.
        slots_at: u32,
        /// Where the words of slots stand.
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
    /// Sparse bricks as they are read: by rays, for triangles, to be moved.
    BrickVolume {
        /// Least corner of the box.
        corner: [f32; 3],
        /// The length that a stored 1.0 stands for.
        range: f32,
        /// Lengths of the box's sides.
        extent: [f32; 3],
        /// The edge of a voxel.
        voxel: f32,
        /// One over the pool's texels along each axis.
        per_texel: [f32; 3],
        /// What a distance can change by over a voxel's edge.
        slope: f32,
        /// Voxels of the box along x.
        size_x: u32,
        /// Voxels of the box along y.
        size_y: u32,
        /// Voxels of the box along z.
        size_z: u32,
        /// Voxels along a brick's side.
        brick: u32,
        /// The first voxel of the box along x.
        begin_x: i32,
        /// The first voxel of the box along y.
        begin_y: i32,
        /// The first voxel of the box along z.
        begin_z: i32,
        /// Bricks that the pool has room for.
        capacity: u32,
        /// The first cell of the box along x.
        low_x: i32,
        /// The first cell of the box along y.
        low_y: i32,
        /// The first cell of the box along z.
        low_z: i32,
        /// Bricks of the pool along x.
        pool_x: u32,
        /// The cell behind the last of the box along x.
        high_x: i32,
        /// The cell behind the last of the box along y.
        high_y: i32,
        /// The cell behind the last of the box along z.
        high_z: i32,
        /// Bricks of the pool along y.
        pool_y: u32,
        /// Where blocks and cells are found.
        table: CellTable,
        /// The stored integer of 1.0.
        quanta: u32,
        /// Zero.
        pad0: u32,
        /// Zero.
        pad1: u32,
        /// Zero.
        pad2: u32,
    }
}

shared_struct! {
    /// Sparse bricks while some of their blocks are made.
    BrickBuild {
        /// Least corner of the lattice.
        corner: [f32; 3],
        /// The edge of a voxel.
        voxel: f32,
        /// The first cell of the box along x.
        low_x: i32,
        /// The first cell of the box along y.
        low_y: i32,
        /// The first cell of the box along z.
        low_z: i32,
        /// Voxels along a brick's side.
        brick: u32,
        /// The cell behind the last of the box along x.
        high_x: i32,
        /// The cell behind the last of the box along y.
        high_y: i32,
        /// The cell behind the last of the box along z.
        high_z: i32,
        /// 1 if there are no bricks outside of the box.
        is_cut: u32,
        /// Where blocks and cells are found.
        table: CellTable,
        /// A cell whose center is no farther than this from the surface may have a brick: half of its diagonal.
        reach: f32,
        /// Half of a voxel's diagonal.
        half_diagonal: f32,
        /// The field's Lipschitz constant.
        lipschitz: f32,
        /// The same with room for rounding.
        steepness: f32,
        /// The greatest distance that a cell without a brick keeps.
        far: f32,
        /// Bricks of the pool along x.
        pool_x: u32,
        /// Bricks of the pool along y.
        pool_y: u32,
        /// Bricks that the pool has room for.
        capacity: u32,
        /// Bricks that a dispatch samples.
        chunk: u32,
        /// Dispatches that sample bricks.
        chunks: u32,
        /// Mixed bricks that there is room for.
        mixed: u32,
        /// Zero.
        pad0: u32,
    }
}
