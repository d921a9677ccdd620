// Marches rays through Argil's sparse bricks in your own engine, one ray per thread. docs/march-bricks.md describes the bindings.

struct Bricks {
    // The coordinate of the first cell of `words`, in bricks from `corner`, and the number of cells along each axis.
    low: vec3<i32>,
    brick_size_voxels: u32,
    count: vec3<i32>,
    rays: u32,
    // The corner of the lattice, and the edge of a voxel.
    corner: vec3<f32>,
    voxel_size: f32,
    // An upper bound on how much distances change over a length of 1.
    lipschitz: f32,
}

@group(0) @binding(0) var<uniform> bricks: Bricks;
// One word per cell, x fastest: a brick's number or, with the top bit set, a lower bound on the distance to the surface.
@group(0) @binding(1) var<storage, read> words: array<u32>;
// Distances, (brick_size_voxels + 1)³ per brick, x fastest.
@group(0) @binding(2) var<storage, read> distances: array<f32>;
// Origin and unit direction of each ray.
@group(0) @binding(3) var<storage, read> rays: array<vec4<f32>>;
// The distance along each ray to its hit, or -1.
@group(0) @binding(4) var<storage, read_write> hits: array<f32>;

const EMPTY = 0x80000000u;
// The lowest bit of a word without a brick: its whole block has none.
const EMPTY_BLOCK = 1u;
const MAX_STEPS = 1024u;

// Interpolates a brick's samples at `at`, in voxels from the brick's corner.
fn sample_brick(number: u32, at: vec3<f32>) -> f32 {
    let side = bricks.brick_size_voxels + 1u;
    let index = min(vec3<u32>(max(at, vec3(0.0))), vec3(side - 2u));
    let t = clamp(at - vec3<f32>(index), vec3(0.0), vec3(1.0));
    var sum = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let far = vec3(i & 1u, i >> 1u & 1u, i >> 2u);
        let p = index + far;
        let weight = select(1.0 - t, t, far == vec3(1u));
        sum += weight.x * weight.y * weight.z * distances[number * side * side * side + (p.z * side + p.y) * side + p.x];
    }
    return sum;
}

// Returns the distance at which a ray from `p` leaves the box from `low` to `low + edge`, which contains `p`.
fn distance_to_exit(p: vec3<f32>, direction: vec3<f32>, low: vec3<f32>, edge: f32) -> f32 {
    let sides = select(low, low + edge, direction > vec3(0.0));
    let along = select((sides - p) / direction, vec3(1e30), abs(direction) < vec3(1e-12));
    return max(min(along.x, min(along.y, along.z)), 0.0);
}

fn march(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let edge = bricks.voxel_size * f32(bricks.brick_size_voxels);
    let low = bricks.corner + edge * vec3<f32>(bricks.low);
    let high = low + edge * vec3<f32>(bricks.count);
    // Clip the ray to the box of all cells.
    let along = select(direction, vec3(1e-12), abs(direction) < vec3(1e-12));
    let a = (low - origin) / along;
    let b = (high - origin) / along;
    let enter = min(a, b);
    let leave = max(a, b);
    var t = max(max(enter.x, max(enter.y, enter.z)), 0.0);
    let end = min(leave.x, min(leave.y, leave.z));
    // Steps go slightly past the side of a cell, so that the ray enters the next one.
    let nudge = 0.001 * bricks.voxel_size;
    for (var i = 0u; i < MAX_STEPS && t < end; i++) {
        let p = origin + t * direction;
        let position = floor((p - low) / edge);
        let cell = clamp(vec3<i32>(position), vec3(0), bricks.count - 1);
        let corner = low + edge * vec3<f32>(cell);
        let to_exit = distance_to_exit(p, direction, corner, edge) + nudge;
        let word = words[(cell.z * bricks.count.y + cell.y) * bricks.count.x + cell.x];
        if (word & EMPTY) == 0u {
            let d = sample_brick(word, (p - corner) / bricks.voxel_size);
            if d < 0.02 * bricks.voxel_size {
                return t;
            }
            // Stop at the brick's side: the next cell has its own samples.
            t += min(d / bricks.lipschitz, to_exit);
        } else {
            // The bound holds at the cell's center. Close to the surface it is near 0, so a ray that steps by it alone may stall.
            // No surface passes through this cell, so the ray can always advance to the cell's side.
            let bound = abs(bitcast<f32>((word & ~EMPTY_BLOCK) << 1u));
            let step = bound - distance(p, corner + 0.5 * edge);
            t += max(step, to_exit);
        }
    }
    return -1.0;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < bricks.rays {
        hits[id.x] = march(rays[2u * id.x].xyz, rays[2u * id.x + 1u].xyz);
    }
}
