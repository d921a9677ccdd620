// What materials begin with, and which of them operands change.

fn first_material() -> GpuMaterial {
    return materials[material_shift];
}

// Whether what an operand cuts keeps the material that is there.
fn keeps_material(flags: u32) -> bool {
    return (flags & FLAG_KEEP_MATERIAL) != 0u;
}

fn weight_paint(b: f32, j: Joint) -> f32 {
    let soft = clamp(0.5 - b * (4.0 * j.quarter), 0.0, 1.0);
    return select(select(0.0, 1.0, b < 0.0), soft, j.k > 0.0);
}
