// Draws triangles with the device's depth test. Outputs the normal toward the viewer, and the length of the ray,
// negative if the surface is seen from inside. `frame` is the bound uniform.

// The near plane. Depth is this over the distance along the view, which is precise far away.
const NEAR: f32 = 1e-4;

struct Drawn {
    @builtin(position) place: vec4<f32>,
    @location(0) way: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

@vertex
fn place(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>) -> Drawn {
    let way = position - frame.eye;
    let forward = frame.forward;
    let depth = dot(way, forward) / dot(forward, forward);
    // Pixels are sampled at their center; the ray passes through another point.
    let shift = (vec2(0.5 - frame.jitter_x, 0.5 - frame.jitter_y)) * 2.0 / vec2(f32(frame.width), f32(frame.height));
    let u = dot(way, frame.right) / dot(frame.right, frame.right) + shift.x * depth;
    let v = dot(way, frame.up) / dot(frame.up, frame.up) - shift.y * depth;
    return Drawn(vec4(u, v, NEAR, depth), way, normal);
}

@fragment
fn nearest(drawn: Drawn, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let length = sqrt(dot(drawn.way, drawn.way));
    let sign = select(-1.0, 1.0, is_front);
    let square = dot(drawn.normal, drawn.normal);
    var normal = -drawn.way / length;
    if square > 0.0 {
        normal = drawn.normal * (sign / sqrt(square));
    }
    return vec4(normal, length * sign);
}
