use crate::keyframe::{self, Keyframe};
use crate::validation::ValidationError;
use crate::{BlendProfile, LoadedGrid, Modifier, Operator, OperatorKind, Shape};

/// What a brush or a group is apart from its place in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeDesc {
    /// A name for people; may be empty, need not be unique.
    pub name: String,
    /// Whether it takes part.
    pub visible: bool,
    /// Whether editors leave it as it is.
    pub locked: bool,
    /// How it acts on what stands above it.
    pub operator: Operator,
    /// Changes of its solid, the first first.
    pub modifiers: Vec<Modifier>,
    /// The name of a material of the scene; without one, that of the group around it.
    pub material: Option<String>,
    /// Values that change with time, in its order.
    pub keyframes: Vec<Keyframe>,
    /// A shape, or a group that holds others.
    pub kind: NodeKind,
}

/// What an entry is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeKind {
    /// A brush.
    Shape(Shape),
    /// A group; what it holds is asked of the scene.
    Group,
}

impl NodeKind {
    /// As [`Shape::file`], of a shape.
    pub fn file(&self) -> Option<(&str, u32, &LoadedGrid)> {
        match self {
            Self::Shape(shape) => shape.file(),
            Self::Group => None,
        }
    }

    /// As [`Shape::file_mut`], of a shape.
    pub fn file_mut(&mut self) -> Option<(&mut String, &mut u32, &mut LoadedGrid)> {
        match self {
            Self::Shape(shape) => shape.file_mut(),
            Self::Group => None,
        }
    }

    /// What a shape takes besides itself, but for a mesh's distances, which are shared.
    pub(crate) fn heap_bytes(&self) -> usize {
        match self {
            Self::Shape(shape) => shape.heap_bytes(),
            Self::Group => 0,
        }
    }
}

impl NodeDesc {
    fn new(kind: NodeKind) -> Self {
        Self {
            name: String::new(),
            visible: true,
            locked: false,
            operator: Operator::default(),
            modifiers: Vec::new(),
            material: None,
            keyframes: Vec::new(),
            kind,
        }
    }

    /// Whether every value can be used; else the first that cannot.
    pub fn check(&self) -> Result<(), ValidationError> {
        self.operator.check()?;
        for (i, modifier) in self.modifiers.iter().enumerate() {
            modifier
                .check()
                .map_err(|f| f.within(&format!("modifiers[{i}]")))?;
        }
        keyframe::check(&self.keyframes)?;
        match &self.kind {
            NodeKind::Shape(shape) => shape.check().map_err(|f| f.within("shape")),
            NodeKind::Group => Ok(()),
        }
    }
}

/// Methods that a brush and a group are built with.
macro_rules! builder {
    ($name:ident) => {
        impl $name {
            /// Give it a name.
            pub fn named(mut self, name: impl Into<String>) -> Self {
                self.0.name = name.into();
                self
            }

            /// Append a modifier.
            pub fn modify(mut self, modifier: Modifier) -> Self {
                self.0.modifiers.push(modifier);
                self
            }

            /// Move it.
            pub fn at(self, position: [f32; 3]) -> Self {
                self.modify(Modifier::Translate { by: position })
            }

            /// Turn it about an axis through the origin.
            pub fn rotated(self, axis: [f32; 3], degrees: f32) -> Self {
                self.modify(Modifier::Rotate { axis, degrees })
            }

            /// Scale it about the origin.
            pub fn scaled(self, by: f32) -> Self {
                self.modify(Modifier::Scale { by })
            }

            /// Act by an operator other than union.
            pub fn operator(mut self, kind: OperatorKind) -> Self {
                self.0.operator.kind = kind;
                self
            }

            /// Take it away from what stands above.
            pub fn subtract(self) -> Self {
                self.operator(OperatorKind::Subtract)
            }

            /// Keep only what lies in it.
            pub fn intersect(self) -> Self {
                self.operator(OperatorKind::Intersect)
            }

            /// Give its material to what stands above.
            pub fn paint(self) -> Self {
                self.operator(OperatorKind::Paint)
            }

            /// Interpolate what stands above towards it, by `amount` from 0 to 1.
            pub fn morph(mut self, amount: f32) -> Self {
                self.0.operator.morph_amount = amount;
                self.operator(OperatorKind::Morph)
            }

            /// Blend the joint over a radius.
            pub fn blend(mut self, radius: f32) -> Self {
                self.0.operator.blend = radius;
                self
            }

            /// Chamfer the joint over a radius.
            pub fn chamfer(mut self, radius: f32) -> Self {
                self.0.operator.profile = BlendProfile::Chamfer;
                self.blend(radius)
            }

            /// Use a material of the scene.
            pub fn material(mut self, name: impl Into<String>) -> Self {
                self.0.material = Some(name.into());
                self
            }

            /// Append a keyframe.
            pub fn keyframe(mut self, keyframe: Keyframe) -> Self {
                self.0.keyframes.push(keyframe);
                self
            }

            /// Take no part.
            pub fn hidden(mut self) -> Self {
                self.0.visible = false;
                self
            }
        }

        impl From<$name> for NodeDesc {
            fn from(value: $name) -> Self {
                value.0
            }
        }
    };
}

/// A brush to be put into a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Brush(NodeDesc);

impl Brush {
    /// A visible union of a shape at the origin.
    pub fn new(shape: Shape) -> Self {
        Self(NodeDesc::new(NodeKind::Shape(shape)))
    }
}
builder!(Brush);

/// An empty group to be put into a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Group(NodeDesc);

impl Group {
    /// A visible group that is a union.
    pub fn new() -> Self {
        Self(NodeDesc::new(NodeKind::Group))
    }
}

impl Default for Group {
    fn default() -> Self {
        Self::new()
    }
}
builder!(Group);
