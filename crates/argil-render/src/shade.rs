//! Light. `shade.wgsl` is the twin.
//!
//! *Theory.* There is one sun and a sky. Direct light is a GGX lobe over a Lambertian body (Walter et al. 2007,
//! with Schlick's Fresnel and Smith's visibility as fitted by Karis, 2013). The sun's shadow is soft where its ray
//! comes close to the surface (after Quilez, "Soft shadows in raymarched SDFs", 2010). The sky's light is reduced
//! where the surface is nearer than an open one along the normal (after Evans, "Fast approximations for global
//! illumination on dynamic scenes", 2006). The tone curve is Narkowicz's fit of ACES (2015).

use crate::camera::{bounds_of, primary_ray};
use crate::false_colors::{depth, heat, id_color, level_color};
use crate::probe::FieldProbe;
use crate::ray_batch::Points;
use crate::source::DistanceSource;
use crate::tile::Tile;
use crate::tile_buffers::{Shading, TileScratch};
use argil_abi::{self as abi, FrameUniform, GpuMaterial, Hit};
use argil_math::{Aabb, Ray};
use glam::{Vec3, vec3};

/// Maximum steps of a ray to the sun.
pub const SHADOW_STEPS: u32 = 64;
/// Reciprocal of the tangent of the penumbra's half angle.
const SHADOW_SHARPNESS: f32 = argil_abi::SHADOW_SHARPNESS;
const OCCLUSION_TAPS: usize = argil_abi::OCCLUSION_TAPS as usize;
const SUN_LIGHT: Vec3 = Vec3::from_array(argil_abi::SUN_LIGHT);
const ZENITH: Vec3 = Vec3::from_array(argil_abi::ZENITH);
const HORIZON: Vec3 = Vec3::from_array(argil_abi::HORIZON);
const NADIR: Vec3 = Vec3::from_array(argil_abi::NADIR);
const GROUND: GpuMaterial = GpuMaterial {
    base_roughness: [0.46, 0.45, 0.43, 0.9],
    emission_metallic: [0.0, 0.0, 0.0, 0.0],
};

/// Where light reads distances: stored ones, or the exact field.
#[derive(Clone, Copy)]
struct Sky<'a>(Option<&'a dyn DistanceSource>);

impl Sky<'_> {
    /// Returns the stored material at a point of the surface, given the outward direction.
    fn material(self, probe: &FieldProbe<'_>, point: Vec3, outward: Vec3) -> Option<GpuMaterial> {
        let materials = probe.evaluator.program().materials();
        self.0?.material(point, outward, materials)
    }

    /// Computes the distances of points into their `d`.
    fn measure(self, probe: &mut FieldProbe<'_>, points: &mut Points) {
        match self.0 {
            None => probe.measure(points),
            Some(air) => air.measure(points),
        }
    }

    /// Returns the shortest step of a shadow's ray, for a hit at a length of its ray.
    fn min_step(self, frame: &FrameUniform, length: f32) -> f32 {
        match self.0 {
            None => 2.0 * frame.epsilon,
            Some(air) => air.min_step(frame, length),
        }
    }

    /// Returns how far above the surface the shadow of a hit at a length of its ray begins.
    fn lift(self, frame: &FrameUniform, length: f32) -> f32 {
        match self.0 {
            None => frame.light_offset,
            Some(air) => air.lift(frame, length),
        }
    }

    /// Returns the distance beyond which results are clamped.
    fn far(self, probe: &FieldProbe<'_>) -> f32 {
        match self.0 {
            None => probe.far(),
            Some(_) => f32::INFINITY,
        }
    }
}

/// Returns the box of all points whose distances an image uses, and the distance beyond which they do not matter.
pub(crate) fn light_reach(frame: &FrameUniform) -> (Aabb, f32) {
    let bounds = bounds_of(frame);
    let tap = tap_height(frame.radius, OCCLUSION_TAPS - 1);
    let bias = frame.normal_bias;
    let around = bounds.grown(tap + 2.0 * bias);
    // A shadow may be cast from farther away where it is wider, and no ray is longer than the box.
    let penumbra = 2.0 * bounds.half_diagonal() / SHADOW_SHARPNESS;
    (around, tap.max(penumbra))
}

