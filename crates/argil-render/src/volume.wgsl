// GPU version of volume.rs. `volume` is the bound uniform, `stored` the texture of distances, `linear` its filter.

fn stored_distance(p: vec3<f32>, level: u32) -> f32 {
    let uvw = (p - volume.corner) / volume.extent;
    return textureSampleLevel(stored, linear, uvw, f32(level)).x * (volume.band_width * f32(1u << level));
}

struct SurfaceStep {
    t: f32,
    side: f32,
    gap: f32,
    reached: bool,
}

// Advances by a stored distance. `entry` is 0 where the ray begins in the box.
fn walk_step(walk: ptr<function, SurfaceStep>, entry: f32, d: f32, is_last: bool) {
    let is_first = (*walk).side == 0.0;
    if is_first {
        (*walk).side = select(1.0, -1.0, d < 0.0 && entry <= 0.0);
    }
    // A ray that enters the volume through a clipped solid has hit there.
    let gap = select(d * (*walk).side, 0.0, is_first && (*walk).side > 0.0 && d < 0.0);
    (*walk).gap = gap;
    (*walk).reached = gap < frame.epsilon || (is_last && gap < frame.pixel_width * (*walk).t);
    (*walk).t += gap * frame.inv_lipschitz;
}

fn walk_kind(walk: SurfaceStep) -> u32 {
    return select(HIT_OUTSIDE, HIT_INSIDE, walk.side < 0.0);
}
