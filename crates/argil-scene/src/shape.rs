use crate::shape_rules::{self as rules, *};
use crate::{Fault, SampledGrid, shape_table};
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
            pub fn check(&self) -> Result<(), Fault> {
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

            /// Whether the distance is Euclidean or a lower bound of it.
            pub fn exactness(&self) -> Exactness {
                let is_exact = match self {$($(
                    Self::$shape { $($field),* } => {
                        $(let $field = $field.read();)*
                        $exact
                    }
                )*)*};
                if is_exact { Exactness::Exact } else { Exactness::Bound }
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
    Outline as Outline: |outline| size_of_val(&outline.pieces[..]),
    String as str: String::len,
    MeshGrid as MeshGrid: |_| 0
);

/// The distances of a mesh, where it is loaded. Any two are equal: what they are follows from the file's name.
#[derive(Clone, Debug, Default)]
pub struct MeshGrid(pub Option<Arc<SampledGrid>>);

impl PartialEq for MeshGrid {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl MeshGrid {
    /// A box around the solid, as far as it is known: its samples'; empty where it is not loaded.
    #[doc(hidden)]
    pub fn region(&self) -> Aabb {
        self.0.as_ref().map_or(Aabb::EMPTY, |grid| grid.region())
    }

    /// The samples as interpreters read them; none where it is not loaded.
    #[doc(hidden)]
    pub fn words(&self) -> &[f32] {
        self.0.as_ref().map_or(&[], |grid| grid.words())
    }
}

fn mesh_resolution() -> u32 {
    128
}

fn posts() -> u32 {
    512
}

fn base() -> f32 {
    0.1
}

/// A point that a spline tube goes through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SplinePoint {
    /// Where it is.
    pub at: [f32; 3],
    /// Radius of the tube there.
    pub radius: f32,
}

impl SplinePoint {
    /// A point, with the tube's radius there.
    pub fn new(at: [f32; 3], radius: f32) -> Self {
        Self { at, radius }
    }
}

/// A piece of a spline tube: start, control point and end of a quadratic Bézier curve, radii at its start and end.
#[doc(hidden)]
pub type TubePiece = ([Vec3; 3], [f32; 2]);

/// The pieces of a tube through points, two from each to the next, which meet halfway between their control points.
#[doc(hidden)]
pub fn spline_pieces(points: &[SplinePoint]) -> impl Iterator<Item = TubePiece> + '_ {
    let at = |i: usize| Vec3::from(points[i.min(points.len() - 1)].at);
    // A quarter of the way that the curve goes at a point in the unit of its parameter.
    let quarter = move |i: usize| 0.125 * (at(i + 1) - at(i.saturating_sub(1)));
    (1..points.len()).flat_map(move |i| {
        let (a, b) = (at(i - 1), at(i));
        let (left, right) = (a + quarter(i - 1), b - quarter(i));
        let middle = 0.5 * (left + right);
        let [from, to] = [points[i - 1].radius, points[i].radius];
        let halfway = 0.5 * (from + to);
        [
            ([a, left, middle], [from, halfway]),
            ([middle, right, b], [halfway, to]),
        ]
    })
}

/// A closed outline in 2D, of lines and quadratic Bézier curves. A line closes it where the last piece ends elsewhere
/// than at the start. What lies inside is decided by the even-odd rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Outline {
    /// Where the outline starts.
    pub start: [f32; 2],
    /// Its pieces, each from where the one before ended.
    pub pieces: Vec<Piece>,
}

/// A piece of an outline: a line, or a curve where there is a control point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Piece {
    /// Control point of a quadratic Bézier curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<[f32; 2]>,
    /// Where the piece ends.
    pub to: [f32; 2],
}

impl Outline {
    /// An outline that starts at a point.
    ///
    /// ```
    /// use argil_scene::{Outline, Shape};
    /// let outline = Outline::new([0.0, 0.0]).line([1.0, 0.0]).curve([1.0, 1.0], [0.0, 1.0]);
    /// assert!(Shape::Extrusion { outline, half_depth: 0.1 }.check().is_ok());
    /// ```
    pub fn new(start: [f32; 2]) -> Self {
        Self {
            start,
            pieces: Vec::new(),
        }
    }

    /// A line from where it ends, to a point.
    #[must_use]
    pub fn line(mut self, to: [f32; 2]) -> Self {
        self.pieces.push(Piece { control: None, to });
        self
    }

    /// A quadratic Bézier curve from where it ends, by a control point, to a point.
    #[must_use]
    pub fn curve(mut self, control: [f32; 2], to: [f32; 2]) -> Self {
        let control = Some(control);
        self.pieces.push(Piece { control, to });
        self
    }

    /// The corners of a box around the outline: that of its points and control points.
    pub fn bounds(&self) -> (Vec2, Vec2) {
        let points = self
            .segments()
            .flat_map(|(a, b, c)| [a, b.unwrap_or(c), c])
            .map(Vec2::from);
        points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(lo, hi), p| {
            (lo.min(p), hi.max(p))
        })
    }

    /// Start, control and end point of each piece, the closing line included; a line has no control point.
    pub fn segments(&self) -> impl Iterator<Item = ([f32; 2], Option<[f32; 2]>, [f32; 2])> + '_ {
        let mut at = self.start;
        let closing = Piece {
            control: None,
            to: self.start,
        };
        self.pieces
            .iter()
            .copied()
            .chain([closing])
            .filter_map(move |piece| {
                let from = std::mem::replace(&mut at, piece.to);
                (from != piece.to || piece.control.is_some()).then_some((
                    from,
                    piece.control,
                    piece.to,
                ))
            })
    }
}

/// How far to trust a shape's distance, divided by its Lipschitz constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exactness {
    /// The Euclidean distance, inside and outside.
    Exact,
    /// Never more than the Euclidean distance; the surface itself is right.
    Bound,
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
            grid: MeshGrid::default(),
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
            grid: MeshGrid::default(),
        }
    }

    /// Sampled distances, under a name of one's own. [Saving](crate::Scene::save) the scene writes them beside it, as `name.grid`.
    pub fn sampled(name: impl AsRef<str>, grid: SampledGrid) -> Self {
        Self::Mesh {
            path: format!("{}.grid", name.as_ref()),
            resolution: mesh_resolution(),
            grid: MeshGrid(Some(Arc::new(grid))),
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
    pub fn file(&self) -> Option<(&str, u32, &MeshGrid)> {
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
    pub fn file_mut(&mut self) -> Option<(&mut String, &mut u32, &mut MeshGrid)> {
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
