use crate::keyframe::{self, Keyframe};
use crate::validation::ValidationError;
use crate::{LoadedGrid, Modifier, MorphRamp, Operator, Shape};

/// The description of a brush or a group, apart from its place in a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeDesc {
    /// A human-readable name. It may be empty, and need not be unique.
    pub name: String,
    /// Whether it takes part in the solid.
    pub visible: bool,
    /// Whether editors protect it from changes.
    pub locked: bool,
    /// How it combines with everything before it.
    pub operator: Operator,
    /// Where a morph goes how far. Without it, the amount is the same everywhere.
    pub ramp: Option<Box<MorphRamp>>,
    /// Transforms and deformations, applied in order.
    pub modifiers: Vec<Modifier>,
    /// Name of a material of the scene. If it is missing, the surrounding group's material applies.
    pub material: Option<String>,
    /// Values that change with time, in order of time.
    pub keyframes: Vec<Keyframe>,
    /// A shape, or a group.
    pub kind: NodeKind,
}

/// What a node is.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeKind {
    /// A brush with a shape.
    Shape(Shape),
    /// A group. The scene holds its contents.
    Group,
}

impl NodeKind {
    /// Returns the file of a shape: see [`Shape::file`].
    pub fn file(&self) -> Option<(&str, u32, &LoadedGrid)> {
        match self {
            Self::Shape(shape) => shape.file(),
            Self::Group => None,
        }
    }

    /// Returns the file of a shape, to change it: see [`Shape::file_mut`].
    pub fn file_mut(&mut self) -> Option<(&mut String, &mut u32, &mut LoadedGrid)> {
        match self {
            Self::Shape(shape) => shape.file_mut(),
            Self::Group => None,
        }
    }

    /// Returns the heap bytes of a shape, without shared mesh samples.
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
            ramp: None,
            modifiers: Vec::new(),
            material: None,
            keyframes: Vec::new(),
            kind,
        }
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValidationError> {
        self.operator.check()?;
        if let Some(ramp) = &self.ramp {
            ramp.check(self.operator.kind)?;
        }
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
