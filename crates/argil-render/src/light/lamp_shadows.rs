//! How much of a lamp surfaces see. `lamp_shadows.wgsl` is the twin.
//!
//! *Theory.* A ray to the middle of a lamp tells whether the whole cone to it is free: nothing is nearer than the cone's sides. What is no
//! nearer than the surface's plane is the surface. What is no nearer than the lamp's plane is what the lamp hangs on. Both are
//! behind the cone. If the cone is not free, rays to points of the lamp count, each by what would arrive from there. A ray
//! fades in and out over the gap between two points, so that few points leave no steps. The points differ from sample to sample.
//!
//! *Practice.* The flat surfaces of a block of pixels share a cone, and those of a group share one to each point.

use super::lamp_shape::{LampShape, SeenLamp, weight};
use super::lamps::lamp_above;
use super::light_source::LightSource;
use super::patches::{Patch, patch_of};
use super::shadow_rays::{Seen, ShadowRay, ShadowRays, covered};
use crate::camera::bounds_of;
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use argil_abi::{self as abi, FrameUniform};
use glam::Vec3;
use std::ops::Range;

/// A lamp that looks narrower than this from a surface is a point. Its edges are as soft as this.
const NARROW: f32 = 1.0 / 400.0;
/// What a ray saw that met nothing.
const CLEAR: Seen = Seen {
    least: 1.0,
    free: [0.0, 1.0],
};
/// Surfaces of a whole group, row by row, and those of its corners.
const WHOLE_GROUP: usize = 16;
const CORNERS: [usize; 4] = [0, 3, 12, 15];
/// Where a penumbra is so even, the corners give the others. The numbers are how far shares must be from 0 and 1, how much they may
/// differ, and how much of that may not be linear.
const EVEN: [f32; 3] = [0.03, 0.3, 0.03];
/// A share that is not known yet.
const UNKNOWN: f32 = -1.0;

/// The shadows of a lamp.
#[derive(Debug, Default)]
pub(super) struct LampShadows {
    /// The visible share of the lamp, one per surface.
    shares: Vec<f32>,
    /// Surfaces whose shares are not known.
    open: Vec<u32>,
    patches: Vec<Patch>,
    /// The surfaces of whole groups of which only the corners are open.
    group_members: Vec<u32>,
    rays: ShadowRays,
    /// What rays have seen, by their ids.
    seen: Vec<Seen>,
    /// The shares of the way to the lamp up to which and from which on nothing is in the way, one per surface.
    free: Vec<[f32; 2]>,
    /// The light that has arrived, and what would arrive without shadows, for surfaces that are open.
    sums: Vec<[f32; 2]>,
}

/// Returns the greatest distance that shadows of lamps ask for.
pub(super) fn reach(frame: &FrameUniform) -> f32 {
    let lamps = frame.lamps.chunks(4).take(frame.lamp_count as usize);
    let width = |rows| {
        let lamp = LampShape::of(rows, frame);
        let share = bounds_of(frame).half_diagonal() / frame.far.max(1e-20);
        lamp.radius * if lamp.is_sun { 2.0 * share } else { 1.0 }
    };
    lamps.map(width).fold(0.0, f32::max)
}

/// Returns how the points of a sample are shifted: not at all in an image with one sample.
fn shift_of(image_place: [f32; 2]) -> [f32; 2] {
    image_place.map(|x| (x - x.floor() + 0.5).fract())
}

impl LampShadows {
    /// Returns the visible share of a lamp for each surface.
    pub(super) fn gather(
        &mut self,
        frame: &FrameUniform,
        rows: &[[f32; 4]],
        surfaces: &Surfaces,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) -> &[f32] {
        let lamp = LampShape::of(rows, frame);
        self.shares.clear();
        self.shares.extend((0..surfaces.len()).map(|i| {
            let n = surfaces.normal(i);
            let light_above = lamp_above(rows, surfaces.point(i), n);
            let shines =
                light_above.light.max_element() > 0.0 && n.dot(light_above.direction) > 0.0;
            if shines { UNKNOWN } else { 0.0 }
        }));
        self.free.clear();
        self.free.resize(surfaces.len(), CLEAR.free);
        self.open.clear();
        self.open.extend(0..surfaces.len() as u32);
        self.keep_open();
        for is_block in [true, false] {
            if is_block {
                self.find_patches(frame, surfaces, source, surfaces.blocks());
            } else {
                self.find_patches(frame, surfaces, source, surfaces.groups());
            }
            self.march_patches(frame, &lamp, source, points);
            self.keep_open();
        }
        self.march_cones(frame, &lamp, surfaces, source, points);
        self.keep_open();
        self.split_groups(frame, surfaces, source);
        self.trace_points(frame, &lamp, surfaces, source, points);
        self.fill_groups();
        self.trace_points(frame, &lamp, surfaces, source, points);
        &self.shares
    }

    /// Forgets surfaces whose shares are known.
    fn keep_open(&mut self) {
        let shares = &self.shares;
        self.open.retain(|&i| shares[i as usize] == UNKNOWN);
    }

