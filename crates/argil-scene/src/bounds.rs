//! Bounds of brushes and groups, from the leaves up.

use crate::extent::{Extent, radius_of};
use crate::modified_region::{region_after, stretch};
use crate::modifier::{FEW_COPIES, half_angle_about_y, neighbor_copies};
use crate::symmetry::Symmetry;
use crate::{Exactness, Modifier, NodeId, NodeKind, OperatorKind, Scene, Shape};
use glam::Vec3;
use rustc_hash::FxHashMap;

impl Extent {
    fn of_shape(shape: &Shape) -> Self {
        let aabb = shape.aabb();
        let max_underestimate = match shape.exactness() {
            Exactness::LowerBound => 2.0 * aabb.half_diagonal(),
            Exactness::Exact => 0.0,
        };
        Self {
            max_underestimate,
            symmetry: Symmetry::of_shape(shape),
            ..Self::within(aabb)
        }
    }

    /// Returns the extent after a list of modifiers.
    pub fn under(self, modifiers: &[Modifier]) -> Self {
        modifiers.iter().fold(self, |all, m| all.modified(m))
    }

    /// Returns the extent of a surface that moved outward by at most `by`.
    fn offset(self, by: f32) -> Self {
        Self {
            aabb: self.aabb.grown(self.lipschitz_inverse * by),
            radius: self.radius + self.lipschitz_inverse * by,
            ..self
        }
    }

    /// Returns the extent of a surface that moved inward. A corner of it is farther from what is outside than the
    /// distance tells.
    fn inset(self) -> Self {
        Self {
            max_underestimate: f32::INFINITY,
            ..self
        }
    }

    /// Returns the extent of the section at z = 0. Its distances are those of the whole solid, which ends nearer unless it
    /// is the same at every z.
    fn section(self) -> Self {
        let is_prism = self.aabb.min.z == f32::NEG_INFINITY && self.aabb.max.z == f32::INFINITY;
        let level = self.aabb.size().truncate().length();
        Self {
            max_underestimate: self.max_underestimate + if is_prism { 0.0 } else { level },
            ..self
        }
    }

    /// Returns the extent after one modifier.
    pub(crate) fn modified(self, modifier: &Modifier) -> Self {
        if self.aabb.is_empty() {
            return self;
        }
        let changed = self.changed(modifier);
        let of_box = radius_of(changed.aabb);
        let turns_about_y = match *modifier {
            Modifier::Translate { by: [x, _, z] } => x == 0.0 && z == 0.0,
            Modifier::Rotate {
                axis: [x, _, z], ..
            } => x == 0.0 && z == 0.0,
            Modifier::RadialRepeat { .. }
            | Modifier::Twist { .. }
            | Modifier::Mirror { .. }
            | Modifier::Round { .. }
            | Modifier::Shell { .. }
            | Modifier::Displace { .. }
            | Modifier::ScaleDistance { .. } => true,
            _ => false,
        };
        Self {
            radius: if turns_about_y {
                changed.radius.min(of_box)
            } else {
                of_box
            },
            symmetry: self.symmetry.under(modifier),
            ..changed
        }
    }

