use crate::keyframe::{self, Keyframe};
use crate::validation::ValidationError;
use crate::{LoadedGrid, Modifier, Operator, Shape};

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
    pub(crate) fn new(kind: NodeKind) -> Self {
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
    ///
    /// # Errors
    /// The first value that is out of range.
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