/// Adds the colors of a tile's hits, times the frame's sample weight, to `out`: RGB and coverage. Shaded colors are
/// linear, after the tone curve. Other modes add their own values.
///
/// # Panics
/// If `hits` or `out` is shorter than the tile's area.
pub(crate) fn shade_tile(
    frame: &FrameUniform,
    tile: Tile,
    probe: &mut FieldProbe<'_>,
    air: Option<&dyn DistanceSource>,
    scratch: &mut TileScratch,
    hits: &[Hit],
    out: &mut [[f32; 4]],
) {
    let TileScratch {
        points, shading, ..
    } = scratch;
    if frame.mode == abi::MODE_SHADED {
        shading.gather(frame, tile, probe, Sky(air), points, hits);
    }
    let mut next_lit = 0;
    for (i, (hit, out)) in hits.iter().zip(out).enumerate().take(tile.area()) {
        let (x, y) = tile.pixel(i);
        let color = match frame.mode {
            abi::MODE_NORMAL if hit.kind != abi::HIT_NONE => {
                vec3(hit.normal_t[0], hit.normal_t[1], hit.normal_t[2]) * 0.5 + 0.5
            }
            abi::MODE_DEPTH if hit.kind != abi::HIT_NONE => {
                Vec3::splat(depth(frame, hit.normal_t[3]))
            }
            abi::MODE_HEAT => heat(hit.steps),
            abi::MODE_BRICKS | abi::MODE_NODES if hit.id != 0 => id_color(hit),
            abi::MODE_LEVELS if hit.id != 0 => level_color(hit),
            abi::MODE_SHADED => {
                let ray = primary_ray(frame, x, y);
                let light = if hit.kind == abi::HIT_NONE {
                    sky(frame, ray.direction)
                } else {
                    let k = next_lit;
                    next_lit += 1;
                    shade_surface(
                        frame,
                        ray,
                        hit,
                        &shading.materials[k],
                        shading.sun[k],
                        shading.sky[k],
                    )
                };
                tone_map(light)
            }
            _ => Vec3::ZERO,
        };
        let weight = frame.sample_weight;
        let covered = if matches!(hit.kind, abi::HIT_OUTSIDE | abi::HIT_INSIDE) {
            1.0
        } else {
            0.0
        };
        for (out, value) in out.iter_mut().zip([color.x, color.y, color.z, covered]) {
            *out += value * weight;
        }
    }
}

impl Shading {
    /// Evaluates the field for all surfaces of the tile: materials, sun, sky.
    fn gather(
        &mut self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        air: Sky<'_>,
        points: &mut Points,
        hits: &[Hit],
    ) {
        self.lit.clear();
        self.lit
            .extend((0..tile.area() as u32).filter(|&i| hits[i as usize].kind != abi::HIT_NONE));
        let surface = |i: u32| {
            let hit = &hits[i as usize];
            let (x, y) = tile.pixel(i as usize);
            let position = primary_ray(frame, x, y).at(hit.normal_t[3]);
            (
                position,
                vec3(hit.normal_t[0], hit.normal_t[1], hit.normal_t[2]),
            )
        };
        let lifted = |i: u32| {
            let (p, n) = surface(i);
            let length = hits[i as usize].normal_t[3];
            let origin = p + n * air.lift(frame, length);
            (origin, n, air.min_step(frame, length))
        };

        // Materials at the solid's surface. The ground has its own. The field gives what bricks do not have.
        let solid = |&i: &u32| hits[i as usize].kind != abi::HIT_GROUND;
        points.clear();
        self.materials.clear();
        self.unresolved.clear();
        for i in &self.lit {
            let mut own = GROUND;
            if solid(i) {
                let (p, n) = surface(*i);
                let is_inside = hits[*i as usize].kind == abi::HIT_INSIDE;
                match air.material(probe, p, if is_inside { -n } else { n }) {
                    Some(stored) => own = stored,
                    None => {
                        self.unresolved.push(self.materials.len() as u32);
                        points.push(p);
                    }
                }
            }
            self.materials.push(own);
        }
        self.found.resize(points.x.len(), GROUND);
        probe.materials(points, &mut self.found);
        for (&place, found) in self.unresolved.iter().zip(&self.found) {
            self.materials[place as usize] = *found;
        }

        // The sky's share: how far the field rises along the normal. Ground far from the solid sees the whole sky.
        let near = bounds_of(frame).grown(tap_height(frame.radius, OCCLUSION_TAPS - 1));
        let near_solid = |&i: &u32| solid(&i) || near.contains(surface(i).0);
        points.clear();
        for &i in self.lit.iter().filter(|i| near_solid(i)) {
            let (p, n) = surface(i);
            let reach = reach_at(frame, hits[i as usize].normal_t[3]);
            (0..OCCLUSION_TAPS).for_each(|tap| points.push(p + n * tap_height(reach, tap)));
        }
        air.measure(probe, points);
        let far = air.far(probe);
        let mut taps = points.d.chunks_exact(OCCLUSION_TAPS);
        self.sky.clear();
        for i in &self.lit {
            let own = if near_solid(i) { taps.next() } else { None };
            let (p, n) = surface(*i);
            let reach = reach_at(frame, hits[*i as usize].normal_t[3]);
            self.sky.push(own.map_or(1.0, |taps| {
                ambient_occlusion(frame, (p, n, reach), taps, far)
            }));
        }

        self.shadows(frame, probe, air, points, lifted);
    }

