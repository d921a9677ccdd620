//! How much of the sun surfaces see.
//!
//! *Theory.* A ray to the sun sees a share of it: the smallest ratio of distance to way, times a constant. The rays
//! of a block lie in a cylinder around its middle one. Where the distance at the middle is large enough for all of
//! them, none is shadowed, and where the middle is deeper in the solid than the cylinder is wide, all are.
//!
//! *Practice.* Blocks march first, and find from where on all of their rays are free. Up to there, their groups march,
//! and up to where these are free, rays: few surfaces need any.

use super::light_source::LightSource;
use crate::camera::bounds_of;
use crate::ray_batch::Points;
use crate::source::ByLength;
use crate::surfaces::Surfaces;
use argil_abi::FrameUniform;
use glam::{Vec3, vec3};
use multiversion::multiversion;
use std::ops::Range;

/// Reciprocal of the tangent of the penumbra's half angle.
pub(crate) const SHARPNESS: f32 = argil_abi::SHADOW_SHARPNESS;
/// Maximum steps of a ray to the sun.
pub const SHADOW_STEPS: u32 = argil_abi::SHADOW_STEPS;
/// How far surfaces may be from their plane, relative to their cylinder's radius.
const FLAT: f32 = 0.1;
/// How near the plane's distance the measured one must be.
const PLANE: f32 = 0.9;
/// At this share, a ray ends as shadowed.
const DARK: f32 = 0.005;

/// Rays to the sun, and the cylinders around those of a block.
#[derive(Debug, Default)]
pub(super) struct SunScratch {
    rays: ShadowRays,
    beams: Vec<Beam>,
    /// The beams that still march.
    under_way: Vec<u32>,
}

/// The rays of a block or a group, in a cylinder around the middle.
#[derive(Debug)]
struct Beam {
    /// Its rays.
    rays: Range<usize>,
    center: Vec3,
    radius: f32,
    t: f32,
    end: f32,
    /// From here on, no ray is shadowed.
    free_from: f32,
    /// If the surfaces lie in a plane: how fast the middle ray leaves that, and from where on it is far enough away.
    rise: f32,
    leaves: f32,
    begin: f32,
    /// Whether all rays are shadowed.
    is_dark: bool,
    min_step: f32,
}

/// Rays to the sun, as a structure of arrays.
#[derive(Debug, Default)]
struct ShadowRays {
    surface: Vec<u32>,
    origin: [Vec<f32>; 3],
    t: Vec<f32>,
    end: Vec<f32>,
    min_step: Vec<f32>,
    /// The visible share so far.
    share: Vec<f32>,
    places: Vec<u32>,
}

impl SunScratch {
    /// Computes the visible share of the sun for each surface.
    pub(super) fn gather(
        &mut self,
        frame: &FrameUniform,
        surfaces: &Surfaces,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
        out: &mut Vec<f32>,
    ) {
        out.clear();
        out.resize(surfaces.len(), 1.0);
        self.start(frame, surfaces, source);
        self.enclose(frame, surfaces, surfaces.blocks());
        self.march_beams(frame, source, points);
        self.enclose(frame, surfaces, surfaces.groups());
        self.march_beams(frame, source, points);
        let rays = &mut self.rays;
        rays.close(out);
        let (batch, far) = (source.batch(), source.far());
        let sun = frame.sun;
        let mut steps = 0;
        while !rays.t.is_empty() && steps < SHADOW_STEPS {
            steps += 1;
            let (count, mut ended) = (rays.t.len(), 0);
            for first in (0..count).step_by(batch) {
                let n = batch.min(count - first);
                points.resize(n);
                rays.place(sun, first, points);
                source.measure(points);
                ended += rays.step(frame, (far, steps), first, &points.d);
            }
            // Moving rays costs more than marching a few in vain.
            if 4 * ended >= count || batch == usize::MAX {
                rays.close(out);
            }
        }
        for (&surface, &share) in rays.surface.iter().zip(&rays.share) {
            out[surface as usize] = share;
        }
    }

    /// Loads the rays of all surfaces. Those that face away from the sun, and those that meet nothing, have ended.
    fn start(&mut self, frame: &FrameUniform, surfaces: &Surfaces, source: &LightSource<'_, '_>) {
        let n = surfaces.len();
        let rays = &mut self.rays;
        rays.surface.clear();
        rays.surface.extend(0..n as u32);
        for lanes in rays.lanes() {
            lanes.clear();
            lanes.resize(n, 1.0);
        }
        let offsets = [source.lift(frame), source.min_step(frame)];
        start_rays(frame, surfaces, offsets, rays);
    }