    fn changed(self, modifier: &Modifier) -> Self {
        match *modifier {
            Modifier::Round { radius } if radius < 0.0 => self.inset(),
            Modifier::Round { radius } => self.offset(radius),
            Modifier::Shift { .. } => Self {
                aabb: region_after(modifier, self.aabb, &self),
                lipschitz_inverse: self.lipschitz_inverse * stretch(modifier, &self),
                max_underestimate: f32::INFINITY,
                ..self
            },
            Modifier::Extrude { .. } | Modifier::Revolve { .. } => {
                let section = self.section();
                Self {
                    aabb: region_after(modifier, section.aabb, &section),
                    ..section
                }
            }
            Modifier::Shell { half_thickness } => self.offset(half_thickness),
            Modifier::Displace { amplitude, .. } => {
                let moved = self.offset(2.0 * amplitude);
                Self {
                    lipschitz_inverse: self.lipschitz_inverse * stretch(modifier, &self),
                    max_underestimate: f32::INFINITY,
                    ..moved
                }
            }
            // Their distances are at least those to a box or a cylinder around the solid.
            Modifier::Twist { .. } | Modifier::Bend { .. } | Modifier::Wrap { .. } => Self {
                aabb: region_after(modifier, self.aabb, &self),
                lipschitz_inverse: 1.0,
                max_underestimate: f32::INFINITY,
                ..self
            },
            Modifier::Scale { by } => Self {
                aabb: region_after(modifier, self.aabb, &self),
                max_underestimate: self.max_underestimate * by,
                ..self
            },
            Modifier::ScaleDistance { by } => Self {
                lipschitz_inverse: self.lipschitz_inverse / by,
                max_underestimate: if by < 1.0 {
                    f32::INFINITY
                } else {
                    self.max_underestimate
                },
                ..self
            },
            Modifier::Instances { ref poses } => Self {
                aabb: region_after(modifier, self.aabb, &self),
                max_underestimate: self.max_underestimate * poses.scales()[1],
                ..self
            },
            Modifier::Stretch { by } => {
                // The box grows by the largest factor, and the distance only by the smallest.
                let (least, most) = (modifier.scale(), Vec3::from(by).max_element());
                Self {
                    aabb: region_after(modifier, self.aabb, &self),
                    lipschitz_inverse: self.lipschitz_inverse * (most / least),
                    max_underestimate: if most > least {
                        f32::INFINITY
                    } else {
                        self.max_underestimate * least
                    },
                    ..self
                }
            }
            Modifier::Elongate { by } => {
                let shortfall = self.max_underestimate + 2.0 * Vec3::from(by).length();
                Self {
                    aabb: region_after(modifier, self.aabb, &self),
                    max_underestimate: shortfall,
                    ..self
                }
            }
            _ => Self {
                aabb: region_after(modifier, self.aabb, &self),
                ..self
            },
        }
    }
}

/// The extents of a scene's nodes, computed when first asked for.
///
/// The root's extent measures all nodes, in linear time. A brush's extent measures only that brush, so that an edit
/// among 100,000 brushes stays cheap. Nothing recurses.
#[derive(Clone, Debug)]
pub struct Extents<'a> {
    scene: &'a Scene,
    /// Extents before a node's modifiers, and after them in the frame of the surrounding group.
    known: Known,
}

/// Known extents: a map for a few nodes, or a table for all.
#[derive(Clone, Debug)]
enum Known {
    Few(FxHashMap<NodeId, [Extent; 2]>),
    All(Vec<Option<[Extent; 2]>>),
}

impl Known {
    #[inline]
    fn get(&self, id: NodeId) -> Option<[Extent; 2]> {
        match self {
            Self::Few(known) => known.get(&id).copied(),
            Self::All(known) => known[id.index()],
        }
    }

    #[inline]
    fn insert(&mut self, id: NodeId, extents: [Extent; 2]) {
        match self {
            Self::Few(known) => {
                known.insert(id, extents);
            }
            Self::All(known) => known[id.index()] = Some(extents),
        }
    }

    /// Prepares for a number of queries, given the scene's number of nodes.
    fn expect(&mut self, more: usize, nodes: usize) {
        if let Self::Few(known) = self
            && 4 * (known.len() + more) > nodes
        {
            let mut all = vec![None; nodes];
            for (id, extents) in known.drain() {
                all[id.index()] = Some(extents);
            }
            *self = Self::All(all);
        }
    }
}

impl<'a> Extents<'a> {
    /// Creates the extents of a scene. Nothing is measured yet.
    pub fn of(scene: &'a Scene) -> Self {
        Self {
            scene,
            known: Known::Few(FxHashMap::default()),
        }
    }

