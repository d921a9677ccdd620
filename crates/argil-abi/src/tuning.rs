//! Constants that tune passes in both languages.

use crate::declare::numbers;

numbers! { NUMBERS:
    /// The distance of an empty scene, and of points outside the world.
    FAR: f32 = 1e30;
    /// Points farther than this from the origin along an axis are outside the world, in the scene's unit.
    WORLD_LIMIT: f32 = 1e7;
    /// The share of the core's radius, around the axis of a wrapped solid, down to which its distances are used.
    WRAP_TRUSTED: f32 = 0.75;
    /// Bounds after which the nearest sphere of a tube with a changing radius is known.
    TAPER_STEPS: u32 = 4;
    /// The part of a length that such a bound must gain. If it gains less, the nearest sphere is known.
    SMALL_GAIN: f32 = 1e-6;
    /// A curve whose quadratic part has less than this part of its linear part's squared length is nearly straight.
    STRAIGHT_CURVE: f32 = 1e-3;
    /// Words of a spline tube's segment: its box and its curve.
    TUBE_WORDS: u32 = 17;
    /// Reciprocal of the tangent of the penumbra's half angle.
    SHADOW_SHARPNESS: f32 = 14.0;
    /// Maximum steps of a ray to the sun.
    SHADOW_STEPS: u32 = 64;
    /// Distances along the normal that determine occlusion.
    OCCLUSION_TAPS: u32 = 5;
    /// Normals for textures are differences over this part of a pattern's length.
    TEXTURE_NORMAL_STEP: f32 = 0.005;
    /// The sun's light, linear RGB.
    SUN_LIGHT: [f32; 3] = [3.3, 3.05, 2.65];
    /// The sky's light from above.
    ZENITH: [f32; 3] = [0.30, 0.45, 0.72];
    /// The sky's light from the horizon.
    HORIZON: [f32; 3] = [0.80, 0.86, 0.92];
    /// The light from below.
    NADIR: [f32; 3] = [0.44, 0.45, 0.47];
    /// Pixels along the side of a cone in which rays begin.
    CONE_SIDE: u32 = 8;
    /// Maximum steps of a cone.
    CONE_STEPS: u32 = 64;
    /// Distance from a block's center to the corners of its corner pixels, in pixels, and a little more.
    CONE_RADIUS: f32 = 5.7;
    /// A sample of at least this fraction of the band is saturated.
    SATURATED: f32 = 0.99;
    /// Below this fraction of the band, the next finer level, with half the band, is more precise.
    DENSE_NEAR: f32 = 0.28;
    /// Below this distance in voxels, a ray intersects the surface of its voxel.
    NEAR_VOXELS: f32 = 0.2;
    /// The weight of a mixed brick's point on another surface, relative to 1.
    MIN_WEIGHT: f32 = 1e-3;
    /// Multiple of the distance that decides whether a brick is mixed. Points of a mixed brick that are closer to the
    /// surface keep their own materials. Pruned programs give exact distances up to there.
    MATERIAL_OWN_RATIO: f32 = 1.48;
    /// Fraction of the largest over-relaxed step along a plane.
    RELAXATION: f32 = 0.9;
    /// Steps after which a ray through the field, which grazes something then, hits within a part of a pixel.
    EXACT_STEPS: u32 = 24;
    /// A ray that leaves a cell or a voxel advances by at least this many voxels, to be inside the next one.
    NUDGE_VOXELS: f32 = 1e-3;
    /// A ray that leaves a cell or a voxel also advances by this fraction of its length.
    NUDGE_RELATIVE: f32 = 5e-7;
    /// A ray that leaves a cell or a voxel also advances by this fraction of its position in voxels, because rounding
    /// grows with the position.
    NUDGE_POSITION: f32 = 2.5e-7;
    /// Marching-cubes units that one workgroup sums up.
    UNITS_PER_GROUP: u32 = 256;
    /// Minimum distance of a mesh's vertex from a sample, as a fraction of its edge.
    MIN_EDGE_FRACTION: f32 = 0.00390625;
    /// The top bit of a cell's word without a brick.
    WORD_EMPTY: u32 = 0x8000_0000;
    /// The bit of a word without a brick that says that its whole block has no brick.
    WORD_BLOCK_EMPTY: u32 = 1;
    /// Marks an entry of the block table that is neither block nor node: the index of a far slot follows.
    FAR_ENTRY: u32 = 0x8000_0000;
    /// Slots that no block has: far outside and far inside, for each level of the table.
    FAR_SLOTS: u32 = 16;
    /// No page of levels of detail: the parent of a page of the coarsest level, or the child of a cell that can have
    /// one.
    NO_PAGE: u32 = 0xffff_ffff;
    /// A cell's child below this is a page.
    UNKNOWN_CELL: u32 = 0xffff_fffd;
    /// The word of a cell whose brick is missing.
    MISSING_BRICK: u32 = 0x7fff_ffff;
    /// Voxels along the side of a page of levels, as a power of two.
    PAGE_VOXELS_LOG2: u32 = 4;
    /// Words of a page's record: its corner, level and parent, three words of padding, the words of its cells, and
    /// their children.
    RECORD_WORDS: u32 = 24;
    /// The first words of what rays used of levels: hits, and those that were too coarse.
    FEEDBACK_HEAD: u32 = 2;
    /// Words of what rays used of a page: its cells and those that are missing, and the missing pages of its cells.
    FEEDBACK_WORDS: u32 = 3;
    /// The part of the band up to which light takes a sample of a brick for a distance.
    LIGHT_KNOWN: f32 = 0.9;
    /// Texels along a row of the texture of light's tables.
    LIGHT_ROW: u32 = 1024;
    /// The first words of light's tables: whether there are any, the coarsest level, the edge of a voxel of the finest, the
    /// band in voxels, the first root and the number of roots along each axis, the first and the last voxel, and where the
    /// records of pages begin.
    LIGHT_HEAD: u32 = 24;
    /// Voxels of light in levels, in those of rays.
    LIGHT_VOXELS: f32 = 2.0;
    /// The shortest step of a shadow's ray through levels, in voxels of light.
    MIN_STEP_VOXELS: f32 = 0.25;
    /// How far above the surface of levels light is gathered, in voxels of rays.
    LIFT_VOXELS: f32 = 1.5;
    /// Voxels of cones in levels, in those of rays.
    CONE_VOXELS: f32 = 2.0;
    /// Set in the id of a hit in levels, less 1, where a finer brick is missing. The lower bits are the level.
    LEVEL_MISSING: u32 = 64;
    /// The part of a level over which its border with the next one is dithered.
    LEVEL_DITHER: f32 = 0.3;
}