    /// Puts the rays of parts of the surfaces, which follow one another, into cylinders.
    fn enclose(
        &mut self,
        frame: &FrameUniform,
        surfaces: &Surfaces,
        parts: impl Iterator<Item = Range<usize>>,
    ) {
        let sun = Vec3::from(frame.sun);
        let rays = &self.rays;
        self.beams.clear();
        let mut first = 0;
        for part in parts {
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let (mut begin, mut end, mut min_step) = (f32::INFINITY, 0.0f32, f32::INFINITY);
            let mut last = first;
            let (mut sum, mut normals, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0);
            while last < rays.surface.len() && (rays.surface[last] as usize) < part.end {
                let origin = rays.origin(last);
                // The others are known to be free or shadowed.
                if rays.t[last] < rays.end[last] {
                    (low, high) = (low.min(origin), high.max(origin));
                    sum += origin;
                    normals += surfaces.normal(rays.surface[last] as usize);
                    count += 1.0;
                    begin = begin.min(rays.t[last]);
                    min_step = min_step.min(rays.min_step[last]);
                    end = end.max(rays.end[last]);
                }
                last += 1;
            }
            if begin < end {
                let radius = 0.500_1 * low.distance(high);
                let n = normals / count;
                let is_flat = |i: usize| {
                    let away = (rays.origin(i) - sum / count).dot(n).abs();
                    away <= FLAT * radius || rays.t[i] >= rays.end[i]
                };
                let is_flat = n.length_squared() > 0.95 && (first..last).all(is_flat);
                let rise = if is_flat { n.dot(sun) } else { 0.0 };
                // To where a plane is far enough below.
                let over = rise - 1.0 / SHARPNESS;
                let (rise, leaves) = if over > 0.3 {
                    (rise, begin + (1.0 + FLAT) * radius / over)
                } else {
                    (0.0, begin)
                };
                self.beams.push(Beam {
                    rays: first..last,
                    center: 0.5 * (low + high),
                    radius,
                    t: if rise > 0.0 {
                        begin + 0.3 * radius
                    } else {
                        begin
                    },
                    rise,
                    leaves,
                    begin,
                    end,
                    free_from: begin,
                    is_dark: false,
                    min_step,
                });
            }
            first = last;
        }
    }

    /// Finds from where on the rays of each cylinder are free, and ends them there.
    fn march_beams(
        &mut self,
        frame: &FrameUniform,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        let (sun, scale) = (Vec3::from(frame.sun), frame.inv_lipschitz);
        self.under_way.clear();
        self.under_way.extend(0..self.beams.len() as u32);
        let mut steps = 0;
        while !self.under_way.is_empty() {
            steps += 1;
            points.clear();
            for &i in &self.under_way {
                let beam = &self.beams[i as usize];
                points.push(beam.center + sun * beam.t);
            }
            source.measure(points);
            let mut kept = 0;
            for k in 0..self.under_way.len() {
                let beam = &mut self.beams[self.under_way[k] as usize];
                let d = points.d[k];
                let around = d - beam.radius / scale;
                let is_free = SHARPNESS * around >= beam.t;
                if beam.rise > 0.0 {
                    // As long as nothing is nearer than the plane, no ray is shadowed above it.
                    let is_left = beam.t >= beam.leaves;
                    let is_plane = d >= PLANE * beam.rise * (beam.t - beam.begin);
                    let holds = if is_left { is_free } else { is_plane };
                    if !is_left && holds {
                        beam.t += (0.5 * d * scale).max(0.1 * beam.radius).max(beam.min_step);
                    } else if !holds {
                        beam.t = beam.begin;
                    }
                    if is_left || !holds {
                        beam.rise = 0.0;
                    }
                    if !is_left || !holds {
                        self.under_way[kept] = self.under_way[k];
                        kept += 1;
                        continue;
                    }
                }
                let step = if is_free {
                    (around * scale).max(beam.min_step)
                } else {
                    (d * scale).max(beam.radius).max(beam.min_step)
                };
                beam.t += step;
                if !is_free {
                    beam.free_from = beam.t;
                }
                if d * scale <= -beam.radius {
                    beam.is_dark = true;
                } else if steps >= SHADOW_STEPS && beam.t < beam.end {
                    beam.free_from = f32::INFINITY;
                } else if beam.t < beam.end {
                    self.under_way[kept] = self.under_way[k];
                    kept += 1;
                }
            }
            self.under_way.truncate(kept);
        }
        for beam in &self.beams {
            if beam.is_dark {
                // The others are not in the cylinder.
                for i in beam.rays.clone() {
                    if self.rays.t[i] < self.rays.end[i] {
                        self.rays.share[i] = 0.0;
                    }
                }
            }
            let last = if beam.is_dark { -1.0 } else { beam.free_from };
            for end in &mut self.rays.end[beam.rays.clone()] {
                *end = end.min(last);
            }
        }
    }
}

impl ShadowRays {
    /// Returns all arrays of numbers.
    fn lanes(&mut self) -> [&mut Vec<f32>; 7] {
        let [x, y, z] = &mut self.origin;
        let Self {
            t,
            end,
            min_step,
            share,
            ..
        } = self;
        [x, y, z, t, end, min_step, share]
    }

    fn origin(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.origin;
        vec3(x[i], y[i], z[i])
    }

    fn truncate(&mut self, n: usize) {
        self.surface.truncate(n);
        for lanes in self.lanes() {
            lanes.truncate(n);
        }
    }

