//! Binding numbers, all in group 0.

use crate::declare::constants;

constants! { BINDINGS:
    /// The uniform of a frame.
    BIND_FRAME = 0;
    /// A program's instructions.
    BIND_INSTRS = 1;
    /// The words that instructions refer to.
    BIND_PARAMS = 2;
    /// The scene's materials.
    BIND_MATERIALS = 3;
    /// What rays hit.
    BIND_HITS = 4;
    /// Colors of samples.
    BIND_COLORS = 5;
    /// Points to evaluate.
    BIND_QUERIES = 6;
    /// Results at those points.
    BIND_ANSWERS = 7;
    /// The uniform of a volume.
    BIND_VOLUME = 8;
    /// The samples of a volume.
    BIND_STORED = 9;
    /// The sampler that filters them.
    BIND_LINEAR = 10;
    /// An octree's nodes.
    BIND_NODES = 11;
    /// An octree's table of counts and levels.
    BIND_TREE_WORDS = 12;
    /// The uniform of a fill.
    BIND_FILL = 13;
    /// The texture that samples are written to.
    BIND_TEXELS = 14;
    /// An octree's cells that contain a surface.
    BIND_OCCUPIED = 15;
    /// Distances at the centers of an octree's cells.
    BIND_CENTERS = 16;
    /// Keys of an octree's bricks.
    BIND_KEYS = 17;
    /// Dispatch sizes that the device computes.
    BIND_ARGUMENTS = 18;
    /// Words of cells.
    BIND_CELLS = 19;
    /// Materials of bricks.
    BIND_BRICK_MATERIALS = 20;
    /// Cells near the surface.
    BIND_CANDIDATES = 21;
    /// Counters of the pool.
    BIND_COUNTERS = 22;
    /// Blocks of pixels whose rays are still active.
    BIND_REQUESTS = 23;
    /// Lists of instructions.
    BIND_LISTS = 24;
    /// The uniform of pruning.
    BIND_PRUNE = 25;
    /// Materials of bricks before they were repacked.
    BIND_OLD_MATERIALS = 26;
    /// The pool before it was repacked.
    BIND_OLD_POOL = 27;
    /// A rasterized image of triangles.
    BIND_RASTER = 28;
    /// The uniform of marching cubes.
    BIND_MARCHING = 29;
    /// The cases of marching cubes.
    BIND_CASES = 30;
    /// The cell of each brick.
    BIND_OWNERS = 31;
    /// Units of marching cubes.
    BIND_UNITS = 32;
    /// Sums of units.
    BIND_UNIT_GROUPS = 33;
    /// Sums of rows of edges.
    BIND_EDGE_ROWS = 34;
    /// A mesh's vertices.
    BIND_VERTICES = 35;
    /// A mesh's triangles.
    BIND_TRIANGLES = 36;
    /// The edges of vertices.
    BIND_SPANS = 37;
    /// Vertices of an unindexed mesh.
    BIND_UNINDEXED = 38;
    /// An image's bytes, four per pixel.
    BIND_PIXELS = 39;
    /// Histograms of what an image's rays did.
    BIND_COUNTS = 40;
    /// What rays used of levels of detail, and what they lacked.
    BIND_FEEDBACK = 41;
    /// Light: the tables of coarse levels, as a texture of words.
    BIND_LIGHT_WORDS = 42;
    /// Light: the bricks of coarse levels.
    BIND_LIGHT_STORED = 43;
    /// The uniform of path tracing.
    BIND_PATHS = 44;
    /// Paths on their way.
    BIND_PATH_STATES = 45;
    /// What the paths of each pixel found.
    BIND_PATH_PIXELS = 46;
    /// Lights, and tables of their light.
    BIND_PATH_TABLES = 47;
    /// The image behind everything.
    BIND_ENVIRONMENT = 48;
    /// The colors of an image that stays on the device.
    BIND_KEPT_COLORS = 49;
    /// Its distances.
    BIND_KEPT_DISTANCES = 50;
    /// Brushes that moved.
    BIND_MOVED = 51;
    /// The way of each pixel's point.
    BIND_MOTIONS = 52;
}
