//! Trees of brushes and groups, and the operators that combine them.
//!
//! *Practice.* [`Brush`], [`Group`] and [`Shape`] have the builder methods of [`NodeTree`]. `a | b`, `a - b` and `a & b` combine any of
//! them into a group, as the Python library fogleman/sdf writes it.

use crate::{BlendProfile, Keyframe, Modifier, MorphRamp, NodeDesc, NodeKind, OperatorKind, Shape};

/// A brush, or a group with everything in it, outside any scene.
///
/// [`Scene::push`](crate::Scene::push) inserts one into a scene, and [`Scene::subtree`](crate::Scene::subtree) copies one out of it.
///
/// ```
/// use argil_scene::{Scene, Shape};
/// let cube = Shape::cuboid([0.5, 0.5, 0.5]);
/// let hole = Shape::cylinder(0.2, 1.0);
/// let part = (cube - hole.smooth(0.05)) | Shape::sphere(0.3).at([0.0, 0.8, 0.0]);
/// let mut scene = Scene::new();
/// scene.push(part.at([1.0, 0.0, 0.0]))?;
/// assert_eq!(scene.brush_count(), 3);
/// # Ok::<(), argil_scene::EditError>(())
/// ```
#[derive(Debug, PartialEq)]
pub struct NodeTree {
    /// The brush or group itself.
    pub desc: NodeDesc,
    /// The members of a group, in order. Empty for a brush.
    pub children: Vec<NodeTree>,
}

impl NodeTree {
    /// Iterates over the descriptions of this node and everything in it, in no particular order.
    pub fn entries(&self) -> impl Iterator<Item = &NodeDesc> {
        let mut open = vec![self];
        std::iter::from_fn(move || {
            let next = open.pop()?;
            open.extend(&next.children);
            Some(&next.desc)
        })
    }

    /// Copies what is nested, without recursion. `parts` returns the description of a node, and its children.
    pub(crate) fn copied<N, I: DoubleEndedIterator<Item = N>>(
        root: N,
        parts: impl Fn(N) -> (NodeDesc, I),
    ) -> Self {
        let begun = |node: N| {
            let (desc, children) = parts(node);
            let children: Vec<N> = children.rev().collect();
            (desc, Vec::new(), children)
        };
        let mut top = begun(root);
        // Incomplete copies, innermost last, each with the children that are still missing, next one last.
        let mut around = Vec::new();
        loop {
            let (desc, mut children, mut missing) = top;
            if let Some(child) = missing.pop() {
                around.push((desc, children, missing));
                top = begun(child);
                continue;
            }
            children.shrink_to_fit();
            let whole = Self { desc, children };
            top = match around.pop() {
                Some(above) => above,
                None => return whole,
            };
            top.1.push(whole);
        }
    }

    /// Returns the depth of nesting: 1 for a brush or an empty group.
    pub fn depth(&self) -> usize {
        let mut level: Vec<&Self> = vec![self];
        let mut depth = 0;
        while !level.is_empty() {
            depth += 1;
            level = level.into_iter().flat_map(|tree| &tree.children).collect();
        }
        depth
    }

    /// Whether this is a group that only lists its members: joining one more does not need another group.
    fn is_plain_group(&self) -> bool {
        self.desc == NodeDesc::new(NodeKind::Group)
    }

    fn join(mut self, mut operand: Self, kind: OperatorKind) -> Self {
        operand.desc.operator.kind = kind;
        if !self.is_plain_group() || self.children.is_empty() {
            let mut group = Self::from(Group::new());
            group.desc.operator = std::mem::take(&mut self.desc.operator);
            group.children.push(self);
            self = group;
        }
        self.children.push(operand);
        self
    }
}

/// Clones without recursion, because files may nest groups deeper than a thread's stack.
impl Clone for NodeTree {
    fn clone(&self) -> Self {
        Self::copied(self, |tree| (tree.desc.clone(), tree.children.iter()))
    }
}

/// Drops without recursion, because files may nest groups deeper than a thread's stack.
impl Drop for NodeTree {
    fn drop(&mut self) {
        let mut open = std::mem::take(&mut self.children);
        while let Some(mut next) = open.pop() {
            open.append(&mut next.children);
        }
    }
}

