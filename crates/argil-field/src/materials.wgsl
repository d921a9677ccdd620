// What materials begin with, and how paint covers them.

fn first_material() -> GpuMaterial {
    return materials[material_shift];
}

fn weight_paint(b: f32, j: Joint) -> f32 {
    let soft = clamp(0.5 - b * (4.0 * j.quarter), 0.0, 1.0);
    return select(select(0.0, 1.0, b < 0.0), soft, j.k > 0.0);
}
