//! Evaluates the field point by point, through pruned programs.
//!
//! *Practice.* Pruned programs come from a tree over the program, which gives all distances. While few queries are
//! asked between two edits, they come from the incremental program. Programs too long for a tree use an index over
//! their operands. The last two give distances up to the length of a part, and a lower bound beyond.

use crate::World;
use argil_abi::{GpuMaterial, Instruction};
use argil_field::{Evaluator, IncrementalProgram, OperandIndex, PartGrid, Program, ProgramTree};
use argil_math::Aabb;
use argil_scene::Material;
use glam::{IVec3, Vec3};

/// Points of a ray that are evaluated at once: as many as the evaluator needs for the cost of one.
pub(crate) const AHEAD: usize = 16;

/// The source of pruned programs.
#[derive(Clone, Copy)]
enum Lists<'a> {
    Tree(&'a ProgramTree),
    Live(&'a IncrementalProgram),
    Index(&'a OperandIndex),
    /// The whole program.
    Whole,
}

impl Lists<'_> {
    /// Returns the part that contains a point, if programs belong to parts.
    fn part_of(&self, p: Vec3) -> Option<(&PartGrid, IVec3)> {
        let parts = match self {
            Self::Live(live) => live.parts(),
            Self::Index(index) => index.parts(),
            Self::Tree(_) | Self::Whole => return None,
        };
        Some((parts, parts.part_of(p)))
    }
}

/// Evaluates the field at one point after another.
pub(crate) struct Probe<'a> {
    world: &'a World,
    lists: Lists<'a>,
    evaluator: Option<Evaluator<'a>>,
    /// The part that `list` belongs to.
    part: Option<IVec3>,
    list: Vec<Instruction>,
    /// The last program of a tree, and the box where it holds.
    last: Option<(&'a [Instruction], Aabb)>,
    /// Instructions that ran, and the number of evaluations.
    pub counts: [u64; 2],
}

impl<'a> Probe<'a> {
    /// Creates a probe for distances that matter up to `reach`. Larger distances are lower bounds.
    pub(crate) fn new(world: &'a World, reach: f32) -> Self {
        let fits = |far: f32| reach <= 0.8 * far;
        let lists = match world.live_program() {
            Some(live) if fits(live.parts().far) && world.has_few_queries() => Lists::Live(live),
            _ => match world.list_tree() {
                Some(tree) => Lists::Tree(tree),
                // An index is built only where there is no tree.
                None => match world.operand_index() {
                    Some(index) if fits(index.parts().far) => Lists::Index(index),
                    _ => Lists::Whole,
                },
            },
        };
        Self {
            world,
            lists,
            evaluator: None,
            part: None,
            list: Vec::new(),
            last: None,
            counts: [0; 2],
        }
    }

    fn program(&self) -> &'a Program {
        match self.lists {
            Lists::Live(live) => live.program(),
            Lists::Tree(_) | Lists::Index(_) | Lists::Whole => self.world.program(),
        }
    }

    /// Returns the distance beyond which results are lower bounds.
    fn far(&self) -> f32 {
        match self.lists {
            Lists::Live(live) => live.parts().far,
            Lists::Index(index) => index.parts().far,
            Lists::Tree(_) | Lists::Whole => f32::MAX,
        }
    }

    /// Prepares the program for a point. Returns an evaluator, the program, and the box where it holds.
    fn prepare(&mut self, p: Vec3) -> (&mut Evaluator<'a>, &[Instruction], Aabb) {
        let program = self.program();
        let mut held = Aabb::ALL;
        if let Some((parts, part)) = self.lists.part_of(p) {
            let corner = parts.corner + parts.edge * part.as_vec3();
            held = Aabb::new(corner, corner + parts.edge);
            if self.part != Some(part) {
                self.part = Some(part);
                self.list.clear();
                match self.lists {
                    Lists::Live(live) => live.part_program(part, &mut self.list),
                    Lists::Index(index) => index.part_program(program, part, &mut self.list),
                    Lists::Tree(_) | Lists::Whole => {}
                }
            }
        }
        let list = match self.lists {
            Lists::Tree(tree) => {
                let (list, cell) = match self.last {
                    Some(last) if last.1.contains(p) => last,
                    _ => {
                        let beyond = (program.instructions(), Aabb::new(p, p));
                        tree.program_at(program, p).unwrap_or(beyond)
                    }
                };
                self.last = Some((list, cell));
                held = cell;
                list
            }
            Lists::Live(_) | Lists::Index(_) => &self.list,
            Lists::Whole => program.instructions(),
        };
        self.counts[0] += list.len() as u64;
        self.counts[1] += 1;
        let evaluator = self
            .evaluator
            .get_or_insert_with(|| Evaluator::new(program));
        (evaluator, list, held)
    }

    /// Returns the distance at a point, exact up to [`Probe::far`].
    pub(crate) fn distance(&mut self, p: Vec3) -> f32 {
        let far = self.far();
        let (evaluator, list, _) = self.prepare(p);
        let mut d = [0.0];
        evaluator.distances_with(list, &[p.x], &[p.y], &[p.z], &mut d);
        d[0].clamp(-far, far)
    }

    /// Evaluates points along a ray into `out`, as far as the first point's program holds. Returns their number.
    /// They cost as much as one point.
    pub(crate) fn distances_along(
        &mut self,
        (origin, direction): (Vec3, Vec3),
        t: &[f32],
        out: &mut [f32; AHEAD],
    ) -> usize {
        let Some(&first) = t.first() else { return 0 };
        let far = self.far();
        let mut points = [[0.0; AHEAD]; 3];
        let (evaluator, list, held) = self.prepare(origin + first * direction);
        let mut count = 0;
        for &t in t.iter().take(AHEAD) {
            let p = origin + t * direction;
            if count > 0 && !held.contains(p) {
                break;
            }
            for (axis, coordinate) in points.iter_mut().zip(p.to_array()) {
                axis[count] = coordinate;
            }
            count += 1;
        }
        let [x, y, z] = points.each_ref().map(|axis| &axis[..count]);
        evaluator.distances_with(list, x, y, z, &mut out[..count]);
        for d in &mut out[..count] {
            *d = d.clamp(-far, far);
        }
        count
    }

    /// Returns the distance and its gradient at a point near the surface.
    pub(crate) fn gradient(&mut self, p: Vec3) -> (f32, Vec3) {
        let (evaluator, list, _) = self.prepare(p);
        let (mut d, mut g) = ([0.0], [[0.0]; 3]);
        let [x, y, z] = &mut g;
        let point: [&[f32]; 3] = [&[p.x], &[p.y], &[p.z]];
        evaluator.gradients_with(list, point, &mut d, [x, y, z]);
        (d[0], Vec3::new(g[0][0], g[1][0], g[2][0]))
    }

    /// Returns the material at a point near the surface.
    pub(crate) fn material(&mut self, p: Vec3) -> GpuMaterial {
        let (evaluator, list, _) = self.prepare(p);
        let (mut d, mut material) = ([0.0], [GpuMaterial::default()]);
        let point: [&[f32]; 3] = [&[p.x], &[p.y], &[p.z]];
        evaluator.materials_with(list, point, &mut d, &mut material);
        material[0]
    }
}

impl Probe<'_> {
    /// Returns all properties of materials at points near the surface: see [`Evaluator::appearances_with`]. They are evaluated
    /// with the program of the first one.
    pub(crate) fn appearances<const N: usize>(&mut self, points: [Vec3; N]) -> [[f32; 12]; N] {
        let [x, y, z] = [0, 1, 2].map(|axis| points.map(|point| point[axis]));
        let (evaluator, list, _) = self.prepare(points[0]);
        let (mut d, mut found) = ([0.0; N], [[0.0; 12]; N]);
        evaluator.appearances_with(list, [&x, &y, &z], &mut d, &mut found);
        found
    }
}

/// Converts a material from the interpreter's form.
pub(crate) fn material_of(words: &GpuMaterial) -> Material {
    let [r, g, b, roughness] = words.base_roughness;
    let [er, eg, eb, metallic] = words.emission_metallic;
    Material {
        base_color: [r, g, b],
        roughness,
        metallic,
        emission: [er, eg, eb],
        ..Material::default()
    }
}
