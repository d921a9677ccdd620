//! Opcodes and flags of programs. `argil-field` defines what they do.

use crate::declare::constants;

constants! { OPCODES:
    /// The first opcode of the shapes that search for the nearest of many points. Those with lower opcodes evaluate a
    /// formula. The table of shapes assigns the opcodes.
    OP_FIRST_ITERATIVE = 48;
    /// One more than the last shape's opcode.
    OP_SHAPES_END = 64;
    /// Saves the accumulator and starts an empty one.
    OP_PUSH_VALUE = 64;
    /// Combines the saved accumulator with the current one.
    OP_COMBINE = 65;
    /// Saves the point.
    OP_PUSH_POINT = 66;
    /// Restores the saved point.
    OP_POP_POINT = 67;
    /// Maps the point by an affine map.
    OP_AFFINE = 68;
    /// Folds the point into the positive side of some axes.
    OP_MIRROR = 69;
    /// Moves the point toward the origin by a half length per axis.
    OP_ELONGATE = 70;
    /// Begins a loop over the nearest cells of a grid of copies.
    OP_REPEAT = 71;
    /// Begins a loop over the nearest sectors of a ring of copies.
    OP_RADIAL = 72;
    /// Ends either loop.
    OP_NEXT = 73;
    /// Clamps the point into a box, then twists it about the y axis.
    OP_TWIST = 74;
    /// Clamps the point into a box, then bends it in the x–y plane.
    OP_BEND = 75;
    /// Reverses the clamp of a twist or bend: adds the point's distance to the box.
    OP_UNCLAMP = 76;
    /// Moves the surface outward.
    OP_ROUND = 77;
    /// Keeps a shell around the surface.
    OP_SHELL = 78;
    /// Adds seeded value noise.
    OP_DISPLACE = 79;
    /// Saves the point, and moves it to the section at z = 0.
    OP_FLATTEN = 80;
    /// Restores the point, and ends the section's distances along z.
    OP_EXTRUDE = 81;
    /// Turns the point about the y axis into the section at z = 0.
    OP_REVOLVE = 82;
    /// Moves the point by a share of a vector that follows a ramp.
    OP_SHIFT = 83;
    /// Saves the point, and unrolls the space around the y axis.
    OP_WRAP = 84;
    /// Restores the point, and bounds the distance near the axis.
    OP_UNWRAP = 85;
    /// Evaluates a ramp at the point, for the next morph.
    OP_RAMP = 86;
}

