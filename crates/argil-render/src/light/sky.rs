//! How much of the sky surfaces see.
//!
//! *Theory.* Five distances along the normal, each compared with its own height, tell how closed a place is. For the
//! pixels of a group, the points of one height are close together, and where the distance there is nearly linear,
//! four of them and the middle give all others. How far the middle is from the mean of the four tells how linear.
//!
//! *Practice.* Height by height: the middles of all groups, then four points around those that are not free, and
//! then the points of the surfaces that share nothing.

use super::light_source::LightSource;
use crate::camera::bounds_of;
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use argil_abi::{self as abi, FrameUniform};
use glam::{Vec3, vec3};
use multiversion::multiversion;
use std::ops::Range;

/// Distances along the normal.
pub(super) const TAPS: usize = argil_abi::OCCLUSION_TAPS as usize;
/// Surfaces below which a group shares nothing.
const MIN_SHARED: usize = 8;
/// How far the middle's distance may be from the mean of four around it, relative to the height.
const LINEAR: f32 = 0.004;
/// How far the points of a group may be from their middle, relative to the height.
const WIDEST: f32 = 1.5;
/// The corners of a tetrahedron in the unit sphere.
const CORNERS: [Vec3; 4] = {
    let c = 0.577_350_26;
    [
        Vec3::new(c, c, c),
        Vec3::new(c, -c, -c),
        Vec3::new(-c, c, -c),
        Vec3::new(-c, -c, c),
    ]
};

/// Groups, and at one height what they share and what surfaces measure for themselves.
#[derive(Debug, Default)]
pub(super) struct SkyScratch {
    groups: Vec<Group>,
    /// Surfaces that share nothing at any height.
    lone: Vec<u32>,
    candidates: Vec<LinearDistance>,
    shared: Vec<LinearDistance>,
    alone: Vec<u32>,
}

/// Surfaces that may share distances.
#[derive(Clone, Debug)]
struct Group {
    surfaces: Range<usize>,
    /// The middle of points and the mean normal, and how far the surfaces' are from these.
    point: Vec3,
    normal: Vec3,
    spread: [f32; 2],
    /// Whether nothing is nearer than the surfaces themselves at the last height, and below it.
    is_free: bool,
}

/// The distance around a point of a group, as a linear function.
#[derive(Clone, Debug)]
struct LinearDistance {
    group: u32,
    middle: Vec3,
    /// How far the group's points are from the middle.
    radius: f32,
    d: f32,
    gradient: Vec3,
}

/// A height above surfaces, and how much what is nearer there counts.
struct Tap {
    height: f32,
    weight: f32,
    far: f32,
}

impl SkyScratch {
    /// Computes the visible share of the sky for each surface.
    pub(super) fn gather(
        &mut self,
        frame: &FrameUniform,
        surfaces: &Surfaces,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
        out: &mut Vec<f32>,
    ) {
        out.clear();
        out.resize(surfaces.len(), 0.0);
        self.form_groups(frame, surfaces);
        // From the highest on, because where that is free, the others are.
        for index in (0..TAPS).rev() {
            let tap = Tap {
                height: tap_height(frame.radius, index),
                weight: 0.75f32.powi(index as i32),
                far: source.far(),
            };
            self.measure_middles(frame, &tap, source, points);
            self.measure_corners(&tap, source, points);
            for distance in &self.shared {
                let range = self.groups[distance.group as usize].surfaces.clone();
                add_shared(
                    frame,
                    &tap,
                    distance,
                    surfaces.lanes(range.clone()),
                    &mut out[range],
                );
            }
            // A reach of its own belongs to a surface that is near.
            let height_of = |i: usize| tap_height(reach_at(frame, surfaces.length[i]), index);
            points.clear();
            for &i in &self.alone {
                let (p, n) = (surfaces.point(i as usize), surfaces.normal(i as usize));
                points.push(p + n * height_of(i as usize));
            }
            source.measure(points);
            for (&i, &d) in self.alone.iter().zip(&points.d) {
                let i = i as usize;
                let (p, n) = (surfaces.point(i), surfaces.normal(i));
                out[i] += tap.closed(frame, (p, n, height_of(i)), d);
            }
        }
        for closed in out.iter_mut() {
            // Nearly an exponential: no place is black.
            let x = 0.5 * *closed;
            *closed = 1.0 / (1.0 + x * (1.0 + x * (0.5 + x / 6.0)));
        }
    }

    /// Finds the groups whose surfaces may share distances.
    fn form_groups(&mut self, frame: &FrameUniform, surfaces: &Surfaces) {
        let near = bounds_of(frame).grown(tap_height(frame.radius, TAPS - 1));
        // Ground far from the solid sees the whole sky.
        let is_near =
            |i: usize| surfaces.kind[i] != abi::HIT_GROUND || near.contains(surfaces.point(i));
        let has_whole_reach = |i: usize| surfaces.length[i] >= frame.radius;
        self.groups.clear();
        self.lone.clear();
        for group in surfaces.groups() {
            if group.len() >= MIN_SHARED && group.clone().all(|i| is_near(i) && has_whole_reach(i))
            {
                self.groups.push(Group::new(surfaces, group));
            } else {
                self.lone
                    .extend(group.filter(|&i| is_near(i)).map(|i| i as u32));
            }
        }
    }