    /// Returns the scene that is measured.
    pub(crate) fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Returns the extent before a node's modifiers, in its own frame.
    pub fn content_bounds(&mut self, id: NodeId) -> Extent {
        self.measure(id)[0]
    }

    /// Returns the extent after a node's modifiers, in the frame of the group around it.
    pub fn node_bounds(&mut self, id: NodeId) -> Extent {
        self.measure(id)[1]
    }

    /// Whether a node takes part in the solid of the group around it: it is visible, and has content. A node without
    /// content changes nothing, whatever its operator.
    pub fn takes_part(&mut self, id: NodeId) -> bool {
        self.scene.node(id).at_current_time().visible && !self.node_bounds(id).aabb.is_empty()
    }

    /// Returns the extents of a node before its first modifier, before its second, and so on, and after its last.
    pub fn modifier_stages(&mut self, id: NodeId) -> Vec<Extent> {
        let mut stages = vec![self.content_bounds(id)];
        for modifier in &self.scene.node(id).at_current_time().modifiers {
            stages.push(stages[stages.len() - 1].modified(modifier));
        }
        stages
    }

    fn measure(&mut self, id: NodeId) -> [Extent; 2] {
        if let Some(known) = self.known.get(id) {
            return known;
        }
        let parents_first: Vec<NodeId> = self.scene.descendants(id).collect();
        let nodes = self.scene.nodes.len();
        self.known.expect(parents_first.len(), nodes);
        let mut extents = [Extent::EMPTY; 2];
        for &id in parents_first.iter().rev() {
            let node = self.scene.node(id);
            let content = match &node.at_current_time().kind {
                NodeKind::Shape(shape) => Extent::of_shape(shape),
                NodeKind::Group => self.fold(&node.children),
            };
            let outer = node
                .at_current_time()
                .modifiers
                .iter()
                .fold(content, |e, m| e.modified(m));
            extents = [content, outer];
            self.known.insert(id, extents);
        }
        // The node itself was the last.
        extents
    }

    /// Returns the extent of a list of operands.
    fn fold(&self, children: &[NodeId]) -> Extent {
        let mut all = Extent::EMPTY;
        // A chain of smooth unions stands out from its operands by the sum of the joints' offsets, but by no more
        // than the largest blend radius: if the result is that far below every operand, then |a − b| ≥ k.
        let (mut bulges, mut greatest) = (0.0f32, 0.0f32);
        for &id in children {
            let entry = self.scene.node(id).at_current_time();
            let operand = self
                .known
                .get(id)
                .map_or(Extent::EMPTY, |extents| extents[1]);
            if !entry.visible || operand.aabb.is_empty() {
                continue;
            }
            let operator = &entry.operator;
            let first = all.aabb.is_empty();
            match operator.kind {
                OperatorKind::Union if first => all = operand,
                _ if first => continue,
                OperatorKind::Paint => continue,
                OperatorKind::Union => {
                    bulges += operator.max_outward_offset();
                    greatest = greatest.max(operator.blend);
                    all.aabb = all.aabb.union(operand.aabb);
                    all.radius = all.radius.max(operand.radius);
                    all.max_underestimate = all.max_underestimate.max(operand.max_underestimate)
                        + operator.max_outward_offset();
                }
                OperatorKind::Intersect => {
                    let both = all
                        .offset(bulges.min(greatest))
                        .aabb
                        .intersection(operand.aabb);
                    (bulges, greatest) = (0.0, 0.0);
                    all.aabb = if both.is_empty() { operand.aabb } else { both };
                    all.radius = radius_of(all.aabb);
                    // The corner of two overlapping boxes can be √2 times as far as either box.
                    all.lipschitz_inverse = all.lipschitz_inverse.hypot(operand.lipschitz_inverse);
                    all.max_underestimate = f32::INFINITY;
                }
                OperatorKind::Subtract => all.max_underestimate = f32::INFINITY,
                OperatorKind::Morph => {
                    all.aabb = all.aabb.union(operand.aabb);
                    all.radius = all.radius.max(operand.radius);
                    all.max_underestimate = f32::INFINITY;
                    if let Some(ramp) = &entry.ramp {
                        let both = all.lipschitz_inverse.max(operand.lipschitz_inverse);
                        let amount = operator.morph_amount;
                        all.aabb = all.aabb.grown(both * ramp.overshoot(amount));
                        all.radius = radius_of(all.aabb);
                        all.lipschitz_inverse = both * self.scene.ramp_stretch(id);
                    }
                }
            }
            all.lipschitz_inverse = all.lipschitz_inverse.max(operand.lipschitz_inverse);
            if !first {
                let has_ramp = entry.ramp.is_some();
                all.symmetry = all.symmetry.joined(operand.symmetry, operator, has_ramp);
            }
        }
        all.offset(bulges.min(greatest))
    }
}

