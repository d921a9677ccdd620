//! Numbers that passes of both languages are tuned by.

use crate::declare::numbers;

numbers! { NUMBERS:
    /// The distance of nothing, and of points that are not in the world.
    FAR: f32 = 1e30;
    /// Points farther than this from the origin along an axis are not in the world, in the scene's unit.
    WORLD_LIMIT: f32 = 1e7;
    /// Newton steps of a search along a curve, after its samples.
    NEWTON_STEPS: u32 = 4;
    /// Intervals that a piece of an outline is sampled at.
    PIECE_SAMPLES: u32 = 4;
    /// Intervals that a tube's curve is sampled at.
    TUBE_SAMPLES: u32 = 8;
    /// Words of a piece of a spline tube: its box, its curve.
    TUBE_WORDS: u32 = 17;
    /// One over the tangent of the penumbra's half angle.
    SHADOW_SHARPNESS: f32 = 14.0;
    /// Distances along the normal that tell of occlusion.
    OCCLUSION_TAPS: u32 = 5;
    /// The sun's light, linear RGB.
    SUN_LIGHT: [f32; 3] = [3.3, 3.05, 2.65];
    /// The sky's light from above.
    ZENITH: [f32; 3] = [0.30, 0.45, 0.72];
    /// From the horizon.
    HORIZON: [f32; 3] = [0.80, 0.86, 0.92];
    /// From below.
    BELOW: [f32; 3] = [0.44, 0.45, 0.47];
    /// Pixels along the side of a cone that rays begin as.
    CONE_SIDE: u32 = 8;
    /// Most steps of a cone.
    CONE_STEPS: u32 = 64;
    /// From a block's center to the corners of its corner pixels, in pixels, and a little more.
    CONE_RADIUS: f32 = 5.7;
    /// A sample of at least this share of the band is saturated.
    SATURATED: f32 = 0.99;
    /// Below this share of the band, the level beneath, of half the band, tells the distance more closely.
    DENSE_NEAR: f32 = 0.28;
    /// Nearer than this many voxels a ray looks for the surface in its voxel.
    NEAR_VOXELS: f32 = 0.2;
    /// A ray that a pixel's footprint ends is so many voxels within what is stored, at least.
    BRICK_MARGIN_VOXELS: f32 = 2.5;
    /// The weight of a mixed brick's place that is on another surface, of 1.
    LEAST_WEIGHT: f32 = 1e-3;
    /// How far a mixed brick's places keep their own materials, of the distance that decides whether it is mixed: within half of its
    /// diagonal, as far as lists tell.
    MATERIAL_TOLD: f32 = 1.48;
    /// How much of what spheres along a plane allow a ray goes beyond its own.
    RELAXATION: f32 = 0.9;
    /// A ray that leaves a cell or a voxel goes so many voxels farther, to be in the next,
    NUDGE_VOXELS: f32 = 1e-3;
    /// so much of its length,
    NUDGE_SHARE: f32 = 5e-7;
    /// and so much of its place in voxels, in a world so wide that rounding is more than that.
    NUDGE_PLACE: f32 = 2.5e-7;
    /// Units of a march that one workgroup adds up.
    UNITS_A_GROUP: u32 = 256;
    /// No vertex of a mesh is nearer to a sample than this share of its edge.
    NEAREST_ON_EDGE: f32 = 0.00390625;
    /// The top bit of a cell's word without a brick.
    WORD_EMPTY: u32 = 0x8000_0000;
    /// Of such a word: whether its whole block has no brick.
    WORD_LONELY: u32 = 1;
    /// An entry of the table of blocks that is no block and no node: the slot of far words behind it.
    FAR_ENTRY: u32 = 0x8000_0000;
    /// Slots that no block has: for each level of that table, far outside and far inside.
    FAR_SLOTS: u32 = 16;
}