/// A brush to insert into a scene: a shape with its operator, modifiers and material.
///
/// ```
/// use argil_scene::{Brush, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(1.0))?;
/// scene.push(Brush::new(Shape::torus(1.0, 0.2)).at([0.0, 0.5, 0.0]).subtract().smooth(0.1))?;
/// # Ok::<(), argil_scene::EditError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Brush(NodeDesc);

impl Brush {
    /// Creates a visible brush at the origin that adds a shape.
    pub fn new(shape: Shape) -> Self {
        Self(NodeDesc::new(NodeKind::Shape(shape)))
    }
}

/// An empty group to insert into a scene. [`Scene::push_into`](crate::Scene::push_into) fills it.
///
/// ```
/// use argil_scene::{Group, Scene, Shape};
/// let mut scene = Scene::new();
/// let group = scene.push(Group::new().at([1.0, 0.0, 0.0]).with_name("tower"))?.node;
/// scene.push_into(group, Shape::sphere(0.5))?;
/// # Ok::<(), argil_scene::EditError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Group(NodeDesc);

impl Group {
    /// Creates a visible group that adds its contents.
    pub fn new() -> Self {
        Self(NodeDesc::new(NodeKind::Group))
    }
}

impl Default for Group {
    fn default() -> Self {
        Self::new()
    }
}

impl From<Shape> for Brush {
    fn from(shape: Shape) -> Self {
        Self::new(shape)
    }
}

/// Access to the description that builder methods change.
trait Described {
    fn desc(&mut self) -> &mut NodeDesc;
}

impl Described for Brush {
    fn desc(&mut self) -> &mut NodeDesc {
        &mut self.0
    }
}

impl Described for Group {
    fn desc(&mut self) -> &mut NodeDesc {
        &mut self.0
    }
}

impl Described for NodeTree {
    fn desc(&mut self) -> &mut NodeDesc {
        &mut self.desc
    }
}

/// Builder methods of `$name`, which return a `$built`.
macro_rules! builder {
    ($name:ty => $built:ty) => {
        impl $name {
            fn change(self, change: impl FnOnce(&mut NodeDesc)) -> $built {
                let mut built = <$built>::from(self);
                change(built.desc());
                built
            }

            /// Sets the human-readable name, which need not be unique.
            #[must_use]
            pub fn with_name(self, name: impl Into<String>) -> $built {
                self.change(|desc| desc.name = name.into())
            }

            /// Appends a modifier. Modifiers apply in the order in which they were appended.
            #[must_use]
            pub fn with_modifier(self, modifier: Modifier) -> $built {
                self.change(|desc| desc.modifiers.push(modifier))
            }

            /// Uses a material of the scene, by its name.
            #[must_use]
            pub fn with_material(self, name: impl Into<String>) -> $built {
                self.change(|desc| desc.material = Some(name.into()))
            }

            /// Appends a keyframe.
            #[must_use]
            pub fn with_keyframe(self, keyframe: Keyframe) -> $built {
                self.change(|desc| desc.keyframes.push(keyframe))
            }

            /// Sets the operator that combines this with everything before it.
            #[must_use]
            pub fn with_operator(self, kind: OperatorKind) -> $built {
                self.change(|desc| desc.operator.kind = kind)
            }

            /// Translates by a vector, in the scene's unit.
            #[must_use]
            #[doc(alias = "translate")]
            pub fn at(self, position: [f32; 3]) -> $built {
                self.with_modifier(Modifier::Translate { by: position })
            }

            /// Rotates about an axis through the origin.
            #[must_use]
            pub fn rotated(self, axis: [f32; 3], degrees: f32) -> $built {
                self.with_modifier(Modifier::Rotate { axis, degrees })
            }

            /// Scales about the origin.
            #[must_use]
            pub fn scaled(self, by: f32) -> $built {
                self.with_modifier(Modifier::Scale { by })
            }

            /// Subtracts this from everything before it.
            #[must_use]
            #[doc(alias = "difference")]
            pub fn subtract(self) -> $built {
                self.with_operator(OperatorKind::Subtract)
            }

            /// Keeps only what lies inside this.
            #[must_use]
            #[doc(alias = "intersection")]
            pub fn intersect(self) -> $built {
                self.with_operator(OperatorKind::Intersect)
            }

            /// Gives its material to everything before it, without changing the solid.
            #[must_use]
            pub fn paint(self) -> $built {
                self.with_operator(OperatorKind::Paint)
            }

            /// Morphs everything before it toward this, by an amount from 0 to 1.
            #[must_use]
            pub fn morph(self, amount: f32) -> $built {
                self.change(|desc| {
                    desc.operator.morph_amount = amount;
                    desc.operator.kind = OperatorKind::Morph;
                })
            }

            /// Lets a morph go farther in some places than in others.
            #[must_use]
            pub fn with_ramp(self, ramp: MorphRamp) -> $built {
                self.change(|desc| desc.ramp = Some(Box::new(ramp)))
            }

            /// Blends the joint smoothly over a radius in the scene's unit.
            /// The blend adds material up to a quarter of the radius beyond both solids where their surfaces are
            /// close, also where they are flush. See [`BlendProfile`](crate::BlendProfile) for the formula.
            #[must_use]
            #[doc(alias = "smin")]
            #[doc(alias = "smooth_union")]
            #[doc(alias = "fillet")]
            pub fn smooth(self, radius: f32) -> $built {
                self.change(|desc| {
                    desc.operator.profile = BlendProfile::Smooth;
                    desc.operator.blend = radius;
                })
            }

            /// Chamfers the joint over a radius in the scene's unit.
            #[must_use]
            pub fn chamfer(self, radius: f32) -> $built {
                self.change(|desc| {
                    desc.operator.profile = BlendProfile::Chamfer;
                    desc.operator.blend = radius;
                })
            }

            /// Leaves this out of the solid.
            #[must_use]
            pub fn hidden(self) -> $built {
                self.change(|desc| desc.visible = false)
            }
        }

        impl<T: Into<NodeTree>> std::ops::BitOr<T> for $name {
            type Output = NodeTree;

            /// The union.
            fn bitor(self, other: T) -> NodeTree {
                NodeTree::from(self).join(other.into(), OperatorKind::Union)
            }
        }

        impl<T: Into<NodeTree>> std::ops::BitAnd<T> for $name {
            type Output = NodeTree;

            /// The intersection.
            fn bitand(self, other: T) -> NodeTree {
                NodeTree::from(self).join(other.into(), OperatorKind::Intersect)
            }
        }

        impl<T: Into<NodeTree>> std::ops::Sub<T> for $name {
            type Output = NodeTree;

            /// The difference.
            fn sub(self, other: T) -> NodeTree {
                NodeTree::from(self).join(other.into(), OperatorKind::Subtract)
            }
        }
    };
}

