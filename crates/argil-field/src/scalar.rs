//! Number types for shapes: `f32` for distances, and dual numbers for gradients.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Points that are evaluated together. Three coordinates of them fit into the first-level cache many times, and
/// make the interpreter's dispatch cheap.
pub const LANES: usize = 256;

/// Points that are searched together.
pub(crate) const SIMD_BLOCK: usize = 16;

/// One number for each point of a block.
pub(crate) type SimdBlock<R> = [R; SIMD_BLOCK];

/// A number, with arrays of [`LANES`] of it for SIMD.
pub(crate) trait Real:
    Copy
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    type Lanes: Clone;
    const HAS_GRADIENT: bool;
    fn splat(value: f32) -> Self::Lanes;
    fn get(lanes: &Self::Lanes, i: usize) -> Self;
    fn set(lanes: &mut Self::Lanes, i: usize, value: Self);
    fn constant(value: f32) -> Self;
    fn value(self) -> f32;
    fn sqrt(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
    /// Returns the power of a number of at least 0, with a positive exponent.
    fn power(self, exponent: f32) -> Self;

    fn abs(self) -> Self;
    /// Returns the smaller number, or `self` if either is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if other.value() < self.value() {
            other
        } else {
            self
        }
    }
    /// Returns the larger number, or `self` if either is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if other.value() > self.value() {
            other
        } else {
            self
        }
    }
    /// Returns the number, or 0 if it is negative or NaN.
    #[inline(always)]
    fn positive_part(self) -> Self {
        if self.value() > 0.0 {
            self
        } else {
            Self::constant(0.0)
        }
    }
    #[inline(always)]
    fn clamp_to(self, min: f32, max: f32) -> Self {
        self.max(Self::constant(min)).min(Self::constant(max))
    }
    /// Returns `self` with the sign of `sign`, positive if that is 0.
    #[inline(always)]
    fn signed_as(self, sign: Self) -> Self {
        if sign.value() < 0.0 { -self } else { self }
    }
}

/// An array of plain numbers, aligned to a cache line and to the widest registers.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct F32Lanes(pub [f32; LANES]);

