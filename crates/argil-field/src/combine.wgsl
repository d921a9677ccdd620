// GPU version of combine.rs.

struct Joint {
    k: f32,
    quarter: f32,
    sa: f32,
    sb: f32,
    sr: f32,
    // The share of a morph, and for one with a ramp, its largest difference and the reciprocal of its stretch.
    amount: f32,
    max_difference: f32,
    inverse_stretch: f32,
}

// The share of the next morph with a ramp.
var<private> ramp_share: f32;

fn read_joint(w: u32) -> Joint {
    return Joint(params[w], params[w + 1u], params[w + 2u], params[w + 3u], params[w + 4u], 0.0, 0.0, 1.0);
}

// Reads the joint of a group.
fn read_group_joint(w: u32, flags: u32) -> Joint {
    var j = read_joint(w);
    if (flags & COMBINE_MASK) == COMBINE_RAMPED {
        j.amount = ramp_share;
        j.max_difference = params[w + 6u];
        j.inverse_stretch = params[w + 7u];
    } else {
        j.amount = params[w + 5u];
    }
    return j;
}

fn combine_smooth(a0: f32, b0: f32, j: Joint) -> f32 {
    let a = a0 * j.sa;
    let b = b0 * j.sb;
    let h = max(-abs(a - b) + j.k, 0.0);
    return (min(a, b) - h * h * j.quarter) * j.sr;
}

fn combine_chamfer(a0: f32, b0: f32, j: Joint) -> f32 {
    let a = a0 * j.sa;
    let b = b0 * j.sb;
    let face = (a + b - j.k) * 0.70710677;
    let hard = min(a, b);
    return select(hard, min(hard, face), j.k > 0.0) * j.sr;
}

fn combine_morph(a: f32, b: f32, j: Joint) -> f32 {
    return a + (b - a) * j.amount;
}

fn combine_ramped(a: f32, b: f32, j: Joint) -> f32 {
    return (a + clamp(b - a, -j.max_difference, j.max_difference) * j.amount) * j.inverse_stretch;
}

fn combine(a: f32, b: f32, j: Joint, flags: u32) -> f32 {
    switch flags & COMBINE_MASK {
        case COMBINE_CHAMFER: { return combine_chamfer(a, b, j); }
        case COMBINE_PAINT: { return a; }
        case COMBINE_MORPH: { return combine_morph(a, b, j); }
        case COMBINE_RAMPED: { return combine_ramped(a, b, j); }
        default: { return combine_smooth(a, b, j); }
    }
}

fn matters(a: f32, least: f32, j: Joint) -> bool {
    return j.sb < 0.0 || least <= 0.0 || least < a * j.sa + j.k;
}

fn weight_smooth(a0: f32, b0: f32, j: Joint) -> f32 {
    let a = a0 * j.sa;
    let b = b0 * j.sb;
    let h = max(j.k - abs(a - b), 0.0) * (2.0 * j.quarter);
    return select(h, 1.0 - h, b < a);
}

// Returns the weight of b's material.
fn weight(a: f32, b: f32, j: Joint, flags: u32) -> f32 {
    if keeps_material(flags) {
        return 0.0;
    }
    switch flags & COMBINE_MASK {
        case COMBINE_PAINT: { return weight_paint(b, j); }
        case COMBINE_MORPH: { return j.amount; }
        case COMBINE_RAMPED: { return clamp(j.amount, 0.0, 1.0); }
        default: { return weight_smooth(a, b, j); }
    }
}

fn mix_material(a: GpuMaterial, b: GpuMaterial, w: f32) -> GpuMaterial {
    return GpuMaterial(
        a.base_roughness + (b.base_roughness - a.base_roughness) * w,
        a.emission_metallic + (b.emission_metallic - a.emission_metallic) * w,
    );
}
