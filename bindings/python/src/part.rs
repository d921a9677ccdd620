//! Parts of a scene to be, and how much their distances are divided.
//!
//! A twisted solid's distances are divided by how much it stretches space. Blends and offsets of fogleman/sdf measure
//! undivided distances. So where a joint or an offset measures, all of its distances and lengths are divided by the same number.

use argil::scene::{
    Extents, Group, Modifier, MorphRamp, NodeDesc, NodeId, NodeTree, Operator, OperatorKind, Ramp,
    Scene,
};

/// A node, and the factor by which its distances are divided.
pub struct Part {
    tree: NodeTree,
    divisor: f32,
    /// The children's divisors, if they differ. All joints are hard then.
    of_children: Option<Vec<f32>>,
}

impl Part {
    /// Creates a part of a node whose distances are not divided.
    pub fn new(tree: NodeTree) -> Self {
        Self {
            tree,
            divisor: 1.0,
            of_children: None,
        }
    }

    /// Creates a part of nodes that came from a scene.
    ///
    /// # Errors
    /// If a node is refused.
    pub fn of_nodes(group: NodeTree) -> Result<Self, String> {
        let divides =
            |desc: &NodeDesc| desc.ramp.is_some() || desc.modifiers.iter().any(divides_distances);
        let mut part = Self::new(group);
        if part.tree.entries().any(divides) {
            let (scene, node) = part.measured()?;
            part.divisor = divisor(&scene, node);
        }
        Ok(part)
    }

    pub fn into_tree(self) -> NodeTree {
        self.tree
    }

    pub fn tree_mut(&mut self) -> &mut NodeTree {
        &mut self.tree
    }

    /// Returns a scene of the part alone, and the part in it.
    fn measured(&self) -> Result<(Scene, NodeId), String> {
        let mut tree = self.tree.clone();
        let mut open = vec![&mut tree];
        while let Some(tree) = open.pop() {
            // The scene has no materials.
            tree.desc.material = None;
            open.extend(&mut tree.children);
        }
        let mut scene = Scene::new();
        let pushed = scene.push(tree);
        pushed.map_err(|error| error.to_string())?;
        let node = scene.node(Scene::ROOT).children()[0];
        Ok((scene, node))
    }

    /// Divides all distances by the same factor, which is at least the largest so far.
    fn divide_by(&mut self, factor: f32) {
        match self.of_children.take() {
            Some(divisors) => {
                for (child, divisor) in self.tree.children.iter_mut().zip(divisors) {
                    scale_distance(&mut child.desc.modifiers, divisor / factor);
                }
            }
            None => scale_distance(&mut self.tree.desc.modifiers, self.divisor / factor),
        }
        self.divisor = factor;
    }

    /// Appends a modifier.
    ///
    /// # Errors
    /// If a node is refused.
    pub fn modify(&mut self, modifier: &Modifier) -> Result<(), String> {
        let mut modifier = modifier.clone();
        if let Modifier::Round { radius: length }
        | Modifier::Shell {
            half_thickness: length,
        }
        | Modifier::Displace {
            amplitude: length, ..
        } = &mut modifier
        {
            self.divide_by(self.divisor);
            *length /= self.divisor;
        }
        if divides_distances(&modifier) {
            let (scene, node) = self.measured()?;
            let content = Extents::of(&scene).node_bounds(node);
            self.divisor *= modifier.stretch(&content);
        }
        append(&mut self.tree.desc.modifiers, modifier);
        Ok(())
    }

    /// Joins a part to this one, as an operand of the same list where that means the same.
    ///
    /// # Errors
    /// If a node is refused.
    pub fn join(
        &mut self,
        mut right: Self,
        operator: &Operator,
        ramp: Option<&Ramp>,
    ) -> Result<(), String> {
        let mut operator = *operator;
        let factor = self.divisor.max(right.divisor);
        if operator.blend > 0.0 || operator.kind == OperatorKind::Morph {
            self.divide_by(factor);
            right.divide_by(factor);
            operator.blend /= factor;
        }
        let same_divisor = self.of_children.is_none()
            && right.of_children.is_none()
            && self.divisor == right.divisor;
        self.open_list(same_divisor);
        let adds = |tree: &NodeTree| tree.desc.operator == Operator::default();
        let is_list = operator == Operator::default()
            && is_plain_group(&right.tree)
            && right.tree.children.iter().all(adds);
        if !is_list {
            right.divide_by(right.divisor);
        }
        let added = if is_list {
            std::mem::take(&mut right.tree.children)
        } else {
            right.tree.desc.operator = operator;
            vec![right.tree]
        };
        if let Some(ours) = &mut self.of_children {
            let theirs = right.of_children.take();
            ours.extend(theirs.unwrap_or_else(|| vec![right.divisor; added.len()]));
        }
        self.tree.children.extend(added);
        self.divisor = factor;
        match ramp {
            Some(ramp) => self.follow(ramp),
            None => Ok(()),
        }
    }