    /// Finds flat patches of open surfaces in parts of all surfaces, which follow one another.
    fn find_patches(
        &mut self,
        frame: &FrameUniform,
        surfaces: &Surfaces,
        source: &LightSource<'_, '_>,
        parts: impl Iterator<Item = Range<usize>>,
    ) {
        self.patches.clear();
        let mut first = 0;
        for part in parts {
            let mut last = first;
            while last < self.open.len() && (self.open[last] as usize) < part.end {
                last += 1;
            }
            let patch = patch_of(frame, surfaces, source, &self.open, first..last);
            // Distances beyond are not known.
            let fits = |patch: &Patch| patch.is_flat() && patch.radius < source.far();
            self.patches.extend(patch.filter(fits));
            first = last;
        }
    }

    /// Leaves open only the corners of whole flat groups, and what is in no such group.
    fn split_groups(
        &mut self,
        frame: &FrameUniform,
        surfaces: &Surfaces,
        source: &LightSource<'_, '_>,
    ) {
        self.find_runs(frame, surfaces, source);
        self.group_members.clear();
        let all = std::mem::take(&mut self.open);
        for patch in &self.patches {
            let members = &all[patch.members.clone()];
            if patch.is_flat() && members.len() == WHOLE_GROUP {
                self.group_members.extend_from_slice(members);
                self.open.extend(CORNERS.map(|index| members[index]));
            } else {
                self.open.extend_from_slice(members);
            }
        }
    }

    /// Gives groups the shares between those of their corners. Leaves open what is not even.
    fn fill_groups(&mut self) {
        let [rim, most, bend] = EVEN;
        self.open.clear();
        for members in self.group_members.chunks_exact(WHOLE_GROUP) {
            let corners = CORNERS.map(|index| self.shares[members[index] as usize]);
            let low = corners.iter().copied().fold(1.0, f32::min);
            let high = corners.iter().copied().fold(0.0, f32::max);
            let [a, b, c, d] = corners;
            let is_even =
                low > rim && high < 1.0 - rim && high - low < most && (a + d - b - c).abs() < bend;
            for (index, &i) in members.iter().enumerate() {
                if CORNERS.contains(&index) {
                    continue;
                }
                if is_even {
                    let [u, v] = [index % 4, index / 4].map(|k| k as f32 / 3.0);
                    let upper = a + u * (b - a);
                    self.shares[i as usize] = upper + v * (c + u * (d - c) - upper);
                } else {
                    self.open.push(i);
                }
            }
        }
    }

    /// Sends rays to all points of the lamp from open surfaces.
    fn trace_points(
        &mut self,
        frame: &FrameUniform,
        lamp: &LampShape,
        surfaces: &Surfaces,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        if self.open.is_empty() {
            return;
        }
        self.sums.clear();
        self.sums.resize(self.open.len(), [0.0; 2]);
        self.find_runs(frame, surfaces, source);
        for index in 0..abi::LAMP_POINTS {
            self.march_points(frame, lamp, index, surfaces, source, points);
        }
        for (&i, [arrives, whole]) in self.open.iter().zip(&self.sums) {
            self.shares[i as usize] = arrives / whole.max(1e-30);
        }
    }

    /// Finds the open surfaces of a group and a sample, which share points of lamps.
    fn find_runs(
        &mut self,
        frame: &FrameUniform,
        surfaces: &Surfaces,
        source: &LightSource<'_, '_>,
    ) {
        self.patches.clear();
        let mut first = 0;
        for part in surfaces.groups() {
            while first < self.open.len() && (self.open[first] as usize) < part.end {
                let sample = |at: usize| shift_of(surfaces.image_place(self.open[at] as usize));
                let same = |at: usize| {
                    let [a, b] = [sample(at), sample(first)];
                    (a[0] - b[0]).abs() < 1e-3 && (a[1] - b[1]).abs() < 1e-3
                };
                let mut last = first + 1;
                while last < self.open.len() && (self.open[last] as usize) < part.end && same(last)
                {
                    last += 1;
                }
                let patch = patch_of(frame, surfaces, source, &self.open, first..last);
                self.patches.extend(patch);
                first = last;
            }
        }
    }

    /// Sends a cone from each patch to the whole lamp.
    fn march_patches(
        &mut self,
        frame: &FrameUniform,
        lamp: &LampShape,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        self.begin(self.patches.len());
        for (index, patch) in self.patches.iter().enumerate() {
            let seen = lamp.seen_from(patch.center, frame);
            let over = patch.normal.dot(seen.middle - patch.center) - patch.radius;
            if over < seen.radius {
                self.seen[index].least = 0.0;
                continue;
            }
            let ray = patch.ray(lamp, seen.middle, seen.radius);
            let free = self.free_of(patch);
            self.rays.push(index, ray, frame, free);
        }
        self.rays.march(&mut self.seen, frame, source, points);
        for (patch, seen) in self.patches.iter().zip(&self.seen) {
            for &i in &self.open[patch.members.clone()] {
                // Above a patch, a cone that is not free all the way tells little.
                self.free[i as usize][1] = seen.free[1];
                if seen.least.abs() >= 1.0 {
                    self.shares[i as usize] = seen.least.max(0.0);
                }
            }
        }
    }