builder!(Shape => Brush);
builder!(Brush => Brush);
builder!(Group => Group);
builder!(NodeTree => NodeTree);

impl From<NodeDesc> for NodeTree {
    fn from(desc: NodeDesc) -> Self {
        let children = Vec::new();
        Self { desc, children }
    }
}

/// Conversions to a description and to a tree.
macro_rules! conversions {
    ($($name:ident)*) => {$(
        impl From<$name> for NodeDesc {
            fn from(value: $name) -> Self {
                value.0
            }
        }

        impl From<$name> for NodeTree {
            fn from(value: $name) -> Self {
                value.0.into()
            }
        }
    )*};
}
conversions!(Brush Group);

impl From<Shape> for NodeDesc {
    fn from(shape: Shape) -> Self {
        Brush::new(shape).into()
    }
}

impl From<Shape> for NodeTree {
    fn from(shape: Shape) -> Self {
        Brush::new(shape).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Operators nest only where grouping matters, and keep blends.
    #[test]
    fn operators_build_the_groups_that_they_mean() {
        let [a, b, c] = [0.1, 0.2, 0.3].map(Shape::sphere);
        let flat = a.clone() | b.clone().smooth(0.05) | c.clone();
        assert_eq!((flat.depth(), flat.children.len()), (2, 3));
        assert_eq!(flat.children[1].desc.operator.blend, 0.05);
        let nested = a.clone() - (b.clone() | c.clone());
        assert_eq!((nested.depth(), nested.children.len()), (3, 2));
        assert_eq!(
            nested.children[1].desc.operator.kind,
            OperatorKind::Subtract
        );
        let moved = (a | b).at([1.0, 0.0, 0.0]) & c;
        assert_eq!((moved.depth(), moved.children.len()), (3, 2));
        assert!(moved.desc.modifiers.is_empty());
    }
}