    /// Computes the positions of rays from `first` on.
    fn place(&self, sun: [f32; 3], first: usize, points: &mut Points) {
        let Points { x, y, z, .. } = points;
        for (axis, p) in [x, y, z].into_iter().enumerate() {
            let origin = &self.origin[axis][first..];
            let along = origin.iter().zip(&self.t[first..]);
            for (p, (origin, t)) in p.iter_mut().zip(along) {
                *p = origin + sun[axis] * t;
            }
        }
    }

    /// Advances rays from `first` on by their distances. Returns how many have ended.
    fn step(
        &mut self,
        frame: &FrameUniform,
        (far, steps): (f32, u32),
        first: usize,
        d: &[f32],
    ) -> usize {
        let range = first..first + d.len();
        let rays = (
            &mut self.t[range.clone()],
            &mut self.share[range.clone()],
            &mut self.end[range.clone()],
            &self.min_step[range],
        );
        let due = due_after(frame, steps);
        step_rays([frame.epsilon, frame.inv_lipschitz, far, due], d, rays)
    }

    /// Closes the gaps that rays leave, and writes what they saw.
    fn close(&mut self, out: &mut [f32]) {
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        for (i, (&t, &end)) in self.t.iter().zip(&self.end).enumerate() {
            if t < end {
                places.push(i as u32);
            } else {
                out[self.surface[i] as usize] = self.share[i];
            }
        }
        for lanes in self.lanes() {
            for (to, &from) in places.iter().enumerate() {
                lanes[to] = lanes[from as usize];
            }
        }
        for (to, &from) in places.iter().enumerate() {
            self.surface[to] = self.surface[from as usize];
        }
        self.truncate(places.len());
        self.places = places;
    }
}

/// Computes where rays to the sun begin and end, as `Ray::span` does, given how far above the surface they begin, and
/// their shortest steps.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn start_rays(
    frame: &FrameUniform,
    surfaces: &Surfaces,
    [lift, min_step]: [ByLength; 2],
    rays: &mut ShadowRays,
) {
    let bounds = bounds_of(frame);
    let sun = frame.sun;
    let inverse = sun.map(|d| 1.0 / if d.abs() < 1e-20 { 1e-20 } else { d });
    let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
    let n = rays.t.len();
    let [px, py, pz, nx, ny, nz] = surfaces.lanes(0..n);
    let length = &surfaces.length[..n];
    let [ox, oy, oz] = &mut rays.origin;
    let (ox, oy, oz) = (&mut ox[..n], &mut oy[..n], &mut oz[..n]);
    let (t, end, step) = (
        &mut rays.t[..n],
        &mut rays.end[..n],
        &mut rays.min_step[..n],
    );
    for i in 0..n {
        step[i] = min_step.at(length[i]);
        let lift = lift.at(length[i]);
        (ox[i], oy[i], oz[i]) = (
            px[i] + nx[i] * lift,
            py[i] + ny[i] * lift,
            pz[i] + nz[i] * lift,
        );
    }
    for i in 0..n {
        let slab = |o: f32, k: usize| {
            let (a, b) = ((low[k] - o) * inverse[k], (high[k] - o) * inverse[k]);
            if a < b { (a, b) } else { (b, a) }
        };
        let ((ax, bx), (ay, by), (az, bz)) = (slab(ox[i], 0), slab(oy[i], 1), slab(oz[i], 2));
        let near = ax.max(ay).max(az).max(0.0);
        let far = bx.min(by).min(bz);
        let facing = nx[i] * sun[0] + ny[i] * sun[1] + nz[i] * sun[2];
        t[i] = near;
        end[i] = if facing > 0.0 && near <= far {
            far
        } else {
            -1.0
        };
    }
}

/// Returns how far a ray to the sun has to be after a number of steps. One that still marches after all of them would count as lit.
fn due_after(frame: &FrameUniform, steps: u32) -> f32 {
    let share = steps as f32 / SHADOW_STEPS as f32;
    share * share * share * (2.0 * frame.radius)
}

/// Advances rays: their ways, their shares, their ends, and their shortest steps. Returns how many have ended.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn step_rays(
    [epsilon, scale, far, due]: [f32; 4],
    d: &[f32],
    (t, share, end, min_step): (&mut [f32], &mut [f32], &mut [f32], &[f32]),
) -> usize {
    let n = d.len();
    let (t, share, end) = (&mut t[..n], &mut share[..n], &mut end[..n]);
    let min_step = &min_step[..n];
    let mut ended = 0u32;
    for i in 0..n {
        let along = if t[i] > epsilon { t[i] } else { epsilon };
        let open = SHARPNESS * d[i] / along;
        let open = if open > 0.0 { open } else { 0.0 };
        let open = if open < 1.0 && d[i] < far { open } else { 1.0 };
        // A ray in a gap has ended, and its share stands.
        let goes = t[i] < end[i];
        let least = if open < share[i] && goes {
            open
        } else {
            share[i]
        };
        share[i] = least;
        let way = d[i] * scale;
        let next = t[i] + if way > min_step[i] { way } else { min_step[i] };
        let next = if next > due { next } else { due };
        let is_dark = open <= DARK;
        t[i] = next;
        end[i] = if is_dark && goes { -1.0 } else { end[i] };
        ended += u32::from(t[i] >= end[i]);
    }
    ended as usize
}