    /// Sends a cone from each open surface to the whole lamp.
    fn march_cones(
        &mut self,
        frame: &FrameUniform,
        lamp: &LampShape,
        surfaces: &Surfaces,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        self.begin(self.open.len());
        let (lift, step) = (source.lift(frame), source.min_step(frame));
        let is_narrow = |seen: &SeenLamp, p: Vec3| seen.radius < NARROW * p.distance(seen.middle);
        for (index, &i) in self.open.iter().enumerate() {
            let (p, n) = (surfaces.point(i as usize), surfaces.normal(i as usize));
            let length = surfaces.length[i as usize];
            let seen = lamp.seen_from(p, frame);
            let is_point = is_narrow(&seen, p);
            if n.dot(seen.middle - p) < seen.radius && !is_point {
                self.seen[index].least = 0.0;
                continue;
            }
            let radius = seen.radius.max(0.5 * NARROW * p.distance(seen.middle));
            let heights = [lift.at(length), 0.0];
            let radii = [0.0, radius];
            let mut ray =
                ShadowRay::new(lamp, (p, n), heights, seen.middle, radii, step.at(length));
            ray.is_point = is_point;
            self.rays.push(index, ray, frame, self.free[i as usize]);
        }
        self.rays.march(&mut self.seen, frame, source, points);
        for (&i, seen) in self.open.iter().zip(&self.seen) {
            let p = surfaces.point(i as usize);
            self.free[i as usize] = seen.free;
            if seen.least.abs() >= 1.0 || is_narrow(&lamp.seen_from(p, frame), p) {
                self.shares[i as usize] = covered(seen.least);
            }
        }
    }

    /// Adds what arrives from one point of the lamp at open surfaces.
    fn march_points(
        &mut self,
        frame: &FrameUniform,
        lamp: &LampShape,
        index: u32,
        surfaces: &Surfaces,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        self.begin(self.patches.len());
        let gap = |seen: &SeenLamp| seen.extent / abi::LAMP_POINTS as f32;
        let place = |at: u32| shift_of(surfaces.image_place(at as usize));
        for (id, patch) in self.patches.iter().enumerate() {
            let seen = lamp.seen_from(patch.center, frame);
            let target = seen.point(index, place(self.open[patch.members.start]));
            let over = patch.normal.dot(target - patch.center) - patch.radius;
            if !patch.is_flat() || patch.radius >= source.far() || over < 0.0 {
                self.seen[id].least = 0.0;
                continue;
            }
            // The discs of several surfaces are turned.
            let turned = if seen.is_disc {
                seen.radius * patch.radius / target.distance(patch.center).max(1e-20)
            } else {
                0.0
            };
            let ray = patch.ray(lamp, target, gap(&seen) + turned);
            let free = self.free_of(patch);
            self.rays.push(id, ray, frame, free);
        }
        self.rays.march(&mut self.seen, frame, source, points);
        let shared = std::mem::take(&mut self.seen);
        self.begin(self.open.len());
        let (lift, step) = (source.lift(frame), source.min_step(frame));
        for (patch, &shadow) in self.patches.iter().zip(&shared) {
            for at in patch.members.clone() {
                self.seen[at] = shadow;
                if shadow.least.abs() >= 1.0 {
                    continue;
                }
                let i = self.open[at] as usize;
                let (p, n) = (surfaces.point(i), surfaces.normal(i));
                let seen = lamp.seen_from(p, frame);
                let target = seen.point(index, place(self.open[at]));
                self.seen[at] = CLEAR;
                if n.dot(target - p) <= 0.0 {
                    continue;
                }
                let length = surfaces.length[i];
                let heights = [lift.at(length), 0.0];
                let radii = [0.0, gap(&seen)];
                let mut ray = ShadowRay::new(lamp, (p, n), heights, target, radii, step.at(length));
                ray.is_point = true;
                self.rays.push(at, ray, frame, self.free[i]);
            }
        }
        self.rays.march(&mut self.seen, frame, source, points);
        for ((&i, shadow), sums) in self.open.iter().zip(&self.seen).zip(&mut self.sums) {
            let p = surfaces.point(i as usize);
            let target = lamp.seen_from(p, frame).point(index, place(i));
            let weight = weight(lamp, target - p, surfaces.normal(i as usize));
            sums[0] += weight * covered(shadow.least);
            sums[1] += weight;
        }
    }

    /// Returns the shares of the way up to which and from which on nothing is in the way of all surfaces of a patch.
    fn free_of(&self, patch: &Patch) -> [f32; 2] {
        let members = self.open[patch.members.clone()].iter();
        let free = members.map(|&i| self.free[i as usize]);
        free.fold([1.0, 0.0], |all, range| {
            [all[0].min(range[0]), all[1].max(range[1])]
        })
    }

    fn begin(&mut self, count: usize) {
        self.rays.clear();
        self.seen.clear();
        self.seen.resize(count, CLEAR);
    }
}
