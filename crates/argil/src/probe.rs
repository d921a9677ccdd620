//! The field at one point after the other, by what can matter there.
//!
//! *Practice.* Lists of instructions come from a tree over the program, which tells all distances; or from what follows edits, while
//! few questions are asked between two of them; or, of programs too long for a tree, from an index over their operands. Those two
//! tell distances as far as their parts are long; what is farther is at least that far.

use crate::World;
use argil_abi::{GpuMaterial, Instruction};
use argil_field::{Evaluator, IncrementalProgram, OperandIndex, PartGrid, Program, ProgramTree};
use argil_math::Aabb;
use argil_scene::Material;
use glam::{IVec3, Vec3};

/// Points of a ray that are measured at once: as many as the evaluator takes for one.
pub(crate) const AHEAD: usize = 16;

/// Where lists of what is near come from.
#[derive(Clone, Copy)]
enum Lists<'a> {
    Tree(&'a ProgramTree),
    Live(&'a IncrementalProgram),
    Index(&'a OperandIndex),
    /// All of the program.
    Whole,
}

impl Lists<'_> {
    /// The part that a point is in, where lists are of parts.
    fn part_of(&self, p: Vec3) -> Option<(&PartGrid, IVec3)> {
        let parts = match self {
            Self::Live(live) => live.parts(),
            Self::Index(index) => index.parts(),
            Self::Tree(_) | Self::Whole => return None,
        };
        Some((parts, parts.part_of(p)))
    }
}

/// Evaluates the field at one point after the other.
pub(crate) struct Probe<'a> {
    world: &'a World,
    lists: Lists<'a>,
    evaluator: Option<Evaluator<'a>>,
    /// The part that `list` is of.
    part: Option<IVec3>,
    list: Vec<Instruction>,
    /// The last list of a tree, and where it holds.
    last: Option<(&'a [Instruction], Aabb)>,
    /// Instructions that were run, and how often.
    pub counts: [u64; 2],
}

impl<'a> Probe<'a> {
    /// For distances that matter up to `reach`. What is farther is told to be at least as far as what is told.
    pub(crate) fn new(world: &'a World, reach: f32) -> Self {
        let fits = |far: f32| reach <= 0.8 * far;
        let lists = match world.live_program() {
            Some(live) if fits(live.parts().far) && world.has_few_queries() => Lists::Live(live),
            _ => match world.list_tree() {
                Some(tree) => Lists::Tree(tree),
                // An index is made only where there is no tree.
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

    /// The distance beyond which nothing is told.
    fn far(&self) -> f32 {
        match self.lists {
            Lists::Live(live) => live.parts().far,
            Lists::Index(index) => index.parts().far,
            Lists::Tree(_) | Lists::Whole => f32::MAX,
        }
    }

    /// Have the list for a point at hand; an evaluator to run it, and where it holds.
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
                    Lists::Index(index) => index.list(program, part, &mut self.list),
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
                        tree.list(program, p).unwrap_or(beyond)
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

    /// The distance at a point, as far as it is told.
    pub(crate) fn distance(&mut self, p: Vec3) -> f32 {
        let far = self.far();
        let (evaluator, list, _) = self.prepare(p);
        let mut d = [0.0];
        evaluator.distances_with(list, &[p.x], &[p.y], &[p.z], &mut d);
        d[0].clamp(-far, far)
    }

    /// The same at points along a ray, into `out`: of the first, and of those that follow as far as one list is theirs; how many
    /// that are. They cost what one does.
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
            for (axis, own) in points.iter_mut().zip(p.to_array()) {
                axis[count] = own;
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

    /// The distance and its gradient at a point near the surface.
    pub(crate) fn gradient(&mut self, p: Vec3) -> (f32, Vec3) {
        let (evaluator, list, _) = self.prepare(p);
        let (mut d, mut g) = ([0.0], [[0.0]; 3]);
        let [x, y, z] = &mut g;
        let point: [&[f32]; 3] = [&[p.x], &[p.y], &[p.z]];
        evaluator.gradients_with(list, point, &mut d, [x, y, z]);
        (d[0], Vec3::new(g[0][0], g[1][0], g[2][0]))
    }

    /// What a point near the surface is made of.
    pub(crate) fn material(&mut self, p: Vec3) -> GpuMaterial {
        let (evaluator, list, _) = self.prepare(p);
        let (mut d, mut material) = ([0.0], [GpuMaterial::default()]);
        let point: [&[f32]; 3] = [&[p.x], &[p.y], &[p.z]];
        evaluator.materials_with(list, point, &mut d, &mut material);
        material[0]
    }
}

/// A material as the interpreter has it.
pub(crate) fn material_of(words: &GpuMaterial) -> Material {
    let [r, g, b, roughness] = words.base_roughness;
    let [er, eg, eb, metallic] = words.emission_metallic;
    Material {
        base_color: [r, g, b],
        roughness,
        metallic,
        emission: [er, eg, eb],
    }
}
