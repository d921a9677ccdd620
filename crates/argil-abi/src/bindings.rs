//! Where each table is bound, all in group 0.

use crate::declare::constants;

constants! { BINDINGS:
    /// What a frame is drawn by.
    BIND_FRAME = 0;
    /// A program's instructions.
    BIND_INSTRS = 1;
    /// Words that they point into.
    BIND_PARAMS = 2;
    /// The scene's materials.
    BIND_MATERIALS = 3;
    /// What rays have met.
    BIND_HITS = 4;
    /// Samples' colors.
    BIND_COLORS = 5;
    /// Points that are asked about.
    BIND_QUERIES = 6;
    /// What is told of them.
    BIND_ANSWERS = 7;
    /// How a volume lies and is read.
    BIND_VOLUME = 8;
    /// Its texels.
    BIND_STORED = 9;
    /// How they are filtered.
    BIND_LINEAR = 10;
    /// An octree's nodes.
    BIND_NODES = 11;
    /// An octree's words.
    BIND_TREE_WORDS = 12;
    /// What is to be sampled.
    BIND_FILL = 13;
    /// Where samples go.
    BIND_TEXELS = 14;
    /// An octree's nodes with a surface.
    BIND_OCCUPIED = 15;
    /// Distances at nodes' centers.
    BIND_CENTERS = 16;
    /// Nodes' keys.
    BIND_KEYS = 17;
    /// Sizes of dispatches that the device itself decides.
    BIND_ARGUMENTS = 18;
    /// Words of cells.
    BIND_CELLS = 19;
    /// What bricks look like.
    BIND_BRICK_MATERIALS = 20;
    /// Cells near the surface.
    BIND_CANDIDATES = 21;
    /// What has been taken.
    BIND_COUNTERS = 22;
    /// Blocks of pixels that their cones have left.
    BIND_LIVE = 23;
    /// Lists of instructions.
    BIND_LISTS = 24;
    /// How lists are cut.
    BIND_PRUNE = 25;
    /// What bricks looked like before they were packed.
    BIND_OLD_MATERIALS = 26;
    /// Where they were.
    BIND_OLD_POOL = 27;
    /// A picture of triangles.
    BIND_DRAWN = 28;
    /// How triangles are made.
    BIND_MARCHING = 29;
    /// Cases of marching cubes.
    BIND_CASES = 30;
    /// Bricks' cells.
    BIND_OWNERS = 31;
    /// Units of a march.
    BIND_UNITS = 32;
    /// Sums of them.
    BIND_UNIT_GROUPS = 33;
    /// Sums of rows of edges.
    BIND_EDGE_ROWS = 34;
    /// A mesh's corners.
    BIND_VERTICES = 35;
    /// Its triangles.
    BIND_TRIANGLES = 36;
    /// Edges that corners lie on.
    BIND_SPANS = 37;
    /// Corners of their own for each triangle.
    BIND_SPREAD = 38;
    /// A picture's bytes, four a pixel.
    BIND_PIXELS = 39;
    /// What its rays did.
    BIND_COUNTS = 40;
}
