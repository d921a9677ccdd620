//! Path tracing.

use crate::declare::{constants, shared_struct};

constants! { PATHS:
    /// A path that did not begin.
    PATH_NEW = 0;
    /// Its ray to a light is marched.
    PATH_SHADOW = 1;
    /// Its ray to the next surface is marched.
    PATH_RAY = 2;
    /// Its ray met a solid.
    PATH_MET = 3;
    /// Its ray met something opaque inside of glass.
    PATH_INSIDE = 4;
    /// Its ray met no solid.
    PATH_MISSED = 5;
    /// It ended after its ray to a light.
    PATH_ENDED = 6;
    /// All paths of the pixel ended.
    PATH_DONE = 7;
    /// Maximum steps of a path's ray.
    PATH_STEPS = 4096;
    /// Surfaces that a path passes before chance decides how it goes on.
    CERTAIN_BOUNCES = 3;
    /// Places of the table of what rough mirrors reflect, along the cosine and along the roughness.
    ALBEDO_SIDE = 32;
    /// A disc in the sky.
    LIGHT_SUN = 0;
    /// A sphere.
    LIGHT_SPHERE = 1;
    /// A rectangle that shines on one side.
    LIGHT_RECTANGLE = 2;
    /// The image behind everything.
    LIGHT_ENVIRONMENT = 3;
    /// Lamps of an image without paths.
    MAX_LAMPS = 8;
    /// Steps of a ray through fog to a lamp.
    LAMP_STEPS = 48;
    /// Steps of each half of a ray from a surface to a lamp. A software device takes half as many.
    LAMP_SHADOW_STEPS = 48;
    /// Points of a lamp that rays lead to where the lamp is half hidden.
    LAMP_POINTS = 16;
    /// Layers of an image's buffer of colors: the colors, the shares of lamps, light in fog, and bent normals.
    COLOR_LAYERS = 5;
    /// The layer of light in fog.
    FOG_LAYER = 3;
    /// The layer of bent normals.
    BENT_LAYER = 4;
    /// Places along a ray where light in fog is gathered.
    FOG_PLACES = 8;
    /// A fit of the Academy Color Encoding System.
    TONE_ACES = 0;
    /// AgX.
    TONE_AGX = 1;
    /// Light above 1 is cut.
    TONE_NONE = 2;
    /// Behind everything is the sky of the other integrator.
    BACKGROUND_SKY = 0;
    /// The same light from everywhere.
    BACKGROUND_EVEN = 1;
    /// An image.
    BACKGROUND_IMAGE = 2;
}

/// Rows of all lamps.
pub const LAMP_ROWS: usize = 4 * MAX_LAMPS as usize;

shared_struct! {
    /// What all paths of a dispatch share.
    PathUniform {
        /// The light from everywhere, if it is the same.
        even: [f32; 3],
        /// A `BACKGROUND_…`.
        background: u32,
        /// The most light that a path may bring after its first surface.
        clamp: f32,
        /// Factor of the environment's image.
        environment_strength: f32,
        /// How far that is turned, in radians.
        environment_turn: f32,
        /// Its width in pixels.
        environment_width: u32,
        /// Its height in pixels.
        environment_height: u32,
        /// Radius of the lens' opening. 0 if all is sharp.
        lens_radius: f32,
        /// Distance of what is sharp.
        lens_focus: f32,
        /// Points nearer than this lie on the surface.
        epsilon: f32,
        /// How far above a surface rays begin that leave it.
        lift: f32,
        /// Half the step of the normal's central differences.
        normal_step: f32,
        /// The shortest step where a sample proves that no surface is near.
        least_step: f32,
        /// The length over which heights are compared. 0 if there are none.
        bump_step: f32,
        /// Number of lights.
        light_count: u32,
        /// Index of the rows with what rough mirrors reflect.
        albedo_at: u32,
        /// Index of the rows with the sums of the environment's rows.
        rows_at: u32,
        /// Index of what materials have besides the first eight properties. 0 if nothing.
        extras_at: u32,
        /// 1 if a volume's own materials are used, else 0.
        is_stored: u32,
        /// Surfaces that a path passes at most.
        max_bounces: u32,
        /// Paths of each pixel in this dispatch.
        sample_count: u32,
        /// Paths that each pixel had before.
        first_sample: u32,
        /// Steps of a ray in one dispatch.
        step_count: u32,
        /// The first pixel.
        first_pixel: u32,
        /// Number of pixels.
        pixel_count: u32,
        /// 1 if what is behind everything is left out, else 0.
        is_transparent: u32,
    }
}

shared_struct! {
    /// A path on its way.
    PathState {
        /// Start of the ray to the next surface.
        origin: [f32; 3],
        /// Density of its direction.
        density: f32,
        /// Its direction.
        direction: [f32; 3],
        /// Surfaces and places in fog that the path passed.
        bounce: u32,
        /// What is left of the light from there.
        carried: [f32; 3],
        /// A `PATH_…`.
        phase: u32,
        /// What glass takes away per unit of length.
        absorption: [f32; 3],
        /// 1 if the ray is inside of glass, else 0.
        is_inside: u32,
        /// Start of a ray to a light.
        shadow_origin: [f32; 3],
        /// Its length. In the phase `PATH_INSIDE`, where on the path's ray the material is.
        shadow_reach: f32,
        /// Its direction. In the phase `PATH_INSIDE`, a normal.
        shadow_direction: [f32; 3],
        /// 1 if the path ends with it, else 0.
        ends: u32,
        /// What that light adds.
        arrives: [f32; 3],
        /// How far the ray of this phase has come.
        t: f32,
        /// What the path found.
        light: [f32; 3],
        /// The length of the ray of this phase.
        reach: f32,
        /// What the first surface reflects.
        albedo: [f32; 3],
        /// Its distance.
        distance: f32,
        /// Its normal.
        normal: [f32; 3],
        /// 1 if it is solid, else 0.
        covered: f32,
        /// How much of what is behind everything is hidden.
        opacity: f32,
        /// 1 if the ray began outside, −1 if inside, and 0 if it did not begin.
        side: f32,
        /// Steps of the ray.
        steps: u32,
        /// Which of the pixel's paths this is.
        index: u32,
        /// The pixel's random numbers.
        seed: u32,
        /// Pairs of random numbers that were used.
        pair: u32,
        /// Zero.
        pad0: u32,
        /// Zero.
        pad1: u32,
    }
}

shared_struct! {
    /// What the paths of a pixel found: sums.
    PathPixel {
        /// Light.
        light: [f32; 3],
        /// Number of paths.
        count: u32,
        /// Squares of light.
        squares: [f32; 3],
        /// Paths whose first surface is solid.
        covered: f32,
        /// What first surfaces reflect.
        albedo: [f32; 3],
        /// Their distances.
        distance: f32,
        /// Their normals.
        normal: [f32; 3],
        /// How much of what is behind everything is hidden.
        opacity: f32,
    }
}