constants! { FLAGS:
    /// How an operator combines, in the low three bits of the flags: `sr * (min(sa * a, sb * b) − blend)`.
    COMBINE_SMOOTH = 0;
    /// The same with a chamfer instead of a smooth blend.
    COMBINE_CHAMFER = 1;
    /// Keeps `a`, and takes the material of `b` where `b` is inside.
    COMBINE_PAINT = 2;
    /// `a + (b − a) * t`.
    COMBINE_MORPH = 3;
    /// The same where `t` follows a ramp, with a clamped difference, divided by a bound of the slope.
    COMBINE_RAMPED = 4;
    /// The bits of these values.
    COMBINE_MASK = 7;
    /// The accumulator is `a` and the saved value is `b`, instead of the reverse.
    FLAG_SWAPPED = 8;
    /// The material of `a` stays, for a cut without a material of its own.
    FLAG_KEEP_MATERIAL = 16;
    /// The map from the point to the shape is a translation, and the scale is 1.
    FLAG_TRANSLATION = 32;
    /// `PUSH_VALUE` of a union with a bound: a sphere and a factor, five parameters. At a point, the union's distance is
    /// at least the distance to the sphere times the factor.
    FLAG_BOUNDED = 64;
    /// `PUSH_VALUE` before paint, which distances do without.
    FLAG_PAINT = 128;
    /// From this bit on, a brush's flags hold the place of its material's textures in the table of materials, or 0.
    TEXTURES_SHIFT = 8;
    /// Words before a shape's own parameters: 12 of an affine map, then scale, k, 1/(4k), sa, sb, sr.
    BRUSH_HEADER_WORDS = 18;
    /// An instruction's parameters begin at a multiple of this, so that a device can load as many at once.
    PARAMS_ALIGNMENT = 4;
    /// A word of a list for three points at once: the bits of its opcode.
    COLUMN_OPCODE_MASK = 127;
    /// The map from the points to the shape is a translation, and the scale is 1.
    COLUMN_TRANSLATION = 128;
    /// The shape is added.
    COLUMN_UNION = 256;
    /// The accumulator is `a` and the saved value is `b`, instead of the reverse.
    COLUMN_SWAPPED = 512;
    /// A translation of a shape whose points then share most of their work.
    COLUMN_QUICK = 1024;
    /// The position of the record at which the parameters begin.
    COLUMN_RECORD_SHIFT = 12;
    /// Words of a path's segment: kind, three points, one spare.
    PIECE_WORDS = 8;
    /// Words of the head of a sampled grid's level.
    SAMPLED_HEADER = 8;
    /// Words of a sampled grid after the heads of its levels.
    SAMPLED_SUMMARY = 16;
    /// What to render: light and materials.
    MODE_SHADED = 0;
    /// Normals as colors.
    MODE_NORMAL = 1;
    /// Distance along the ray.
    MODE_DEPTH = 2;
    /// Steps as blue, green, yellow, red.
    MODE_HEAT = 3;
    /// The first brick of each ray.
    MODE_BRICKS = 4;
    /// The first node above bricks of each ray.
    MODE_NODES = 5;
    /// The level of each hit, and where a finer one is missing.
    MODE_LEVELS = 6;
    /// Points with a material along a mixed brick's side.
    MATERIAL_SIDE = 4;
    /// Flag of a brick's material: it is mixed.
    BRICK_MIXED = 2147483648;
    /// Cells along the side of a block.
    BLOCK_SIDE = 4;
    /// Build bricks in some blocks, and replace what was there.
    BUILD_BLOCKS = 0;
    /// Only count the bricks that the given blocks would need, and write none.
    BUILD_COUNT_ONLY = 1;
    /// Counts the cells that the surface can pass through.
    COUNTER_CANDIDATES = 0;
    /// Counts the bricks that were taken from the pool.
    COUNTER_BRICKS = 1;
    /// Counts the mixed bricks that were taken from the pool.
    COUNTER_MIXED = 2;
    /// Counts the words of pruned programs.
    COUNTER_LISTS = 3;
    /// Counts the bricks that return to the pool after the build.
    COUNTER_FREED = 4;
    /// Counts the mixed bricks that return to the pool after the build.
    COUNTER_FREED_MIXED = 5;
    /// Counts the free slots below the high-water mark. A stack behind the counters lists them.
    COUNTER_FREE = 6;
    /// Counts the free slots of mixed bricks. Their stack follows the other.
    COUNTER_FREE_MIXED = 7;
    /// The high-water mark of the pool: slots that were ever taken.
    COUNTER_HIGH_WATER = 8;
    /// The high-water mark of mixed bricks.
    COUNTER_HIGH_WATER_MIXED = 9;
    /// Counts the bricks that were ever sampled, modulo 2³².
    COUNTER_FILLED = 10;
    /// Counts the bricks that were ever added to cells without one, modulo 2³².
    COUNTER_ADDED = 11;
    /// Counts the bricks that were ever removed, modulo 2³².
    COUNTER_REMOVED = 12;
    /// Number of counters.
    COUNTERS = 16;
    /// Normals of bricks: the gradient of the samples in the voxel.
    NORMALS_VOXEL = 0;
    /// Normals of bricks: differences of samples over one voxel.
    NORMALS_SMOOTH = 1;
    /// Normals of bricks: the gradient of the field.
    NORMALS_FIELD = 2;
    /// The ray hit nothing.
    HIT_NONE = 0;
    /// The ray hit the surface from outside.
    HIT_OUTSIDE = 1;
    /// The ray started in a solid and hit its surface from inside.
    HIT_INSIDE = 2;
    /// The ray hit the ground plane.
    HIT_GROUND = 3;
    /// The ray has hit nothing yet, and continues in the next dispatch.
    HIT_PENDING = 4;
    /// The bits of a stored hit's normal that carry its kind: numbers below 2 leave them free.
    HIT_KIND_BIT = 1073741824;
    /// Stored of the rays: hits.
    RECORD_HITS = 1;
    /// Stored of the rays: also what they did.
    RECORD_COUNTS = 2;
    /// Slots of the GPU interpreter's stacks of values and of points.
    GPU_STACK_SLOTS = 32;
    /// Each look-up in the octree starts at the root.
    DESCENT_ROOT = 0;
    /// A look-up starts at the deepest node that it shares with the previous one.
    DESCENT_PATH = 1;
    /// Maximum levels of an octree's nodes.
    OCTREE_MAX_DEPTH = 8;
    /// Word of an octree's header: the number of bricks.
    OCTREE_HEADER_BRICKS = 0;
    /// Word of an octree's header: the number of nodes.
    OCTREE_HEADER_NODES = 1;
    /// First of the words of an octree's header that say where each level begins among the nodes. The level of the
    /// bricks' parents comes first.
    OCTREE_HEADER_LEVELS = 2;
    /// Number of words of an octree's header.
    OCTREE_HEADER_WORDS = 16;
    /// Vertices of a mesh: no normals.
    MARCH_NONE = 0;
    /// Vertices of a mesh: normals from the gradient of the samples.
    MARCH_GRADIENT = 1;
    /// Vertices of a mesh: normals from the gradient of the field.
    MARCH_FIELD = 2;
    /// Vertices of a mesh: the normals of the triangles, if vertices are not shared.
    MARCH_FACE = 3;
    /// Workgroups in a row of a dispatch over a list.
    DISPATCH_ROW = 32768;
}
