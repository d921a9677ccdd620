//! Rays through an octree of bricks. `octree.wgsl` is the twin.
//!
//! *Theory.* The ray walks through the grid of bricks cell by cell (Amanatides and Woo 1987, in Quilez's branchless
//! form). At each cell it asks the tree for a brick, and marches inside bricks by the stored distances.
//!
//! *Practice.* The study's look-up starts at the root for every cell (kd-restart in GigaVoxels, Crassin 2009). The
//! other one starts at the deepest node that the cell shares with the previous one.

use crate::octree_trace::{SurfaceStep, TraceVolume, trace_volume};
use crate::probe::FieldProbe;
use crate::source::{RayTracer, RenderSource};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{self as abi, FrameUniform, HIT_NONE, HIT_OUTSIDE, Hit};
use argil_math::{Ray, morton};
use argil_volume::{DescentPath, Octree, SampleFormat, Sampler, Texel};
use glam::{IVec3, Vec3};

impl RenderSource for Octree {
    fn tracer<'a>(&'a self, _: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        match self.layout().encoding.format {
            SampleFormat::Snorm8 => Some(Box::new(OctreeRays::<i8>::new(self)?)),
            SampleFormat::Snorm16 => Some(Box::new(OctreeRays::<i16>::new(self)?)),
        }
    }
}

struct OctreeRays<'a, T> {
    octree: &'a Octree,
    sampler: Sampler<'a, T>,
}

impl<'a, T: Texel> OctreeRays<'a, T> {
    /// Returns `None` if the samples have another type.
    fn new(octree: &'a Octree) -> Option<Self> {
        let layout = octree.layout();
        let texels = octree.texels().of()?;
        let sampler = Sampler::new(texels, &layout.voxel_grid, &layout.encoding, 0)?;
        Some(Self { octree, sampler })
    }
}

impl<T: Texel> RayTracer for OctreeRays<'_, T> {
    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        _: &mut FieldProbe<'_>,
        _: &mut TileScratch,
        out: &mut [Hit],
    ) {
        trace_volume(frame, tile, self, out);
    }
}

impl<T: Texel> TraceVolume for OctreeRays<'_, T> {
    fn march(&self, frame: &FrameUniform, ray: Ray, near: f32, far: f32) -> Hit {
        let layout = self.octree.layout();
        let edge = layout.brick_length();
        let grid = layout.size_bricks.as_ivec3();

        // Start the walk: the first cell, and where the ray meets the next plane of each axis.
        let tiny = |d: f32| if d.abs() < 1e-20 { 1e-20 } else { d };
        let d = ray.direction;
        let inverse = Vec3::new(1.0 / tiny(d.x), 1.0 / tiny(d.y), 1.0 / tiny(d.z));
        let start = (ray.at(near) - layout.voxel_grid.corner) / edge;
        let mut cell = start.floor().as_ivec3().clamp(IVec3::ZERO, grid - 1);
        let step = IVec3::new(sign(inverse.x), sign(inverse.y), sign(inverse.z));
        let ahead = step.max(IVec3::ZERO).as_vec3();
        let corner = layout.voxel_grid.corner - ray.origin;
        let plane = |cell: IVec3| (corner + (cell.as_vec3() + ahead) * edge) * inverse;

        let mut path = match frame.descent {
            abi::DESCENT_PATH => DescentPath::recording(),
            _ => DescentPath::default(),
        };
        let mut walk = SurfaceStep::from(near);
        // The axis of the plane through which the ray entered the cell.
        let mut entered = 3;
        let mut hit = Hit::default();
        let shows_boxes = matches!(frame.mode, abi::MODE_BRICKS | abi::MODE_NODES);
        if near > 0.0 && !shows_boxes {
            // A solid that the box clips is hit at the clip, with or without a brick.
            hit.steps = 1;
            let d = self.sampler.distance(ray.at(near));
            if d < 0.0 && walk.step(frame, d, false).1 {
                hit.kind = walk.kind();
                hit.normal_t[3] = near;
                return hit;
            }
        }
        while hit.steps < frame.max_steps {
            let visit = self.octree.tree().find_from(cell.as_uvec3(), &mut path);
            hit.cells += 1;
            hit.descents += visit.nodes;
            hit.steps += 1 + visit.nodes;
            let planes = plane(cell);
            let leave = planes.min_element();
            let end = leave.min(far);
            if visit.brick.is_some() {
                if shows_boxes {
                    let code = morton(cell.as_uvec3());
                    let is_node = frame.mode == abi::MODE_NODES;
                    hit.id = 1 + if is_node { code >> 3 } else { code };
                    hit.kind = HIT_OUTSIDE;
                    hit.normal_t = side_normal(entered, step, -d, walk.t);
                    return hit;
                }
                // March inside the brick.
                while walk.t <= end && hit.steps < frame.max_steps {
                    hit.steps += 1;
                    let d = self.sampler.distance(ray.at(walk.t));
                    let is_last = hit.steps == frame.max_steps;
                    let (_, reached) = walk.step(frame, d, is_last);
                    if reached {
                        hit.kind = walk.kind();
                        hit.normal_t[3] = walk.t;
                        return hit;
                    }
                }
            }
            // Continue to the next cell.
            walk.t = leave;
            entered = if planes.x <= planes.y && planes.x <= planes.z {
                0
            } else if planes.y <= planes.z {
                1
            } else {
                2
            };
            cell[entered] += step[entered];
            if leave > far || cell[entered] < 0 || cell[entered] >= grid[entered] {
                break;
            }
        }
        hit.kind = HIT_NONE;
        hit
    }

    #[inline]
    fn distance(&self, point: Vec3) -> f32 {
        self.sampler.distance(point)
    }
}

fn sign(v: f32) -> i32 {
    if v < 0.0 { -1 } else { 1 }
}

/// Returns the normal of the side through which a cell was entered, with the ray's length. If the ray began in the
/// cell, it is toward the viewer.
fn side_normal(entered: usize, step: IVec3, toward: Vec3, t: f32) -> [f32; 4] {
    let mut normal = [toward.x, toward.y, toward.z, t];
    if entered < 3 {
        normal = [0.0, 0.0, 0.0, t];
        normal[entered] = -step[entered] as f32;
    }
    normal
}