/// Returns for each axis of a repetition whether mirror symmetry proves that the copy in a point's own cell is the nearest one.
/// For a radial repeat, the first value counts. `content` is what is repeated.
pub fn nearest_is_own(modifier: &Modifier, content: &Extent) -> [bool; 3] {
    let symmetry = content.symmetry;
    let is_euclidean = content.max_underestimate == 0.0 && content.lipschitz_inverse == 1.0;
    match *modifier {
        Modifier::Repeat { spacing, .. } => {
            let reach = content.aabb.min.abs().max(content.aabb.max.abs());
            std::array::from_fn(|axis| {
                let is_within = reach[axis] <= 0.5 * spacing[axis];
                symmetry.rising[axis] || symmetry.even[axis] && is_euclidean && is_within
            })
        }
        // Sectors are mirrored about the half plane through the axis and +x.
        Modifier::RadialRepeat { count } => {
            let half_step = 0.5 * std::f32::consts::TAU / count as f32;
            let is_within = half_angle_about_y(content.aabb) <= half_step;
            [symmetry.even[2] && is_euclidean && is_within, false, false]
        }
        _ => [false; 3],
    }
}

/// Returns the number of copies of a repetition that a point must evaluate along each axis. For a radial repeat,
/// the first value counts. `content` is what is repeated.
pub fn evaluated_copies(modifier: &Modifier, content: &Extent) -> [u32; 3] {
    let (there, extent, step) = match *modifier {
        Modifier::Repeat { spacing, count } => {
            let reach = content.aabb.min.abs().max(content.aabb.max.abs());
            // An axis without copies has one.
            let copies = |axis: usize| match count {
                Some(count) => count[axis],
                None if spacing[axis] > 0.0 => u32::MAX,
                None => 1,
            };
            let there = std::array::from_fn(copies);
            (there, reach.to_array(), spacing)
        }
        Modifier::RadialRepeat { count } => {
            let half = half_angle_about_y(content.aabb);
            let step = std::f32::consts::TAU / count as f32;
            ([count, 1, 1], [half, 0.0, 0.0], [step, 1.0, 1.0])
        }
        _ => return [1; 3],
    };
    let is_nearest = nearest_is_own(modifier, content);
    let axes = || (0..3).filter(|&axis| there[axis] > 1 && !is_nearest[axis]);
    let all = axes().fold(1u64, |all, axis| all.saturating_mul(there[axis].into()));
    let overlap = axes().any(|axis| extent[axis] > 0.5 * step[axis]);
    // Where a copy's distance may be much too short, the nearest copies may not have the shortest distances. Jumps of that
    // size would keep every point from dropping the copies.
    let is_loose = content.max_underestimate > 0.25 * content.aabb.half_diagonal();
    let takes_all = (overlap && content.max_underestimate > 0.0 || is_loose) && all <= FEW_COPIES;
    std::array::from_fn(|axis| match there[axis] {
        0 | 1 => 1,
        _ if is_nearest[axis] => 1,
        there if takes_all => there,
        there => neighbor_copies(extent[axis], step[axis]).min(there),
    })
}