    /// Makes the part a group that only holds others. `same_divisor`: what comes next has the same divisor.
    fn open_list(&mut self, same_divisor: bool) {
        let is_list = is_plain_group(&self.tree) && !self.tree.children.is_empty();
        if is_list && (same_divisor || self.of_children.is_some()) {
            return;
        }
        self.divide_by(self.divisor);
        let mut group: NodeTree = Group::new().into();
        group
            .children
            .push(std::mem::replace(&mut self.tree, Group::new().into()));
        self.tree = group;
        self.of_children = (!same_divisor).then(|| vec![self.divisor]);
    }

    /// Lets the last operand, a morph, follow a ramp.
    fn follow(&mut self, ramp: &Ramp) -> Result<(), String> {
        let (scene, group) = self.measured()?;
        if let Some(&last) = scene.node(group).children().last()
            && let Some(operand) = self.tree.children.last_mut()
        {
            operand.desc.ramp = Some(Box::new(MorphRamp {
                along: ramp.clone(),
                max_difference: scene.max_difference(last),
            }));
            let (scene, group) = self.measured()?;
            let last = scene.node(group).children().last();
            self.divisor *= last.map_or(1.0, |&last| scene.ramp_stretch(last));
        }
        Ok(())
    }
}

/// Whether a modifier divides the distances of what it deforms.
fn divides_distances(modifier: &Modifier) -> bool {
    matches!(
        modifier,
        Modifier::Twist { .. }
            | Modifier::Bend { .. }
            | Modifier::Shift { .. }
            | Modifier::Wrap { .. }
            | Modifier::Displace { .. }
            | Modifier::ScaleDistance { .. }
    )
}

/// Returns the largest factor by which distances of a node's parts are divided.
fn divisor(scene: &Scene, node: NodeId) -> f32 {
    let parents_first: Vec<NodeId> = scene.descendants(node).collect();
    let mut extents = Extents::of(scene);
    let mut known = std::collections::HashMap::new();
    let mut found = 1.0;
    for &id in parents_first.iter().rev() {
        found = 1.0f32;
        for child in scene.node(id).children() {
            found = found.max(known.get(child).copied().unwrap_or(1.0));
            found *= scene.ramp_stretch(*child);
        }
        let stages = extents.modifier_stages(id);
        for (modifier, content) in scene.node(id).desc().modifiers.iter().zip(stages) {
            found *= match *modifier {
                Modifier::ScaleDistance { by } => 1.0 / by,
                _ => modifier.stretch(&content),
            };
        }
        known.insert(id, found);
    }
    found
}

/// Appends a modifier, or adds it to the last one if that moves along, or turns about, the same axis.
fn append(modifiers: &mut Vec<Modifier>, modifier: Modifier) {
    match (modifiers.last_mut(), &modifier) {
        (Some(Modifier::Translate { by }), Modifier::Translate { by: more }) => {
            for (by, more) in by.iter_mut().zip(more) {
                *by += more;
            }
        }
        (
            Some(Modifier::Rotate { axis, degrees }),
            Modifier::Rotate {
                axis: other,
                degrees: more,
            },
        ) if axis == other => *degrees = (*degrees + more) % 360.0,
        _ => modifiers.push(modifier),
    }
}

/// Appends a factor of distances, or multiplies the last one.
fn scale_distance(modifiers: &mut Vec<Modifier>, factor: f32) {
    // No more than rounding.
    if factor > 0.999_999 {
        return;
    }
    if let Some(Modifier::ScaleDistance { by }) = modifiers.last_mut() {
        *by = (*by * factor).max(1e-4);
    } else {
        modifiers.push(Modifier::ScaleDistance {
            by: factor.max(1e-4),
        });
    }
}

/// Whether a node is a group that only holds others.
pub fn is_plain_group(tree: &NodeTree) -> bool {
    let blank: NodeDesc = Group::new().into();
    tree.desc == blank
}
