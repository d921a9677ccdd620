// GPU version of quartic.rs.

// Returns the parameters of the minima of a polynomial of degree four. `c` is half of its derivative.
fn minima(c: vec4<f32>, is_straight: bool) -> vec2<f32> {
    let reciprocal = 1.0 / c.w;
    let inflection = c.z * reciprocal * (-1.0 / 3.0);
    let s2 = inflection * inflection - c.y * reciprocal * (1.0 / 3.0);
    let q = (((c.w * inflection + c.z) * inflection + c.y) * inflection + c.x) * reciprocal;
    let s = sqrt(max(s2, 0.0));
    let k = q / (s * s * s);
    let has_two = s2 > 0.0 && q * q < 4.0 * s2 * s2 * s2;
    let root = bitcast<f32>(bitcast<u32>(abs(q)) / 3u + 0x2a514067u);
    let one = select(min(root, abs(q) / max(-3.0 * s2, 1e-30)), root + s2 / root, s2 > 0.0);
    let beyond = vec2(-s, s) * (1.0 + sqrt(max(2.0 + vec2(k, -k), vec2(0.0)) * (1.0 / 3.5)));
    let curved = inflection + select(vec2(-signed_as(one, q)), beyond, has_two);
    let t = select(curved, vec2(0.0, 1.0), is_straight);
    return newton_step(c, newton_step(c, newton_step(c, t)));
}

fn newton_step(c: vec4<f32>, t: vec2<f32>) -> vec2<f32> {
    let value = ((c.w * t + c.z) * t + c.y) * t + c.x;
    let slope = (3.0 * c.w * t + 2.0 * c.z) * t + c.y;
    return select(t, t - value / slope, slope > vec2(0.0));
}
