use crate::shape_checks::{self as rules, *};
use crate::{
    Curve, LoadedGrid, Path2, Poses, Ramp, SampledGrid, SplinePoint, ValidationError, shape_table,
};
use argil_math::Aabb;
use glam::{Vec2, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Generates [`Shape`] from the rows of the [table](crate::shape_table).
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
        /// A solid around the origin, in the scene's unit of length.
        ///
        /// Names and placements follow Inigo Quilez's catalog of distance functions
        /// (<https://iquilezles.org/articles/distfunctions/>). The axis y points up.
        ///
        /// ```
        /// use argil_scene::{Exactness, Shape};
        /// let shape = Shape::sphere(0.5);
        /// assert_eq!(shape.exactness(), Exactness::Exact);
        /// assert!(Shape::sphere(-1.0).check().is_err());
        /// ```
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(JsonSchema))]
        #[serde(
            tag = "type",
            rename_all = "snake_case",
            deny_unknown_fields,
            expecting = "an object with a \"type\""
        )]
        pub enum Shape {$($(
            $(#[$doc])*
            #[cfg_attr(doc, doc = include_str!(concat!("pictures/", stringify!($shape), ".md")))]
            $shape {$(
                $(#[$about])*
                $field: $type,
            )*},
        )*)*}

        #[allow(unused_variables, reason = "not every row needs all of its parameters everywhere")]
        impl Shape {
            /// Checks that every parameter is in its range.
            ///
            /// # Errors
            /// The first parameter that is out of range.
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

            /// Returns the box of the solid in the shape's own frame. It is infinite for a plane.
            pub fn aabb(&self) -> Aabb {
                match self {$($(
                    Self::$shape { $($field),* } => {
                        $(let $field = $field.read();)*
                        $bounds
                    }
                )*)*}
            }

            /// Returns the heap bytes of the shape, without shared mesh samples.
            pub(crate) fn heap_bytes(&self) -> usize {
                match self {$($(
                    Self::$shape { $($field),* } => 0 $(+ $field.heap_bytes())*,
                )*)*}
            }

            /// Returns the name of the shape: the variant's name.
            ///
            /// ```
            /// assert_eq!(argil_scene::Shape::sphere(1.0).kind(), "Sphere");
            /// ```
            pub fn kind(&self) -> &'static str {
                match self {$($(
                    Self::$shape { .. } => stringify!($shape),
                )*)*}
            }

            /// Returns whether the distance is Euclidean or a lower bound of it.
            pub fn exactness(&self) -> Exactness {
                let is_exact = match self {$($(
                    Self::$shape { $($field),* } => {
                        $(let $field = $field.read();)*
                        $exact
                    }
                )*)*};
                if is_exact { Exactness::Exact } else { Exactness::LowerBound }
            }

            /// Returns an example of each shape, of similar size, in the order of the table. There is none of a
            /// mesh, which needs a file.
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

/// How a table row reads a parameter: numbers by value, and larger data by reference.
#[doc(hidden)]
pub trait ShapeParameter {
    /// The type that rows see.
    type Read<'a>
    where
        Self: 'a;
    /// Reads the parameter.
    fn read(&self) -> Self::Read<'_>;
    /// Returns its heap bytes, without shared data.
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

read_by_value!(
    f32,
    u32,
    [bool; 3],
    [f32; 2],
    [f32; 3],
    [f32; 4],
    Option<[u32; 3]>
);
read_by_reference!(
    Vec<SplinePoint> as [SplinePoint]: |points| size_of_val(&points[..]),
    Poses as Poses: |poses| size_of_val(&poses[..]),
    Ramp as Ramp: Ramp::heap_bytes,
    Curve as Curve: |curve| size_of_val(curve.pieces()),
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

/// The accuracy of a shape's distance, divided by its Lipschitz constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exactness {
    /// The Euclidean distance, inside and outside.
    Exact,
    /// A lower bound of the Euclidean distance. The surface itself is exact.
    LowerBound,
}

impl Shape {
    /// Returns the Lipschitz constant of the distance: 1, or up to √3 between the samples of a mesh.
    pub fn lipschitz(&self) -> f32 {
        match self {
            Self::Mesh { grid, .. } => grid.0.as_ref().map_or(1.0, |grid| grid.lipschitz()),
            _ => 1.0,
        }
    }

    /// Creates the solid of a mesh file, with 128 samples along its longest side. Load it with
    /// `argil::load_meshes`.
    pub fn mesh(path: impl Into<String>) -> Self {
        Self::Mesh {
            path: path.into(),
            resolution: mesh_resolution(),
            grid: LoadedGrid::default(),
        }
    }

    /// Creates ground from a PNG image, with up to 512 posts along its longer side. Load it with
    /// `argil::load_meshes`.
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

    /// Creates a shape from sampled distances, with a name. [Saving](crate::Scene::save) the scene writes the
    /// samples next to it, as `name.grid`.
    pub fn sampled(name: impl AsRef<str>, grid: SampledGrid) -> Self {
        Self::Mesh {
            path: format!("{}.grid", name.as_ref()),
            resolution: mesh_resolution(),
            grid: LoadedGrid(Some(Arc::new(grid))),
        }
    }

    /// Creates the shape of a file: a heightmap with a longer side of 2 for an image, and a mesh otherwise.
    pub fn from_file(path: impl Into<String>) -> Self {
        let path = path.into();
        match rules::is_image(&path) {
            true => Self::heightmap(path, [1.0; 2], 0.25),
            false => Self::mesh(path),
        }
    }

    /// Returns path, resolution and samples of a mesh or a heightmap, and `None` for other shapes.
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

    /// Returns path, resolution and samples of a mesh or a heightmap, to change them.
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

    /// Creates a sphere.
    pub fn sphere(radius: f32) -> Self {
        Self::Sphere { radius }
    }

    /// Creates a box with sharp edges. `half_size` is half the length of each side.
    #[doc(alias = "box")]
    #[doc(alias = "half_extents")]
    pub fn cuboid(half_size: [f32; 3]) -> Self {
        Self::Box {
            half_size,
            rounding: 0.0,
        }
    }

    /// Creates a box with rounded edges, within the same half size.
    pub fn rounded_box(half_size: [f32; 3], rounding: f32) -> Self {
        Self::Box {
            half_size,
            rounding,
        }
    }

    /// Creates a torus about the y axis.
    pub fn torus(major_radius: f32, minor_radius: f32) -> Self {
        Self::Torus {
            major_radius,
            minor_radius,
        }
    }

    /// Creates a capsule: a sphere swept between two points.
    pub fn capsule(from: [f32; 3], to: [f32; 3], radius: f32) -> Self {
        Self::Capsule { from, to, radius }
    }

    /// Creates a cylinder about the y axis with sharp rims.
    pub fn cylinder(radius: f32, half_height: f32) -> Self {
        Self::Cylinder {
            radius,
            half_height,
            rounding: 0.0,
        }
    }
}
