//! Opcodes and flags of a field program. See `argil-field` for what each does to the interpreter's registers.

use crate::declare::constants;

constants! { OPCODES:
    /// Combine a shape with the accumulator: of opcodes below, those that are measured point by point. Which they are, the table of
    /// shapes says.
    OP_SEARCHED = 48;
    /// One more than the last shape's: those from `OP_SEARCHED` on search for what is nearest.
    OP_SHAPES_END = 64;
    /// Save the accumulator and start an empty one.
    OP_PUSH_VALUE = 64;
    /// Combine the saved accumulator with the current one.
    OP_COMBINE = 65;
    /// Save the point.
    OP_PUSH_POINT = 66;
    /// Bring the saved point back.
    OP_POP_POINT = 67;
    /// Map the point by an affine map.
    OP_AFFINE = 68;
    /// Fold the point into the positive side of some axes.
    OP_MIRROR = 69;
    /// Pull the point towards the middle by a half length an axis.
    OP_ELONGATE = 70;
    /// Begin a loop over the nearest cells of a grid of copies.
    OP_REPEAT = 71;
    /// Begin a loop over the nearest sectors of a ring of copies.
    OP_RADIAL = 72;
    /// End either loop.
    OP_NEXT = 73;
    /// Clamp the point into a box, then twist it about the y axis.
    OP_TWIST = 74;
    /// Clamp the point into a box, then bend it in the x–y plane.
    OP_BEND = 75;
    /// Undo the clamp of a twist or bend: add what the point lies outside its box.
    OP_UNCLAMP = 76;
    /// Move the surface outwards.
    OP_ROUND = 77;
    /// Keep a shell around the surface.
    OP_SHELL = 78;
    /// Add seeded value noise.
    OP_DISPLACE = 79;
}

constants! { FLAGS:
    /// How a combination works, the low three bits of the flags: `sr * (min(sa * a, sb * b) − blend)`.
    COMBINE_SMOOTH = 0;
    /// The same with a chamfer for the blend.
    COMBINE_CHAMFER = 1;
    /// Keep `a`, take the material of `b` where `b` is inside.
    COMBINE_PAINT = 2;
    /// `a + (b − a) * t`.
    COMBINE_MORPH = 3;
    /// The bits of the above.
    COMBINE_MASK = 7;
    /// The accumulator is `a` and the saved value `b`, not the other way round.
    FLAG_SWAPPED = 8;
    /// The material of `a` stays (a cut without a material of its own).
    FLAG_KEEP_MATERIAL = 16;
    /// The map from the point to the shape is a translation, and the scale is 1.
    FLAG_TRANSLATION = 32;
    /// Words before a shape's own parameters: 12 of an affine map, then scale, k, 1/(4k), sa, sb, sr.
    BRUSH_HEADER_WORDS = 18;
    /// Words a piece of an outline takes: kind, three points, one spare.
    PIECE_WORDS = 8;
    /// Words of a sampled grid before its table of cells.
    SAMPLED_HEADER = 8;
    /// Samples' intervals along the side of a cell that has fine ones.
    SAMPLED_SIDE = 8;
    /// What to draw: shaded.
    SHOW_SHADED = 0;
    /// Normals as colors.
    SHOW_NORMAL = 1;
    /// Distance along the ray.
    SHOW_DEPTH = 2;
    /// Steps as blue → green → yellow → red.
    SHOW_HEAT = 3;
    /// The first brick of each ray.
    SHOW_BRICKS = 4;
    /// The first node above bricks of each ray.
    SHOW_NODES = 5;
    /// Places along a mixed brick's side that have a material.
    MATERIAL_SIDE = 4;
    /// Of a brick's material: it is mixed.
    BRICK_MIXED = 2147483648;
    /// Cells along the side of a block of sparse bricks' grid.
    BLOCK_SIDE = 4;
    /// Bricks are made in some blocks, in place of what was there.
    MAKE_SOME = 0;
    /// In none: it is counted what some blocks would need.
    MAKE_NONE = 1;
    /// Of what makes bricks: the counter of cells that the surface can be in.
    COUNTER_CANDIDATES = 0;
    /// The counter of bricks that were taken from the pool.
    COUNTER_BRICKS = 1;
    /// The same of mixed ones.
    COUNTER_MIXED = 2;
    /// The counter of words that lists have taken.
    COUNTER_LISTS = 3;
    /// The counter of bricks that are given back to the pool when all are made.
    COUNTER_FREED = 4;
    /// The same of mixed ones.
    COUNTER_FREED_MIXED = 5;
    /// Places of the pool that are free among those that were ever taken: as many are stacked behind the counters.
    COUNTER_FREE = 6;
    /// The same of mixed ones, which are stacked behind those.
    COUNTER_FREE_MIXED = 7;
    /// Places of the pool that were ever taken.
    COUNTER_TOP = 8;
    /// The same of mixed ones.
    COUNTER_TOP_MIXED = 9;
    /// Bricks that were ever sampled, modulo 2³².
    COUNTER_FILLED = 10;
    /// Bricks that ever came to be in cells without one.
    COUNTER_ADDED = 11;
    /// Bricks that were ever removed.
    COUNTER_REMOVED = 12;
    /// All counters.
    COUNTERS = 16;
    /// Normals of bricks: the gradient in the voxel.
    NORMALS_VOXEL = 0;
    /// Differences over a voxel's width.
    NORMALS_SMOOTH = 1;
    /// Those of the field.
    NORMALS_FIELD = 2;
    /// What a ray found: nothing.
    HIT_NONE = 0;
    /// The surface, seen from outside.
    HIT_OUTSIDE = 1;
    /// The surface, seen from inside a solid.
    HIT_INSIDE = 2;
    /// The ground plane.
    HIT_GROUND = 3;
    /// Nothing yet: the GPU's march goes on in the next dispatch.
    HIT_UNDER_WAY = 4;
    /// Slots of the GPU interpreter's stacks of values and of points.
    GPU_STACK_SLOTS = 32;
    /// Each look-up in the tree begins at the root.
    DESCENT_ROOT = 0;
    /// A look-up begins at the deepest node that it shares with the one before.
    DESCENT_PATH = 1;
    /// Most levels of nodes of an octree.
    OCTREE_MAX_DEPTH = 8;
    /// Words of the table that tells of a tree: the number of bricks.
    TREE_BRICKS = 0;
    /// The number of nodes.
    TREE_NODES = 1;
    /// The first of as many words as there are levels: where each begins among the nodes, the parents of bricks first.
    TREE_LEVELS = 2;
    /// All words of that table.
    TREE_WORDS = 16;
    /// Vertices of a march have no normals.
    MARCH_NONE = 0;
    /// They have the samples' gradient.
    MARCH_GRADIENT = 1;
    /// The field's.
    MARCH_FIELD = 2;
    /// Triangles with vertices of their own have theirs.
    MARCH_FACE = 3;
    /// Workgroups in a row of a dispatch over a list.
    DISPATCH_ROW = 32768;
}
