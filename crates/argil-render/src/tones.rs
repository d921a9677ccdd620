//! Tone curves. `tones.wgsl` is the twin.

use glam::{Mat3, Vec3, vec3};

/// Narkowicz's fit of ACES (2015).
#[inline(always)]
pub(crate) fn tone_mapped(c: f32) -> f32 {
    let x = c * 0.5;
    let y = x * (x * 2.51 + 0.03) / (x * (x * 2.43 + 0.59) + 0.14);
    if y > 1.0 {
        1.0
    } else if y > 0.0 {
        y
    } else {
        0.0
    }
}

/// Primaries between which AgX has its curve: colors turn toward white as they grow bright.
const INSET: Mat3 = Mat3::from_cols(
    vec3(0.842_479_1, 0.042_328_24, 0.042_375_66),
    vec3(0.078_433_6, 0.878_468_6, 0.078_433_6),
    vec3(0.079_223_75, 0.079_166_13, 0.879_143),
);
const OUTSET: Mat3 = Mat3::from_cols(
    vec3(1.196_879, -0.052_896_85, -0.052_971_64),
    vec3(-0.098_020_88, 1.151_903_1, -0.098_043_45),
    vec3(-0.099_029_74, -0.098_961_18, 1.151_073_7),
);
/// The least and the most light of its curve, as powers of two.
const STOPS: [f32; 2] = [-12.473_93, 4.026_069];

/// The AgX curve by Sobotka, as fitted by Wrensch ("Minimal AgX implementation", 2023).
pub(crate) fn agx(light: Vec3) -> Vec3 {
    let [least, most] = STOPS;
    let bright = (INSET * light).max(Vec3::splat(1e-10));
    let x = (bright
        .map(f32::log2)
        .clamp(Vec3::splat(least), Vec3::splat(most))
        - least)
        / (most - least);
    let curve = |x: f32| {
        let mut sum = 0.0;
        for factor in [15.5, -40.14, 31.96, -6.868, 0.429_8, 0.119_1, -0.002_32] {
            sum = sum * x + factor;
        }
        sum
    };
    let shown = OUTSET * x.map(curve);
    shown.max(Vec3::ZERO).map(|c| c.powf(2.2)).min(Vec3::ONE)
}
