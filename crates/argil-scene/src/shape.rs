use crate::SampledGrid;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

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
pub enum Shape {
    /// Ball around the origin.
    Sphere {
        /// Radius.
        radius: f32,
    },
    /// Ellipsoid around the origin.
    Ellipsoid {
        /// Half axes.
        radii: [f32; 3],
    },
    /// Box around the origin; the rounding lies within the half size.
    Box {
        /// Half of each side.
        half_size: [f32; 3],
        /// Radius of edges and corners.
        #[serde(default)]
        rounding: f32,
    },
    /// The twelve edges of a box, as beams.
    BoxFrame {
        /// Half of each side.
        half_size: [f32; 3],
        /// Half of a beam's width.
        thickness: f32,
    },
    /// Ring about the y axis.
    Torus {
        /// From the centre to the middle of the tube.
        major_radius: f32,
        /// Of the tube.
        minor_radius: f32,
    },
    /// Arc of a ring about the z axis, its middle on +y, with round ends.
    CappedTorus {
        /// From the centre to the middle of the tube.
        major_radius: f32,
        /// Of the tube.
        minor_radius: f32,
        /// Half of the angle that the arc covers, in degrees, up to 180.
        half_angle_degrees: f32,
    },
    /// Chain link along y.
    Link {
        /// Half of the straight part.
        half_length: f32,
        /// From the middle to the middle of the wire.
        major_radius: f32,
        /// Of the wire.
        minor_radius: f32,
    },
    /// Ball swept from one point to another.
    Capsule {
        /// One end of the axis.
        from: [f32; 3],
        /// The other end.
        to: [f32; 3],
        /// Radius.
        radius: f32,
    },
    /// Cylinder about y; the rounding lies within radius and height.
    Cylinder {
        /// Radius.
        radius: f32,
        /// Half of the height.
        half_height: f32,
        /// Radius of the rims.
        #[serde(default)]
        rounding: f32,
    },
    /// Cone about y, its tip at the origin and its base at y = −height.
    Cone {
        /// Radius of the base.
        radius: f32,
        /// From base to tip.
        height: f32,
    },
    /// Cone about y without its tip, centred.
    CappedCone {
        /// Half of the height.
        half_height: f32,
        /// Radius at the bottom.
        bottom_radius: f32,
        /// Radius at the top.
        top_radius: f32,
    },
    /// Hull of two balls on the y axis: one at the origin, one at y = height.
    RoundCone {
        /// Radius of the ball at the origin.
        bottom_radius: f32,
        /// Radius of the ball at the top.
        top_radius: f32,
        /// Between the centres; more than the radii differ by.
        height: f32,
    },
    /// Half space: the points p with p · normal ≤ offset.
    Plane {
        /// Direction out of the solid; any length but 0.
        normal: [f32; 3],
        /// Where along the unit normal the surface is.
        #[serde(default)]
        offset: f32,
    },
    /// Hexagonal prism along z with flat sides up and down.
    HexPrism {
        /// From the centre to the middle of a side.
        apothem: f32,
        /// Half of the length along z.
        half_depth: f32,
    },
    /// Prism along z over an equilateral triangle that points up.
    TriPrism {
        /// Half of the triangle's side.
        half_side: f32,
        /// Half of the length along z.
        half_depth: f32,
    },
    /// Regular octahedron with its corners on the axes.
    Octahedron {
        /// From the centre to a corner.
        radius: f32,
    },
    /// Pyramid over a square at y = 0.
    Pyramid {
        /// Side of the square.
        base: f32,
        /// From the base to the tip.
        height: f32,
    },
    /// The part of a ball above y = cut.
    CutSphere {
        /// Radius of the ball.
        radius: f32,
        /// Height of the cut, between −radius and radius.
        cut: f32,
    },
    /// The shell of a ball below y = cut, with a round rim.
    CutHollowSphere {
        /// Radius of the ball.
        radius: f32,
        /// Height of the cut, between −radius and radius.
        cut: f32,
        /// Half of the shell's thickness.
        thickness: f32,
    },
    /// The part of a ball within an angle around +y.
    SolidAngle {
        /// Radius of the ball.
        radius: f32,
        /// Half of the opening angle in degrees, below 180.
        half_angle_degrees: f32,
    },
    /// Rhombus in the x–z plane, extruded along y; the rounding is added outside.
    Rhombus {
        /// Half diagonal along x.
        half_length_x: f32,
        /// Half diagonal along z.
        half_length_z: f32,
        /// Half of the height.
        half_height: f32,
        /// Radius of edges.
        #[serde(default)]
        rounding: f32,
    },
    /// Box whose four upright edges each have a radius of their own, and whose rims are rounded; all within the half size.
    ExtrudedRoundedBox {
        /// Half of each side.
        half_size: [f32; 3],
        /// Radii of the upright edges at (+x, +z), (+x, −z), (−x, +z), (−x, −z).
        corner_radii: [f32; 4],
        /// Radius of the rim at the top, then at the bottom.
        #[serde(default)]
        rounding: [f32; 2],
    },
    /// Ball swept along a quadratic Bézier curve while its radius changes linearly with the curve's parameter.
    BezierTube {
        /// Where the curve starts.
        from: [f32; 3],
        /// Its control point.
        control: [f32; 3],
        /// Where it ends.
        to: [f32; 3],
        /// Radius at the start.
        from_radius: f32,
        /// Radius at the end.
        to_radius: f32,
    },
    /// Outline turned about the y axis: its x is the distance from the axis.
    Lathe {
        /// The outline, at x ≥ 0.
        outline: Outline,
    },
    /// Outline in the x–y plane, extruded along z.
    Extrusion {
        /// The outline.
        outline: Outline,
        /// Half of the length along z.
        half_depth: f32,
    },
    /// Triangles of a file, as a solid: sampled when the scene is loaded, holes closed.
    Mesh {
        /// An OBJ, GLB, PLY or STL file; relative to the scene's.
        path: String,
        /// Samples along the longest side of its box, from 16 to 512.
        #[serde(default = "mesh_resolution")]
        resolution: u32,
        /// Its distances, once it is loaded.
        #[serde(skip)]
        grid: MeshGrid,
    },
}

/// The distances of a mesh, where it is loaded. Any two are equal: what they are follows from the file's name.
#[derive(Clone, Debug, Default)]
pub struct MeshGrid(pub Option<Arc<SampledGrid>>);

impl PartialEq for MeshGrid {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

fn mesh_resolution() -> u32 {
    128
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
    /// Whether the distance is Euclidean or a lower bound of it.
    pub fn exactness(&self) -> Exactness {
        match *self {
            // The box frame's beams overlap, and the minimum of two inner distances is a bound; a tube's and an
            // outline's curves are searched, the ellipsoid has no closed form.
            Self::Ellipsoid { .. }
            | Self::BoxFrame { .. }
            | Self::BezierTube { .. }
            | Self::Mesh { .. } => Exactness::Bound,
            // A rim rounder than an upright edge cuts that edge's corner, where the outline's distance is too small.
            Self::ExtrudedRoundedBox {
                corner_radii,
                rounding,
                ..
            } => {
                let sharpest = corner_radii.into_iter().fold(f32::INFINITY, f32::min);
                if rounding.into_iter().all(|r| r <= sharpest) {
                    Exactness::Exact
                } else {
                    Exactness::Bound
                }
            }
            _ => Exactness::Exact,
        }
    }

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