impl Real for f32 {
    type Lanes = F32Lanes;
    const HAS_GRADIENT: bool = false;
    #[inline(always)]
    fn splat(value: f32) -> F32Lanes {
        F32Lanes([value; LANES])
    }
    #[inline(always)]
    fn get(lanes: &F32Lanes, i: usize) -> f32 {
        lanes.0[i]
    }
    #[inline(always)]
    fn set(lanes: &mut F32Lanes, i: usize, value: f32) {
        lanes.0[i] = value;
    }
    #[inline(always)]
    fn constant(value: f32) -> f32 {
        value
    }
    #[inline(always)]
    fn value(self) -> f32 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> f32 {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> f32 {
        f32::abs(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (f32, f32) {
        sin_cos(self)
    }
    #[inline(always)]
    fn power(self, exponent: f32) -> f32 {
        power(self, exponent)
    }
}

/// Returns sine and cosine by polynomials over a quarter turn. Every device uses the same operations, because the
/// standard library's results differ between platforms and do not vectorize. Accurate to 2e-7 for |x| < 1000.
///
/// Range reduction after Cody and Waite, and minimax coefficients as in Cephes' `sinf` and `cosf`.
#[inline(always)]
pub(crate) fn sin_cos(x: f32) -> (f32, f32) {
    let turns = (x * std::f32::consts::FRAC_2_PI + 0.5).floor();
    let r = ((x - turns * 1.570_312_5) - turns * 4.837_513e-4) - turns * 7.549_79e-8;
    let r2 = r * r;
    let s = r + r * r2 * (-1.666_665_5e-1 + r2 * (8.332_161e-3 - r2 * 1.951_529_6e-4));
    let c =
        1.0 - 0.5 * r2 + r2 * r2 * (4.166_664_6e-2 + r2 * (-1.388_731_6e-3 + r2 * 2.443_315_7e-5));
    // The quarter, from 0 to 3, without a conversion to integers.
    let quarter = turns - 4.0 * (turns * 0.25).floor();
    let odd = quarter == 1.0 || quarter == 3.0;
    let (sin, cos) = if odd { (c, s) } else { (s, c) };
    let sin = if quarter >= 2.0 { -sin } else { sin };
    let cos = if quarter == 1.0 || quarter == 2.0 {
        -cos
    } else {
        cos
    };
    (sin, cos)
}

/// Returns a power by polynomials, with the same operations on every device. Bases below 1e-30 return 0. Accurate
/// to 2e-6 for exponents from 1/16 to 16 and bases from 0 to 2.
///
/// The logarithm is the series of (m − 1)/(m + 1) about a mantissa m near 1, and the exponential is a series for
/// numbers up to one half.
#[inline(always)]
pub(crate) fn power(base: f32, exponent: f32) -> f32 {
    let bits = base.to_bits();
    // So that the mantissa is from √½ to √2.
    let whole = (bits.wrapping_sub(0x3f35_04f3) as i32) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub((whole << 23) as u32));
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let t2 = t * t;
    let series =
        2.885_39 + t2 * (0.961_796_7 + t2 * (0.577_078 + t2 * (0.412_198_6 + t2 * 0.320_598_9)));
    let log2 = whole as f32 + t * series;
    let x = Real::clamp_to(log2 * exponent, -126.0, 126.0);
    let n = (x + 0.5).floor();
    let f = x - n;
    let series = 1.0
        + f * (std::f32::consts::LN_2
            + f * (0.240_226_5
                + f * (0.055_504_11
                    + f * (0.009_618_129 + f * (0.001_333_355_8 + f * 0.000_154_035_3)))));
    let scale = f32::from_bits(((n as i32 + 127) << 23) as u32);
    if base < 1e-30 { 0.0 } else { series * scale }
}

/// A number with its derivatives along x, y and z of the evaluated point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual {
    pub v: f32,
    pub d: [f32; 3],
}

impl Dual {
    #[inline(always)]
    fn with(v: f32, d: impl Fn(usize) -> f32) -> Self {
        Self {
            v,
            d: [d(0), d(1), d(2)],
        }
    }
}

/// Four arrays: values, and then derivatives.
#[derive(Clone, Debug)]
pub(crate) struct DualLanes(pub [F32Lanes; 4]);

impl Real for Dual {
    type Lanes = DualLanes;
    const HAS_GRADIENT: bool = true;
    #[inline(always)]
    fn splat(value: f32) -> DualLanes {
        DualLanes([
            f32::splat(value),
            f32::splat(0.0),
            f32::splat(0.0),
            f32::splat(0.0),
        ])
    }
    #[inline(always)]
    fn get(lanes: &DualLanes, i: usize) -> Dual {
        let [v, x, y, z] = &lanes.0;
        Dual {
            v: v.0[i],
            d: [x.0[i], y.0[i], z.0[i]],
        }
    }
    #[inline(always)]
    fn set(lanes: &mut DualLanes, i: usize, value: Dual) {
        let [v, x, y, z] = &mut lanes.0;
        v.0[i] = value.v;
        x.0[i] = value.d[0];
        y.0[i] = value.d[1];
        z.0[i] = value.d[2];
    }
    #[inline(always)]
    fn constant(value: f32) -> Dual {
        Dual {
            v: value,
            d: [0.0; 3],
        }
    }
    #[inline(always)]
    fn value(self) -> f32 {
        self.v
    }
    #[inline(always)]
    fn sqrt(self) -> Dual {
        let root = self.v.sqrt();
        // At a root of 0, the slope has no limit, and the surface has none there either.
        let slope = 0.5 / Real::max(root, 1e-18);
        Dual::with(root, |i| self.d[i] * slope)
    }
    #[inline(always)]
    fn abs(self) -> Dual {
        if self.v < 0.0 { -self } else { self }
    }
    #[inline(always)]
    fn sin_cos(self) -> (Dual, Dual) {
        let (s, c) = sin_cos(self.v);
        (
            Dual::with(s, |i| self.d[i] * c),
            Dual::with(c, |i| -self.d[i] * s),
        )
    }
    #[inline(always)]
    fn power(self, exponent: f32) -> Dual {
        let value = power(self.v, exponent);
        // At a base of 0, the slope of a root has no limit.
        let slope = exponent * value / Real::max(self.v, 1e-18);
        Dual::with(value, |i| self.d[i] * slope)
    }
}

impl Add for Dual {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::with(self.v + o.v, |i| self.d[i] + o.d[i])
    }
}
impl Sub for Dual {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::with(self.v - o.v, |i| self.d[i] - o.d[i])
    }
}
#[allow(
    clippy::suspicious_arithmetic_impl,
    reason = "the product and quotient rules use every operation"
)]
impl Mul for Dual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self::with(self.v * o.v, |i| self.d[i] * o.v + o.d[i] * self.v)
    }
}
#[allow(
    clippy::suspicious_arithmetic_impl,
    reason = "the product and quotient rules use every operation"
)]
impl Div for Dual {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let q = self.v / o.v;
        Self::with(q, |i| (self.d[i] - q * o.d[i]) / o.v)
    }
}
impl Neg for Dual {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::with(-self.v, |i| -self.d[i])
    }
}
impl Add<f32> for Dual {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: f32) -> Self {
        Self {
            v: self.v + o,
            d: self.d,
        }
    }
}
impl Sub<f32> for Dual {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: f32) -> Self {
        Self {
            v: self.v - o,
            d: self.d,
        }
    }
}
impl Mul<f32> for Dual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f32) -> Self {
        Self::with(self.v * o, |i| self.d[i] * o)
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn sine_and_cosine_follow_the_standard_library() {
        let mut worst = 0.0f64;
        for i in -100_000..100_000 {
            let x = i as f32 * 0.01;
            let (s, c) = super::sin_cos(x);
            worst = worst
                .max((f64::from(s) - f64::from(x).sin()).abs())
                .max((f64::from(c) - f64::from(x).cos()).abs());
        }
        assert!(worst < 2e-7, "{worst}");
    }

    #[test]
    fn powers_follow_the_standard_library() {
        let mut worst = 0.0f64;
        for i in 0..=2000 {
            for exponent in [0.0625f32, 0.1, 0.5, 1.0, 1.7, 2.0, 3.3, 8.0, 16.0] {
                let base = i as f32 * 0.001;
                let expected = f64::from(base).powf(f64::from(exponent));
                let found = f64::from(super::power(base, exponent));
                worst = worst.max((found - expected).abs() / expected.max(1.0));
            }
        }
        assert!(worst < 2e-6, "{worst}");
    }
}