    /// Computes the sun's share, with rays that march together like primary ones.
    fn shadows(
        &mut self,
        frame: &FrameUniform,
        probe: &mut FieldProbe<'_>,
        air: Sky<'_>,
        points: &mut Points,
        origin: impl Fn(u32) -> (Vec3, Vec3, f32),
    ) {
        let sun = sun_direction(frame);
        let bounds = bounds_of(frame);
        let (epsilon, step_scale) = (frame.epsilon, frame.inv_lipschitz);
        let wave = &mut self.wave;
        self.sun.clear();
        self.sun.resize(self.lit.len(), 1.0);
        wave.clear();
        for (k, &i) in self.lit.iter().enumerate() {
            let (origin, n, min_step) = origin(i);
            match (Ray {
                origin,
                direction: sun,
            })
            .span(bounds)
            {
                Some((near, far)) if n.dot(sun) > 0.0 => {
                    wave.push(k as u32, origin, (near, far));
                    // A shadow ray stores its shortest step where a primary one stores its side.
                    if let Some(side) = wave.side.last_mut() {
                        *side = min_step;
                    }
                }
                // A side that faces away from the sun needs no ray, and a ray that misses the box meets nothing.
                _ => {}
            }
        }
        let (batch, far) = (probe.batch(), air.far(probe));
        let mut steps = 0;
        while wave.len() > 0 && steps < SHADOW_STEPS {
            steps += 1;
            let count = wave.len();
            for first in (0..count).step_by(batch) {
                let n = batch.min(count - first);
                points.clear();
                let Points { x, y, z, .. } = points;
                for (axis, p) in [x, y, z].into_iter().enumerate() {
                    // A shadow ray stores its origin where a primary one stores its direction.
                    let (t, origin) = (
                        &wave.t[first..first + n],
                        &wave.direction[axis][first..first + n],
                    );
                    let places = t.iter().zip(origin);
                    p.extend(places.map(|(t, origin)| origin + sun[axis] * t));
                }
                air.measure(probe, points);
                for (lane, &d) in points.d[..n].iter().enumerate() {
                    let i = first + lane;
                    if !wave.is_active(i) {
                        continue;
                    }
                    let t = wave.t[i];
                    let share = if d < far {
                        (SHADOW_SHARPNESS * d / t.max(epsilon)).clamp(0.0, 1.0)
                    } else {
                        1.0
                    };
                    let least = &mut self.sun[wave.pixel[i] as usize];
                    *least = least.min(share);
                    wave.t[i] = t + (d * step_scale).max(wave.side[i]);
                    if share <= 0.005 || wave.t[i] >= wave.end[i] {
                        wave.retire(i);
                    }
                }
            }
            // A ray that left the box is near nothing.
            if probe.is_near() {
                wave.close();
            } else {
                wave.compact();
            }
        }
    }
}

fn sun_direction(frame: &FrameUniform) -> Vec3 {
    let [x, y, z] = frame.sun;
    vec3(x, y, z)
}

/// Returns the height of an occlusion tap above the surface, for a reach around it.
fn tap_height(radius: f32, tap: usize) -> f32 {
    let step = (tap + 1) as f32 / OCCLUSION_TAPS as f32;
    radius * 0.16 * step * step
}

/// Returns how far around a hit occlusion is gathered: what is a detail depends on the distance that it is seen from,
/// and in a large world not on the world's size.
fn reach_at(frame: &FrameUniform, length: f32) -> f32 {
    frame.radius.min(length)
}

/// Returns how much of the sky a point sees, from the distances at its taps, clamped to `far`.
fn ambient_occlusion(
    frame: &FrameUniform,
    (p, n, reach): (Vec3, Vec3, f32),
    taps: &[f32],
    far: f32,
) -> f32 {
    let (mut closed, mut weight) = (0.0, 1.0);
    for (tap, &d) in taps.iter().enumerate() {
        let height = tap_height(reach, tap);
        let d = if d < far { d } else { f32::INFINITY };
        let above_ground = p.y + n.y * height - frame.ground_y;
        let d = if frame.has_ground != 0 {
            d.min(above_ground)
        } else {
            d
        };
        closed += weight * (height - d).max(0.0) / height;
        weight *= 0.75;
    }
    (1.0 - 0.42 * closed).clamp(0.0, 1.0)
}