    /// Measures in the middle of groups. Those that are not free become candidates, if they can.
    fn measure_middles(
        &mut self,
        frame: &FrameUniform,
        tap: &Tap,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        points.clear();
        for group in self.groups.iter().filter(|group| !group.is_free) {
            points.push(group.point + group.normal * tap.height);
        }
        source.measure(points);
        self.alone.clear();
        self.alone.extend_from_slice(&self.lone);
        self.candidates.clear();
        self.shared.clear();
        let mut measured = points.d.iter();
        for (k, group) in self.groups.iter_mut().enumerate() {
            let d = if group.is_free { None } else { measured.next() };
            let mut distance = LinearDistance {
                group: k as u32,
                middle: group.point + group.normal * tap.height,
                radius: group.spread[0] + group.spread[1] * tap.height,
                d: d.copied().unwrap_or(f32::INFINITY),
                gradient: Vec3::ZERO,
            };
            let free = distance.d - distance.radius / frame.inv_lipschitz;
            group.is_free = free >= tap.height / frame.inv_lipschitz;
            if free >= tap.height {
                distance.d = f32::INFINITY;
                self.shared.push(distance);
            } else if distance.radius <= WIDEST * tap.height && distance.d < tap.far {
                self.candidates.push(distance);
            } else {
                self.alone.extend(group.surfaces.clone().map(|i| i as u32));
            }
        }
    }

    /// Measures around the middles of candidates, and finds where the distance is linear.
    fn measure_corners(
        &mut self,
        tap: &Tap,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        points.clear();
        for candidate in &self.candidates {
            CORNERS
                .iter()
                .for_each(|corner| points.push(candidate.middle + candidate.radius * *corner));
        }
        source.measure(points);
        for (candidate, around) in self.candidates.drain(..).zip(points.d.as_chunks::<4>().0) {
            let mean = 0.25 * around.iter().sum::<f32>();
            let is_linear = tap.weight * (mean - candidate.d).abs() <= LINEAR * tap.height;
            if is_linear && around.iter().all(|&d| d < tap.far) {
                let slope = CORNERS.iter().zip(around).map(|(corner, &d)| *corner * d);
                let gradient = slope.sum::<Vec3>() * (0.75 / candidate.radius.max(1e-30));
                self.shared.push(LinearDistance {
                    gradient,
                    ..candidate
                });
            } else {
                let group = &self.groups[candidate.group as usize];
                self.alone.extend(group.surfaces.clone().map(|i| i as u32));
            }
        }
    }
}

impl Group {
    fn new(surfaces: &Surfaces, range: Range<usize>) -> Self {
        let share = 1.0 / range.len() as f32;
        let (mut point, mut normal) = (Vec3::ZERO, Vec3::ZERO);
        for i in range.clone() {
            point += share * surfaces.point(i);
            normal += share * surfaces.normal(i);
        }
        let (mut of_points, mut of_normals) = (0.0f32, 0.0f32);
        for i in range.clone() {
            of_points = of_points.max(surfaces.point(i).distance_squared(point));
            of_normals = of_normals.max(surfaces.normal(i).distance_squared(normal));
        }
        Self {
            surfaces: range,
            point,
            normal,
            spread: [of_points.sqrt(), of_normals.sqrt()],
            is_free: false,
        }
    }
}

/// Adds how closed places are at a height, from a distance that they share.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn add_shared(
    frame: &FrameUniform,
    tap: &Tap,
    distance: &LinearDistance,
    [px, py, pz, nx, ny, nz]: [&[f32]; 6],
    out: &mut [f32],
) {
    let n = out.len();
    let (px, py, pz, nx, ny, nz) = (&px[..n], &py[..n], &pz[..n], &nx[..n], &ny[..n], &nz[..n]);
    for i in 0..n {
        let (p, n) = (vec3(px[i], py[i], pz[i]), vec3(nx[i], ny[i], nz[i]));
        let d = distance.d + distance.gradient.dot(p + n * tap.height - distance.middle);
        out[i] += tap.closed(frame, (p, n, tap.height), d);
    }
}

impl Tap {
    /// Returns how closed a place is at a height, from the distance there.
    #[inline(always)]
    fn closed(&self, frame: &FrameUniform, (p, n, height): (Vec3, Vec3, f32), d: f32) -> f32 {
        let d = if d < self.far { d } else { f32::INFINITY };
        let above = p.y + n.y * height - frame.ground_y;
        let d = if frame.has_ground != 0 && above < d {
            above
        } else {
            d
        };
        let closed = (height - d) / height;
        if closed > 0.0 {
            self.weight * closed
        } else {
            0.0
        }
    }
}

/// Returns the height of an occlusion tap above the surface, for a reach around it.
pub(super) fn tap_height(radius: f32, tap: usize) -> f32 {
    let step = (tap + 1) as f32 / TAPS as f32;
    radius * 0.16 * step * step
}

/// Returns how far around a hit occlusion is gathered: what is a detail depends on the distance that it is seen from,
/// and in a large world not on the world's size.
pub(super) fn reach_at(frame: &FrameUniform, length: f32) -> f32 {
    frame.radius.min(length)
}
