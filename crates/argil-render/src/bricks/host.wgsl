// What shaders of a host ask of bricks.

var<private> field_material: GpuMaterial;

// Returns the signed distance at a point of the scene, negative inside. More than a band from the surface, it is a lower
// bound.
fn argil_distance(p: vec3<f32>) -> f32 {
    return scene_sample(p).x;
}

// Returns the edge of a voxel at a point.
fn voxel_at(p: vec3<f32>) -> f32 {
    return volume.voxel_size;
}

fn host_hit(ray: Ray, span: vec2<f32>) -> ArgilHit {
    let is_inside = span.x <= 0.0 && argil_distance(ray.origin) < 0.0;
    let walk = walk_bricks(ray, span.x, span.y, select(1.0, -1.0, is_inside));
    return ArgilHit(walk.kind != HIT_NONE, walk.t, walked_normal(ray, walk));
}
