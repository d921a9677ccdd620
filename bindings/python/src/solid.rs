//! A solid that is ready to be asked: its scene, its field, and its box.

use crate::errors::ToPython;
use argil::glam::Vec3;
use argil::math::{Aabb, Control};
use argil::scene::Scene;
use argil::{BuildError, Engine, World};
use pyo3::PyErr;
use std::collections::BinaryHeap;
use std::sync::OnceLock;

/// Half of the box in which infinite solids are searched for an end.
const SEARCHED: f32 = 9e5;
/// Boxes that each side of a solid's box may take.
const MAX_LOOKS: usize = 8_000;
/// Programs of more brushes keep the box that their nodes tell, because each look would evaluate all of them.
const MANY_BRUSHES: usize = 2_000;
/// Voxels along a side of a box that need not be tight, because empty space costs little.
const MANY_VOXELS: f32 = 2_000.0;
/// The precision of a solid's box, as a share of its longest side.
const PRECISION: f32 = 1.0 / 2048.0;

/// A scene with its field.
#[derive(Debug)]
pub struct Solid {
    pub scene: Scene,
    pub world: World,
    aabb: OnceLock<Aabb>,
}

impl Solid {
    /// Builds the field of a scene.
    ///
    /// # Errors
    /// If the scene cannot be lowered.
    pub fn new(scene: Scene) -> Result<Self, BuildError> {
        let world = Engine::cpu().build(&scene)?.field();
        Ok(Self {
            scene,
            world,
            aabb: OnceLock::new(),
        })
    }

    /// Returns a box around the solid. Sides without an end are infinite.
    pub fn aabb(&self) -> Aabb {
        *self.aabb.get_or_init(|| surface_box(&self.world))
    }

    /// Builds the field again for long work, in a box of its own.
    ///
    /// # Errors
    /// If the scene cannot be lowered.
    pub fn world_within(
        &self,
        bounds: Option<Aabb>,
        control: &Control,
    ) -> Result<World, BuildError> {
        let mut scene = self.scene.snapshot();
        let needed = scene
            .view
            .bounds
            .is_none()
            .then(|| padded(self.aabb()))
            .filter(|bounds_of_solid| bounds_of_solid.is_finite());
        if let Some(bounds) = bounds.or(needed) {
            scene.view.bounds = Some([bounds.min.to_array(), bounds.max.to_array()]);
        }
        let engine = Engine::cpu().with_control(control);
        Ok(engine.build(&scene)?.field())
    }

    /// Returns the box to mesh within, if the box that the nodes tell is not good enough: a given one, or that of the
    /// surface.
    ///
    /// # Errors
    /// ValueError for a solid that is empty or has no end.
    pub fn mesh_limits(&self, given: Option<Aabb>, voxel_size: f32) -> Result<Option<Aabb>, PyErr> {
        let told = self.world.program().aabb();
        let is_small = told.is_finite() && told.size().max_element() < MANY_VOXELS * voxel_size;
        if given.is_some() || is_small {
            return Ok(given);
        }
        let bounds = self.finite_box(None)?;
        Ok(Some(bounds.grown(2.5 * voxel_size)))
    }

    /// Returns the box to sample: a given one, or that of the surface.
    ///
    /// # Errors
    /// ValueError for a solid that is empty or has no end.
    pub fn finite_box(&self, given: Option<Aabb>) -> Result<Aabb, PyErr> {
        if let Some(given) = given {
            return Ok(given);
        }
        let bounds = self.aabb();
        if bounds.is_empty() {
            return Err("the solid is empty: nothing is inside"
                .to_owned()
                .to_python());
        }
        if bounds.is_finite() {
            return Ok(bounds);
        }
        let endless = |axis: usize| !(bounds.min[axis].is_finite() && bounds.max[axis].is_finite());
        // The axes of Python.
        let names = [(0, "x"), (2, "y"), (1, "z")];
        let open: Vec<&str> = names
            .iter()
            .filter(|(axis, _)| endless(*axis))
            .map(|(_, name)| *name)
            .collect();
        Err(format!(
            "the solid has no end along {}: intersect it with a slab or a box, or pass bounds=((x0, y0, z0), (x1, y1, z1))",
            open.join(" and ")
        )
        .to_python())
    }
}

/// Returns a box with room for a coarse voxel around it.
fn padded(aabb: Aabb) -> Aabb {
    aabb.grown(aabb.size().max_element().max(1e-6) * PRECISION)
}

