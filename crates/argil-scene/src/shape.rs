use crate::shape_checks::{self as rules, *};
use crate::{LoadedGrid, Path2, SampledGrid, SplinePoint, ValidationError, shape_table};
use argil_math::Aabb;
use glam::{Vec2, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Makes [`Shape`] and what follows from each row of the [table](crate::shape_table).
macro_rules! shapes {
    ($($kind:ident {$(
        $(#[$doc:meta])*
        $shape:ident($function:ident $(, $loops:ident)?) {$(
            $(#[$about:meta])*
            $field:ident: $type:ty => $check:ident $(($($limit:expr),*))?,
        )*}
        $(rule($rule:expr))?
        words($words:expr)
        bounds($bounds:expr)
        exact($exact:expr)
        example($example:expr);
    )*})*) => {
        /// A solid around the origin, in the scene's length unit. Names and placements follow Inigo Quilez's catalogue
        /// of distance functions (<https://iquilezles.org/articles/distfunctions/>); what "up" is, is y.
        ///
        /// ```
        /// use argil_scene::{Exactness, Shape};
        /// let shape = Shape::sphere(0.5);
        /// assert_eq!(shape.exactness(), Exactness::Exact);
        /// assert!(Shape::sphere(-1.0).check().is_err());
        /// ```
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(JsonSchema))]
        #[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
        pub enum Shape {$($(
            $(#[$doc])*
            $shape {$(
                $(#[$about])*
                $field: $type,
            )*},
        )*)*}

        #[allow(unused_variables, reason = "not every row needs all of its parameters everywhere")]
        impl Shape {
            /// Whether every parameter can be used.
            ///
            /// # Errors
            /// The first that cannot.
            pub fn check(&self) -> Result<(), ValidationError> {
                match self {$($(
                    Self::$shape { $($field),* } => {
                        $(let $field = $field.read();)*
                        $(rules::$check(stringify!($field), $field $($(, $limit)*)?)?;)*
                        $($rule?;)?
                        Ok(())
                    }
                )*)*}
            }

            /// A box around the solid, in the shape's own frame; infinite for a plane.
            pub fn aabb(&self) -> Aabb {
                match self {$($(
                    Self::$shape { $($field),* } => {
                        $(let $field = $field.read();)*
                        $bounds
                    }
                )*)*}
            }

            /// Bytes that it takes besides itself, but for a mesh's distances, which are shared.
            pub(crate) fn heap_bytes(&self) -> usize {
                match self {$($(
                    Self::$shape { $($field),* } => 0 $(+ $field.heap_bytes())*,
                )*)*}
            }

            /// What shape it is: the variant's name.
            ///
            /// ```
            /// assert_eq!(argil_scene::Shape::sphere(1.0).kind(), "Sphere");
            /// ```
            pub fn kind(&self) -> &'static str {
                match self {$($(
                    Self::$shape { .. } => stringify!($shape),
                )*)*}
            }

            /// Whether the distance is Euclidean or a lower bound of it.
            pub fn exactness(&self) -> Exactness {
                let is_exact = match self {$($(
                    Self::$shape { $($field),* } => {
                        $(let $field = $field.read();)*
                        $exact
                    }
                )*)*};
                if is_exact { Exactness::Exact } else { Exactness::LowerBound }
            }

            /// An example of each shape, of a size that goes together with the others, in the order of the table; of a mesh, which is
            /// a file, there is none.
            ///
            /// ```
            /// let examples = argil_scene::Shape::examples();
            /// assert!(examples.iter().all(|shape| shape.check().is_ok()));
            /// ```
            pub fn examples() -> Vec<Self> {
                let all: Vec<Option<Self>> = vec![$($($example),*),*];
                all.into_iter().flatten().collect()
            }
        }
    };
}

shape_table!(shapes);

/// A parameter as rows read it: numbers by value, what is larger by reference.
#[doc(hidden)]
pub trait ShapeParameter {
    /// How it is read.
    type Read<'a>
    where
        Self: 'a;
    /// Read it.
    fn read(&self) -> Self::Read<'_>;
    /// Bytes that it takes besides itself, but for what is shared.
    fn heap_bytes(&self) -> usize {
        0
    }
}

macro_rules! read_by_value {
    ($($type:ty),*) => {$(
        impl ShapeParameter for $type {
            type Read<'a> = $type;
            fn read(&self) -> $type {
                *self
            }
        }
    )*};
}

macro_rules! read_by_reference {
    ($($type:ty as $read:ty: $bytes:expr),*) => {$(
        impl ShapeParameter for $type {
            type Read<'a> = &'a $read;
            fn read(&self) -> &$read {
                self
            }
            fn heap_bytes(&self) -> usize {
                let bytes: fn(&Self) -> usize = $bytes;
                bytes(self)
            }
        }
    )*};
}

read_by_value!(f32, u32, [f32; 2], [f32; 3], [f32; 4]);
read_by_reference!(
    Vec<SplinePoint> as [SplinePoint]: |points| size_of_val(&points[..]),
    Path2 as Path2: |outline| size_of_val(&outline.segments[..]),
    String as str: String::len,
    LoadedGrid as LoadedGrid: |_| 0
);

fn mesh_resolution() -> u32 {
    128
}

fn posts() -> u32 {
    512
}

fn base() -> f32 {
    0.1
}

/// How far to trust a shape's distance, divided by its Lipschitz constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exactness {
    /// The Euclidean distance, inside and outside.
    Exact,
    /// Never more than the Euclidean distance; the surface itself is right.
    LowerBound,
}

impl Shape {
    /// By how much the distance can change over a length of 1: 1, and of what lies between samples of a mesh's edges and
    /// corners up to √3.
    pub fn lipschitz(&self) -> f32 {
        match self {
            Self::Mesh { grid, .. } => grid.0.as_ref().map_or(1.0, |grid| grid.lipschitz()),
            _ => 1.0,
        }
    }

    /// The triangles of a file, with 128 samples along the longest side, to be loaded.
    pub fn mesh(path: impl Into<String>) -> Self {
        Self::Mesh {
            path: path.into(),
            resolution: mesh_resolution(),
            grid: LoadedGrid::default(),
        }
    }

    /// Ground as high as a PNG image is bright, with up to 512 posts along its longer side, to be loaded.
    pub fn heightmap(path: impl Into<String>, half_size: [f32; 2], height: f32) -> Self {
        Self::Heightmap {
            path: path.into(),
            half_size,
            height,
            base: base(),
            resolution: posts(),
            grid: LoadedGrid::default(),
        }
    }

    /// Sampled distances, under a name of one's own. [Saving](crate::Scene::save) the scene writes them beside it, as `name.grid`.
    pub fn sampled(name: impl AsRef<str>, grid: SampledGrid) -> Self {
        Self::Mesh {
            path: format!("{}.grid", name.as_ref()),
            resolution: mesh_resolution(),
            grid: LoadedGrid(Some(Arc::new(grid))),
        }
    }

    /// What a file is in a scene: a heightmap of an image, with a longer side of 2, a mesh of any other.
    pub fn of_file(path: impl Into<String>) -> Self {
        let path = path.into();
        match rules::is_image(&path) {
            true => Self::heightmap(path, [1.0; 2], 0.25),
            false => Self::mesh(path),
        }
    }

    /// The file that it is made of when the scene is loaded, how finely, and what it then is; of a mesh or a heightmap.
    pub fn file(&self) -> Option<(&str, u32, &LoadedGrid)> {
        match self {
            Self::Mesh {
                path,
                resolution,
                grid,
            } => Some((path, *resolution, grid)),
            Self::Heightmap {
                path,
                resolution,
                grid,
                ..
            } => Some((path, *resolution, grid)),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn file_mut(&mut self) -> Option<(&mut String, &mut u32, &mut LoadedGrid)> {
        match self {
            Self::Mesh {
                path,
                resolution,
                grid,
            } => Some((path, resolution, grid)),
            Self::Heightmap {
                path,
                resolution,
                grid,
                ..
            } => Some((path, resolution, grid)),
            _ => None,
        }
    }

    /// A ball.
    pub fn sphere(radius: f32) -> Self {
        Self::Sphere { radius }
    }

    /// A box with sharp edges.
    pub fn cuboid(half_size: [f32; 3]) -> Self {
        Self::Box {
            half_size,
            rounding: 0.0,
        }
    }

    /// A box with round edges, of the same half size.
    pub fn rounded_box(half_size: [f32; 3], rounding: f32) -> Self {
        Self::Box {
            half_size,
            rounding,
        }
    }

    /// A ring about the y axis.
    pub fn torus(major_radius: f32, minor_radius: f32) -> Self {
        Self::Torus {
            major_radius,
            minor_radius,
        }
    }

    /// A ball swept between two points.
    pub fn capsule(from: [f32; 3], to: [f32; 3], radius: f32) -> Self {
        Self::Capsule { from, to, radius }
    }

    /// A cylinder about y with sharp rims.
    pub fn cylinder(radius: f32, half_height: f32) -> Self {
        Self::Cylinder {
            radius,
            half_height,
            rounding: 0.0,
        }
    }
}
