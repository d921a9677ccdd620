// Draws what a frame's rays hit into the targets of a host. A triangle covers the viewport.

// Whether the second target takes normals, and not motion. Whether normals are stored from 0 to 1, and not from -1 to 1.
override HAS_NORMALS: bool = true;
override ARE_UNSIGNED: bool = false;

struct HostView {
    clip_from_world: mat4x4<f32>,
    // The same of the frame before.
    before: mat4x4<f32>,
    // Whether the target takes linear colors, and whether the frame has them.
    takes_linear: u32,
    has_linear: u32,
    // Whether brushes moved. Then `motions` has the way of each pixel's point.
    has_moved: u32,
}

// The sRGB transfer function and its inverse (IEC 61966-2-1).
fn srgb_of(c: vec3<f32>) -> vec3<f32> {
    return select(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, c * 12.92, c <= vec3(0.0031308));
}

fn linear_of(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, c <= vec3(0.04045));
}

struct Covered {
    @builtin(position) position: vec4<f32>,
    @location(0) place: vec2<f32>,
}

@vertex
fn cover(@builtin(vertex_index) index: u32) -> Covered {
    let corner = vec2(f32((index << 1u) & 2u), f32(index & 2u));
    return Covered(vec4(corner.x * 2.0 - 1.0, 1.0 - corner.y * 2.0, 0.0, 1.0), corner);
}

struct Drawn {
    @location(0) color: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) motion: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

struct Flat {
    @location(0) color: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) motion: vec4<f32>,
}

// How far a point went in the image since the frame before, as a part of the image, with y down.
fn motion_of(at: u32, point: vec3<f32>, clip: vec4<f32>) -> vec2<f32> {
    var place = point;
    if host_view.has_moved != 0u {
        place += motions[at].xyz;
    }
    let before = host_view.before * vec4(place, 1.0);
    if before.w <= 0.0 {
        return vec2(0.0);
    }
    return (clip.xy / clip.w - before.xy / before.w) * vec2(0.5, -0.5);
}

fn drawn(covered: Covered) -> Drawn {
    let size = vec2<f32>(f32(frame.width), f32(frame.height));
    let pixel = vec2<u32>(clamp(covered.place * size, vec2(0.0), size - 1.0));
    let at = pixel.y * frame.width + pixel.x;
    let hit = hit_of(hits[at]);
    let ray = primary_ray(pixel.x, pixel.y);
    let point = ray.origin + ray.direction * hit.normal_t.w;
    let clip = host_view.clip_from_world * vec4(point, 1.0);
    // What begins at the near plane may be beyond it by a rounding.
    let rounding = 1e-4 * clip.w;
    if hit.kind == HIT_NONE || clip.w <= 0.0 || clip.z < -rounding || clip.z > clip.w + rounding {
        discard;
    }
    var color = max(colors[at].xyz, vec3(0.0));
    if host_view.takes_linear != host_view.has_linear {
        if host_view.takes_linear != 0u {
            color = linear_of(color);
        } else {
            color = srgb_of(color);
        }
    }
    let motion = vec4(motion_of(at, point, clip), 0.0, 0.0);
    var normal = vec4(hit.normal_t.xyz, 0.0);
    normal = select(normal, vec4(0.5 * normal.xyz + 0.5, 1.0), ARE_UNSIGNED);
    return Drawn(vec4(color, 1.0), select(motion, normal, HAS_NORMALS), motion, saturate(clip.z / clip.w));
}

@fragment
fn with_depth(covered: Covered) -> Drawn {
    return drawn(covered);
}

// For a host without a depth buffer.
@fragment
fn without_depth(covered: Covered) -> Flat {
    let all = drawn(covered);
    return Flat(all.color, all.normal, all.motion);
}
