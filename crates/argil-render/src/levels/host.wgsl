// What shaders of a host ask of levels: the finest pages that there are answer.

// The page where the last search ended.
var<private> host_slot: u32 = 0u;

// Shaders of a host ask for no pages, and take those that there are as they are.
fn note(found: LevelCell) {
}

fn doubt_of(found: LevelCell) -> f32 {
    return 0.0;
}

// Returns the finest cell at an offset from the eye.
fn finest_cell(away: vec3<f32>) -> LevelCell {
    let found = locate(away, 0u, host_slot);
    host_slot = found.cell / 8u;
    return found;
}

// Returns the signed distance at a point of the scene, negative inside. More than a band from the surface, it is that of
// a coarser page, or a lower bound.
fn argil_distance(p: vec3<f32>) -> f32 {
    let held = clamp(p, volume.box_min, volume.box_max);
    let found = finest_cell(held - frame.eye);
    var d = level_distance(found);
    if !is_brick(found.word) {
        // An empty cell has a bound, and the coarser brick around it has distances up to its band.
        let around = brick_above(found, held - frame.eye);
        let between = level_distance(around);
        if abs(between) > abs(d) && (between < 0.0) == (d < 0.0) {
            d = between;
        }
    }
    let aside = distance(held, p);
    return select(d, max(aside, d - aside), aside > 0.0);
}

// Returns the edge of a voxel at a point.
fn voxel_at(p: vec3<f32>) -> f32 {
    return brick_above(finest_cell(p - frame.eye), p - frame.eye).voxel;
}

fn surface_material(p: vec3<f32>, outward: vec3<f32>) -> GpuMaterial {
    return brick_material(brick_above(finest_cell(p - frame.eye), p - frame.eye), outward);
}

fn host_hit(ray: Ray, span: vec2<f32>) -> ArgilHit {
    let walk = walk_levels(ray.direction, ray.origin - frame.eye, span.x, span, 0.0);
    return ArgilHit(walk.kind != HIT_NONE, walk.t, walk.normal);
}
