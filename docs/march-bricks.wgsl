// Marches Argil's sparse bricks in a shader of one's own: a ray a thread. docs/march-bricks.md tells what is bound.

struct Bricks {
    // The first cell of `words`, counted in bricks from `corner`, and how many there are along each axis.
    low: vec3<i32>,
    voxels_a_brick: u32,
    count: vec3<i32>,
    rays: u32,
    // The lattice's corner, and the edge of a voxel.
    corner: vec3<f32>,
    voxel: f32,
    // By how much distances change over a length of 1 at most.
    lipschitz: f32,
}

@group(0) @binding(0) var<uniform> bricks: Bricks;
// A word a cell, x fastest: a brick's number, or with the top bit set how far the surface is at least.
@group(0) @binding(1) var<storage, read> words: array<u32>;
// Distances, (voxels_a_brick + 1)³ a brick, x fastest.
@group(0) @binding(2) var<storage, read> distances: array<f32>;
// Origin and unit direction of each ray.
@group(0) @binding(3) var<storage, read> rays: array<vec4<f32>>;
// How far each ray came, or -1.
@group(0) @binding(4) var<storage, read_write> hits: array<f32>;

const EMPTY = 0x80000000u;
// The lowest bit of a word without a brick: none is in the whole block.
const LONELY = 1u;
const MOST_STEPS = 1024u;

// The distance between a brick's samples; `at` is the place in it, in voxels.
fn in_brick(number: u32, at: vec3<f32>) -> f32 {
    let side = bricks.voxels_a_brick + 1u;
    let place = min(vec3<u32>(max(at, vec3(0.0))), vec3(side - 2u));
    let t = clamp(at - vec3<f32>(place), vec3(0.0), vec3(1.0));
    var sum = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let far = vec3(i & 1u, i >> 1u & 1u, i >> 2u);
        let p = place + far;
        let share = select(1.0 - t, t, far == vec3(1u));
        sum += share.x * share.y * share.z * distances[number * side * side * side + (p.z * side + p.y) * side + p.x];
    }
    return sum;
}

// How far a ray goes until it leaves the box from `low` to `low + edge`, where it is in it.
fn way_out(p: vec3<f32>, direction: vec3<f32>, low: vec3<f32>, edge: f32) -> f32 {
    let sides = select(low, low + edge, direction > vec3(0.0));
    let along = select((sides - p) / direction, vec3(1e30), abs(direction) < vec3(1e-12));
    return max(min(along.x, min(along.y, along.z)), 0.0);
}

fn march(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let edge = bricks.voxel * f32(bricks.voxels_a_brick);
    let low = bricks.corner + edge * vec3<f32>(bricks.low);
    let high = low + edge * vec3<f32>(bricks.count);
    // To the box of all cells, and as far as that goes.
    let along = select(direction, vec3(1e-12), abs(direction) < vec3(1e-12));
    let a = (low - origin) / along;
    let b = (high - origin) / along;
    let into = min(a, b);
    let out = max(a, b);
    var t = max(max(into.x, max(into.y, into.z)), 0.0);
    let end = min(out.x, min(out.y, out.z));
    // A little farther than to the side of a cell, so that the ray is in the next.
    let nudge = 0.001 * bricks.voxel;
    for (var i = 0u; i < MOST_STEPS && t < end; i++) {
        let p = origin + t * direction;
        let place = floor((p - low) / edge);
        let cell = clamp(vec3<i32>(place), vec3(0), bricks.count - 1);
        let corner = low + edge * vec3<f32>(cell);
        let beyond = way_out(p, direction, corner, edge) + nudge;
        let word = words[(cell.z * bricks.count.y + cell.y) * bricks.count.x + cell.x];
        if (word & EMPTY) == 0u {
            let d = in_brick(word, (p - corner) / bricks.voxel);
            if d < 0.02 * bricks.voxel {
                return t;
            }
            // No farther than this brick's side: the next knows more.
            t += min(d / bricks.lipschitz, beyond);
        } else {
            // A bound at the cell's middle. Beside the surface it is near 0, and a ray that goes by it alone never arrives; but there is no
            // surface in this cell, so the ray can always leave it.
            let bound = abs(bitcast<f32>((word & ~LONELY) << 1u));
            let free = bound - distance(p, corner + 0.5 * edge);
            t += max(free, beyond);
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