/// Returns a box around the surface.
fn surface_box(world: &World) -> Aabb {
    let program = world.program();
    let told = program.aabb();
    if told.is_empty() || program.brush_count() > MANY_BRUSHES {
        return told;
    }
    let mut found = told;
    if !told.is_finite() {
        found = shrunk(
            world,
            told.intersection(Aabb::centered(Vec3::splat(SEARCHED))),
        );
        if found.is_empty() {
            return found;
        }
    }
    let size = found.size().max_element();
    let mut tight = found;
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            let Some(end) = farthest(world, found, axis, side, PRECISION * size) else {
                return Aabb::EMPTY;
            };
            if side > 0.0 {
                tight.max[axis] = tight.max[axis].min(end);
            } else {
                tight.min[axis] = tight.min[axis].max(end);
            }
        }
    }
    let ends = |axis: usize, side: f32| {
        let (told, found) = if side > 0.0 {
            (told.max[axis], found.max[axis])
        } else {
            (-told.min[axis], -found.min[axis])
        };
        if told < f32::INFINITY {
            return true;
        }
        // Where there is no surface on the way, all is inside, as it is in a half space, or nothing.
        let mut far = found_center(tight);
        far[axis] = 0.95 * side * SEARCHED;
        found < 0.99 * SEARCHED && world.distance(far.to_array()) >= 0.0
    };
    let mut whole = tight;
    for axis in 0..3 {
        if !ends(axis, 1.0) {
            whole.max[axis] = f32::INFINITY;
        }
        if !ends(axis, -1.0) {
            whole.min[axis] = f32::NEG_INFINITY;
        }
    }
    whole
}

/// Returns the middle of a box, or nearly that, so that it lies on no plane of symmetry.
fn found_center(aabb: Aabb) -> Vec3 {
    aabb.min + (aabb.max - aabb.min) * Vec3::new(0.499, 0.497, 0.503)
}

fn may_hold_surface(world: &World, part: Aabb) -> bool {
    let values = world.bounds(part.min.to_array(), part.max.to_array());
    values.min <= 0.0 && values.max >= 0.0
}

/// Shrinks a box around the surface, by halving it into sixteen parts along its longest sides again and again.
fn shrunk(world: &World, mut all: Aabb) -> Aabb {
    for _ in 0..40 {
        let part = (all.size().max_element() / 16.0).max(1e-9);
        let counts = (all.size() / part - 1e-3).ceil().max(Vec3::ONE).as_uvec3();
        let step = all.size() / counts.as_vec3();
        let mut hull = Aabb::EMPTY;
        for z in 0..counts.z {
            for y in 0..counts.y {
                for x in 0..counts.x {
                    let low = all.min + step * Vec3::new(x as f32, y as f32, z as f32);
                    let cell = Aabb::new(low, low + step);
                    if may_hold_surface(world, cell) {
                        hull = hull.union(cell);
                    }
                }
            }
        }
        let is_done = hull.is_empty() || hull.size().max_element() > 0.8 * all.size().max_element();
        all = hull;
        if is_done {
            break;
        }
    }
    all
}

/// A part of a box that may hold the surface, which comes first if it reaches farther.
struct OpenPart(f32, f32, Aabb);

impl PartialEq for OpenPart {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for OpenPart {}
impl PartialOrd for OpenPart {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for OpenPart {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        // Of two that reach as far, the smaller one.
        self.0.total_cmp(&other.0).then(other.1.total_cmp(&self.1))
    }
}

/// Returns how far the surface reaches along an axis, to a precision, or no less than that after too many looks.
fn farthest(world: &World, all: Aabb, axis: usize, side: f32, precision: f32) -> Option<f32> {
    let reach = |part: Aabb| {
        if side > 0.0 {
            part.max[axis]
        } else {
            -part.min[axis]
        }
    };
    let mut open = BinaryHeap::from([OpenPart(reach(all), all.half_diagonal(), all)]);
    let mut looks = 0;
    while let Some(OpenPart(end, _, part)) = open.pop() {
        if looks >= MAX_LOOKS {
            return Some(side * end);
        }
        looks += 1;
        if !may_hold_surface(world, part) {
            continue;
        }
        if part.size().max_element() <= precision {
            return Some(side * end);
        }
        // Halve the longest side, or the axis itself if it is nearly as long.
        let size = part.size();
        let longest = (0..3).fold(axis, |a, b| if size[b] > 1.01 * size[a] { b } else { a });
        let middle = 0.5 * (part.min[longest] + part.max[longest]);
        let (mut low, mut high) = (part, part);
        low.max[longest] = middle;
        high.min[longest] = middle;
        for half in [low, high] {
            open.push(OpenPart(reach(half), half.half_diagonal(), half));
        }
    }
    None
}
