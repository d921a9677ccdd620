// GPU version of camera.rs: the primary ray of a pixel. `frame` is the bound uniform.

// Whether rays are those of a host: parallel ones begin beside the eye, and all begin to hit at its near plane.
override HOST_RAYS: bool = false;

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

fn primary_ray(x: u32, y: u32) -> Ray {
    return ray_through(f32(x) + frame.jitter_x, f32(y) + frame.jitter_y);
}

// The ray of a position in the image, in pixels.
fn ray_through(x: f32, y: f32) -> Ray {
    let u = x / f32(frame.width) * 2.0 - 1.0;
    let v = 1.0 - y / f32(frame.height) * 2.0;
    let d = frame.forward + frame.right * u + frame.up * v;
    let length = sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    let beside = select(vec3(0.0), frame.eye_right * u + frame.eye_up * v, HOST_RAYS);
    return Ray(frame.eye + beside, vec3(d.x / length, d.y / length, d.z / length));
}

fn not_zero(d: f32) -> f32 {
    return select(d, 1e-20, abs(d) < 1e-20);
}

// GPU version of Ray::span in argil-math: where a ray enters and leaves the scene's box. It misses if x > y.
fn box_span(ray: Ray) -> vec2<f32> {
    let d = ray.direction;
    let inverse = vec3(1.0 / not_zero(d.x), 1.0 / not_zero(d.y), 1.0 / not_zero(d.z));
    let a = (frame.box_min - ray.origin) * inverse;
    let c = (frame.box_max - ray.origin) * inverse;
    let low = min(a, c);
    let high = max(a, c);
    return vec2(max(max(low.x, max(low.y, low.z)), 0.0), min(high.x, min(high.y, high.z)));
}

// The length at which a ray of a host meets the near plane.
fn near_length(ray: Ray) -> f32 {
    if !HOST_RAYS {
        return 0.0;
    }
    let plane = frame.near_plane;
    let along = dot(plane.xyz, ray.direction);
    let ahead = plane.w - dot(plane.xyz, ray.origin - frame.eye);
    return select(0.0, max(ahead / along, 0.0), along > 0.0);
}

// Where a primary ray begins and ends, and where it enters the box from outside: 0 if it begins in it.
fn primary_span(ray: Ray) -> vec3<f32> {
    let span = box_span(ray);
    let near = near_length(ray);
    return vec3(max(span.x, near), span.y, select(span.x, 0.0, near > span.x));
}

// Returns the normal of the box's side where a ray enters, if the ray ends right there: the box clips a solid. Else zero.
fn clip_normal(ray: Ray, t: f32) -> vec3<f32> {
    let near = primary_span(ray).z;
    if near <= 0.0 || t > near {
        return vec3(0.0);
    }
    let p = ray.origin + ray.direction * near;
    let from_side = min(abs(p - frame.box_min), abs(p - frame.box_max));
    let toward = select(vec3(-1.0), vec3(1.0), ray.direction < vec3(0.0));
    if from_side.x <= min(from_side.y, from_side.z) {
        return vec3(toward.x, 0.0, 0.0);
    }
    return select(vec3(0.0, 0.0, toward.z), vec3(0.0, toward.y, 0.0), from_side.y <= from_side.z);
}
