// GPU version of RayMotion in step.rs: over-relaxed sphere tracing.

// A ray's length, how far beyond the last sphere it is, and the last distance and step.
struct RayMotion {
    t: f32,
    over: f32,
    last_gap: f32,
    last_step: f32,
}

// Advances a ray at a distance `g` from the surface. Outside bricks it advances by `empty_way`.
fn advanced(motion: RayMotion, g: f32, empty_way: f32, in_brick: bool, too_far: bool, end: f32) -> RayMotion {
    let scale = frame.inv_lipschitz;
    // Along a plane, spheres still touch with this much more than their radius between their centers.
    let fell = max(motion.last_gap - g, 0.0);
    let sum = motion.last_step + fell;
    let share = max((motion.last_step - fell) / select(1.0, sum, sum > 0.0), 0.0);
    let beyond = select(0.0, RELAXATION * g * share * scale, in_brick && !too_far);
    let way = select(empty_way, g * scale + beyond, in_brick);
    let t = motion.t + select(way, -motion.over, too_far);
    // Beyond the end of the ray, advance only as far as is known to be free.
    let pull = clamp(t - end, 0.0, beyond);
    let last_step = select(0.0, way, in_brick && !too_far);
    return RayMotion(t - pull, beyond - pull, g, max(last_step - pull, 0.0));
}

// Advances a ray in a brick at a distance `g` from the surface, outside the last sphere.
fn relaxed(motion: RayMotion, g: f32, scale: f32, end: f32) -> RayMotion {
    // Along a plane, spheres still touch with this much more than their radius between their centers.
    let fell = max(motion.last_gap - g, 0.0);
    let share = saturate((motion.last_step - fell) / max(motion.last_step + fell, 1e-37));
    let way = g * scale;
    let touching = motion.t + way;
    // Beyond the end of the ray, advance only as far as is known to be free.
    let t = clamp(end, touching, touching + RELAXATION * share * way);
    return RayMotion(t, t - touching, g, t - motion.t);
}
