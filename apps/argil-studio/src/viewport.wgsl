// Draws the images of the viewport, and the grid over them.

struct View {
    eye: vec3<f32>,
    // The distance up to which the tolerance of the depth test grows.
    reach: f32,
    right: vec3<f32>,
    // Pixels that a length of 1 covers at depth 1.
    focal: f32,
    up: vec3<f32>,
    // Where the second image begins, as a part of the width.
    divider: f32,
    forward: vec3<f32>,
    shows_difference: u32,
    // Pixels of the viewport.
    size: vec2<f32>,
    // Pixels of half a line's width.
    half_width: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var smoothed: sampler;
@group(0) @binding(2) var first: texture_2d<f32>;
@group(0) @binding(3) var second: texture_2d<f32>;
@group(0) @binding(4) var first_distance: texture_2d<f32>;
@group(0) @binding(5) var second_distance: texture_2d<f32>;

// Whether the window's texture takes linear colors.
override TAKES_LINEAR: bool = false;
// Tolerance of the depth test, as a fraction of the distance.
const SLACK: f32 = 0.004;

// The sRGB transfer function (IEC 61966-2-1).
fn output(color: vec4<f32>) -> vec4<f32> {
    let linear = select(pow((color.rgb + 0.055) / 1.055, vec3(2.4)), color.rgb / 12.92, color.rgb <= vec3(0.04045));
    return vec4(select(color.rgb, linear, TAKES_LINEAR), color.a);
}

struct Covered {
    @builtin(position) position: vec4<f32>,
    @location(0) part: vec2<f32>,
}

@vertex
fn cover(@builtin(vertex_index) corner: u32) -> Covered {
    let part = 2.0 * vec2(f32(corner & 1u), f32(corner >> 1u));
    return Covered(vec4(2.0 * part.x - 1.0, 1.0 - 2.0 * part.y, 0.0, 1.0), part);
}

@fragment
fn image(at: Covered) -> @location(0) vec4<f32> {
    let a = textureSample(first, smoothed, at.part).rgb;
    let b = textureSample(second, smoothed, at.part).rgb;
    let shown = select(b, a, at.part.x < view.divider);
    // The difference is four times as bright.
    let color = select(shown, min(4.0 * abs(a - b), vec3(1.0)), view.shows_difference != 0u);
    return output(vec4(color, 1.0));
}

struct Line {
    @builtin(position) position: vec4<f32>,
    // Where it is in the viewport, in pixels.
    @location(0) pixel: vec2<f32>,
    @location(1) @interpolate(flat) begin: vec3<f32>,
    @location(2) @interpolate(flat) along: vec3<f32>,
    @location(3) @interpolate(flat) color: vec4<f32>,
}

// Returns a point's pixel.
fn pixel_of(point: vec3<f32>) -> vec2<f32> {
    let offset = point - view.eye;
    let scale = view.focal / dot(offset, view.forward);
    return 0.5 * view.size + scale * vec2(dot(offset, view.right), -dot(offset, view.up));
}

// A line as two triangles around its part before the eye.
@vertex
fn line(
    @builtin(vertex_index) corner: u32,
    @location(0) begin: vec3<f32>,
    @location(1) end: vec3<f32>,
    @location(2) color: vec4<f32>,
) -> Line {
    let near = 1e-3 * view.reach;
    let depths = vec2(dot(begin - view.eye, view.forward), dot(end - view.eye, view.forward));
    var line = Line(vec4(0.0, 0.0, 2.0, 1.0), vec2(0.0), begin, end - begin, color);
    if max(depths.x, depths.y) <= near {
        return line;
    }
    let cut = (near - depths.x) / (depths.y - depths.x);
    let a = pixel_of(select(begin, mix(begin, end, cut), depths.x < near));
    let b = pixel_of(select(end, mix(begin, end, cut), depths.y < near));
    let direction = normalize(b - a + vec2(1e-6, 0.0));
    let aside = vec2(-direction.y, direction.x) * (view.half_width + 2.0);
    let pixel = select(b, a, (corner & 1u) == 0u) + select(aside, -aside, (corner >> 1u) == 0u);
    let clip = 2.0 * pixel / view.size - 1.0;
    line.position = vec4(clip.x, -clip.y, 0.0, 1.0);
    line.pixel = pixel;
    return line;
}

@fragment
fn grid(at: Line) -> @location(0) vec4<f32> {
    let off_middle = at.pixel - 0.5 * view.size;
    let ray = view.forward + (view.right * off_middle.x - view.up * off_middle.y) / view.focal;
    // A ray meets the line if it is in the plane through the eye and the line.
    let normal = cross(at.begin - view.eye, at.along);
    let change = vec2(dot(view.right, normal), dot(view.up, normal)) / view.focal;
    let aside = abs(dot(ray, normal)) / max(length(change), 1e-30);
    let across = cross(at.along, ray);
    let t = dot(cross(view.eye - at.begin, ray), across) / max(dot(across, across), 1e-30);
    let away = distance(at.begin + t * at.along, view.eye);
    let part = at.pixel / view.size;
    let last = textureDimensions(first_distance) - 1u;
    let place = min(vec2<u32>(max(part, vec2(0.0)) * vec2<f32>(last + 1u)), last);
    let lengths = vec2(textureLoad(first_distance, place, 0).r, textureLoad(second_distance, place, 0).r);
    let is_hidden = select(lengths.y, lengths.x, part.x < view.divider) < away - SLACK * min(away, view.reach);
    let covered = clamp(view.half_width + 0.5 - aside, 0.0, 1.0);
    return output(at.color * select(covered, 0.0, is_hidden));
}