/// Returns the sky's light from a direction.
fn sky(frame: &FrameUniform, direction: Vec3) -> Vec3 {
    let up = direction.y;
    let above = HORIZON.lerp(ZENITH, up.max(0.0).sqrt());
    let below = HORIZON.lerp(NADIR, (-up * 4.0).clamp(0.0, 1.0));
    let base = if up >= 0.0 { above } else { below };
    // With a ground, only haze is visible below the horizon.
    let hazy = if frame.has_ground != 0 && up < 0.0 {
        HORIZON
    } else {
        base
    };
    let glow = direction.dot(sun_direction(frame)).max(0.0);
    let glow2 = glow * glow;
    let glow8 = glow2 * glow2 * glow2 * glow2;
    hazy + vec3(0.25, 0.18, 0.08) * (glow8 * glow8)
}

/// Returns the light that a surface sends toward the viewer.
fn shade_surface(
    frame: &FrameUniform,
    ray: Ray,
    hit: &Hit,
    material: &GpuMaterial,
    sun_share: f32,
    sky_share: f32,
) -> Vec3 {
    let [r, g, b, roughness] = material.base_roughness;
    let [er, eg, eb, metallic] = material.emission_metallic;
    let base = vec3(r, g, b);
    let n = vec3(hit.normal_t[0], hit.normal_t[1], hit.normal_t[2]);
    let view = -ray.direction;
    let sun = sun_direction(frame);
    let facing = n.dot(view).max(1e-3);
    let body = base * (1.0 - metallic);
    let mirror = Vec3::splat(0.04).lerp(base, metallic);

    // The sun.
    let height = n.dot(sun);
    let half = (sun + view).normalize_or_zero();
    let alpha = (roughness * roughness).max(0.01);
    let alpha2 = alpha * alpha;
    let peak = n.dot(half).max(0.0);
    let spread = peak * peak * (alpha2 - 1.0) + 1.0;
    let lobe = alpha2 / (std::f32::consts::PI * spread * spread);
    let k = (roughness + 1.0) * (roughness + 1.0) * 0.125;
    let lit_height = height.max(0.0);
    let visibility = 0.25 / ((facing * (1.0 - k) + k) * (lit_height * (1.0 - k) + k));
    let fresnel = schlick(mirror, view.dot(half).max(0.0), 1.0);
    let share = sun_share * sun_share * (3.0 - 2.0 * sun_share);
    let direct = (body * std::f32::consts::FRAC_1_PI + fresnel * (lobe * visibility))
        * SUN_LIGHT
        * (lit_height * share * std::f32::consts::FRAC_PI_2);

    // The sky: its mean over the normal's half space for the body, and along the reflection for the mirror.
    let around = NADIR.lerp(ZENITH.lerp(HORIZON, 0.5), 0.5 + 0.5 * n.y);
    let reflected = ray.direction - n * (2.0 * ray.direction.dot(n));
    let gloss = 1.0 - roughness;
    let environment = around.lerp(sky(frame, reflected), gloss * gloss);
    let rim = schlick(mirror, facing, gloss);
    let ambient = (body * around * 0.9 + rim * environment) * sky_share;

    // Light reflected from below.
    let bounce = body * vec3(0.16, 0.14, 0.12) * ((0.5 - 0.5 * n.y) * sky_share);
    let color = direct + ambient + bounce + vec3(er, eg, eb);
    if hit.kind != abi::HIT_GROUND {
        return color;
    }
    // The ground fades into the horizon.
    let far = hit.normal_t[3] / frame.far;
    color.lerp(sky(frame, ray.direction), (far * 2.2).clamp(0.0, 1.0))
}

/// Returns Schlick's Fresnel term. The rim of a rough surface is darker.
fn schlick(mirror: Vec3, cosine: f32, gloss: f32) -> Vec3 {
    let m = (1.0 - cosine).clamp(0.0, 1.0);
    let m2 = m * m;
    let rim = mirror.max(Vec3::splat(gloss));
    mirror + (rim - mirror) * (m2 * m2 * m)
}

fn tone_map(c: Vec3) -> Vec3 {
    let x = c * 0.5;
    let y = x * (x * 2.51 + 0.03) / (x * (x * 2.43 + 0.59) + 0.14);
    y.clamp(Vec3::ZERO, Vec3::ONE)
}
