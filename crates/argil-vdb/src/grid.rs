//! A tree with a name, a class, a transform and metadata.

use crate::{Tree, Voxel};

/// The meaning of a grid's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridClass {
    /// Signed distances near a surface, negative inside.
    LevelSet,
    /// Densities: 0 outside.
    FogVolume,
    /// Anything else.
    #[default]
    Unknown,
}

impl GridClass {
    /// Returns the name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::LevelSet => "level set",
            Self::FogVolume => "fog volume",
            Self::Unknown => "unknown",
        }
    }

    pub(crate) fn from_name(name: &str) -> Self {
        match name {
            "level set" => Self::LevelSet,
            "fog volume" => Self::FogVolume,
            _ => Self::Unknown,
        }
    }
}

/// From index coordinates to the world: `world = matrix · index + translation`. Values stand at integer coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Columns of the matrix: the world's steps for a step along each index axis.
    pub columns: [[f64; 3]; 3],
    /// The world's position of index (0, 0, 0).
    pub translation: [f64; 3],
}

impl Transform {
    /// Creates a transform with cubic voxels, without rotation.
    pub fn uniform(voxel_size: f64, translation: [f64; 3]) -> Self {
        let mut columns = [[0.0; 3]; 3];
        for (axis, column) in columns.iter_mut().enumerate() {
            column[axis] = voxel_size;
        }
        Self {
            columns,
            translation,
        }
    }

    /// Returns the lengths of a voxel's edges.
    pub fn voxel_size(&self) -> [f64; 3] {
        self.columns
            .map(|c| (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt())
    }

    /// Returns the edge of a voxel if voxels are cubes along the world's axes.
    pub fn uniform_voxel_size(&self) -> Option<f64> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.columns[axis][axis]);
        let is_cube = x > 0.0 && (y - x).abs() <= 1e-6 * x && (z - x).abs() <= 1e-6 * x;
        let beside = |i: usize, k: usize| i == k || self.columns[i][k].abs() <= 1e-6 * x;
        let is_straight = (0..3).all(|i| (0..3).all(|k| beside(i, k)));
        (is_cube && is_straight).then_some(x)
    }

    /// Returns the world's position of an index.
    pub fn to_world(&self, index: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|row| {
            let part = |axis: usize| self.columns[axis][row] * index[axis];
            self.translation[row] + part(0) + part(1) + part(2)
        })
    }

    pub(crate) fn is_finite(&self) -> bool {
        let all = self.columns.as_flattened().iter().chain(&self.translation);
        all.into_iter().all(|n| n.is_finite())
    }
}

/// A value of metadata.
#[derive(Clone, Debug, PartialEq)]
pub enum MetaValue {
    /// Text.
    String(String),
    /// True or false.
    Bool(bool),
    /// A 32-bit integer.
    Int32(i32),
    /// A 64-bit integer.
    Int64(i64),
    /// A 32-bit float.
    Float(f32),
    /// A 64-bit float.
    Double(f64),
    /// Three 32-bit integers.
    Vec3i([i32; 3]),
    /// A value of another type: its type and bytes.
    Other(String, Vec<u8>),
}

/// Named values.
pub type Metadata = Vec<(String, MetaValue)>;

/// Everything about a grid besides its values.
#[derive(Clone, Debug, PartialEq)]
pub struct GridHeader {
    /// Name.
    pub name: String,
    /// Meaning of the values.
    pub class: GridClass,
    /// From index coordinates to the world.
    pub transform: Transform,
    /// Metadata besides the name, the class and the statistics, which the writer adds.
    pub metadata: Metadata,
}

impl GridHeader {
    /// Creates a header without metadata.
    pub fn new(name: impl Into<String>, class: GridClass, transform: Transform) -> Self {
        Self {
            name: name.into(),
            class,
            transform,
            metadata: Vec::new(),
        }
    }
}

/// A grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<V> {
    /// Everything besides the values.
    pub header: GridHeader,
    /// The values.
    pub tree: Tree<V>,
}

/// A grid of any type of values.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyGrid {
    /// One number for each voxel.
    Float(Grid<f32>),
    /// Three numbers for each voxel, as colors.
    Vec3(Grid<[f32; 3]>),
}

impl AnyGrid {
    /// Returns the header.
    pub fn header(&self) -> &GridHeader {
        match self {
            Self::Float(grid) => &grid.header,
            Self::Vec3(grid) => &grid.header,
        }
    }

    /// Returns the grid if its values are single numbers.
    pub fn as_float(&self) -> Option<&Grid<f32>> {
        match self {
            Self::Float(grid) => Some(grid),
            Self::Vec3(_) => None,
        }
    }
}

impl<V: Voxel> Grid<V> {
    /// Creates a grid.
    pub fn new(header: GridHeader, tree: Tree<V>) -> Self {
        Self { header, tree }
    }
}

impl From<Grid<f32>> for AnyGrid {
    fn from(grid: Grid<f32>) -> Self {
        Self::Float(grid)
    }
}

impl From<Grid<[f32; 3]>> for AnyGrid {
    fn from(grid: Grid<[f32; 3]>) -> Self {
        Self::Vec3(grid)
    }
}
