//! The table of shapes: one row defines a shape.
//!
//! A row has parameters with units, checks and defaults; a rule between parameters; the words that both
//! interpreters read; the box of the solid; whether the distance is Euclidean; and an example. From a row follow
//! [`Shape`](crate::Shape) with its file format, schema, validation and box; the opcode, the packing and the
//! dispatch of both interpreters in `argil-field`; the editor's gallery; and the first tests. Written by hand are
//! the distance function (`argil-field/src/shapes.rs`), its WGSL twin, and its definition for the oracle
//! (`naive/shapes.rs`).
//!
//! Shapes are `plain` or `searched`. A plain shape has a fixed number of words and is evaluated point by point. A
//! searched shape looks for the nearest of many points, in blocks of points, and has any number of words.
//!
//! *Length.* One row per shape.

/// Calls a macro with all rows, after the tokens of a second argument.
#[doc(hidden)]
#[macro_export]
macro_rules! shape_table {
    ($with:ident) => {
        $with! {
            plain {
                /// Sphere around the origin.
                Sphere(sd_sphere) {
                    /// Radius.
                    radius: f32 => positive,
                }
                words([radius])
                bounds(enclosing_sphere_box(radius))
                exact(true)
                example(Some(Shape::sphere(0.5)));

                /// Ellipsoid around the origin.
                Ellipsoid(sd_ellipsoid) {
                    /// Semi-axes.
                    radii: [f32; 3] => positive,
                }
                words({
                    let r = Vec3::from(radii);
                    let [a, b, c] = radii;
                    let [x, y, z] = r.recip().to_array();
                    [a, b, c, x, y, z, r.min_element(), r.max_element()]
                })
                bounds(Aabb::centered(radii.into()))
                exact(false)
                example(Some(Shape::Ellipsoid { radii: [0.6, 0.35, 0.45] }));

                /// Box around the origin. The rounding lies within the half size.
                Box(sd_box) {
                    /// Half the length of each side. Along a side of 1e6 or more, the box is infinite.
                    half_size: [f32; 3] => positive,
                    /// Radius of edges and corners.
                    #[serde(default)]
                    rounding: f32 => not_negative,
                }
                rule(at_most("rounding", rounding, least(half_size), "the least half size"))
                words({
                    let [x, y, z] = half_size;
                    [x - rounding, y - rounding, z - rounding, rounding]
                })
                bounds(endless(Aabb::centered(half_size.into())))
                exact(true)
                example(Some(Shape::rounded_box([0.45, 0.45, 0.45], 0.05)));

                /// The twelve edges of a box, as beams.
                BoxFrame(sd_box_frame) {
                    /// Half the length of each side.
                    half_size: [f32; 3] => positive,
                    /// Half the width of a beam.
                    #[serde(alias = "thickness")]
                    half_thickness: f32 => positive,
                }
                rule(at_most("half_thickness", half_thickness, least(half_size), "the least half size"))
                words({
                    let [x, y, z] = half_size;
                    [x, y, z, half_thickness]
                })
                bounds(Aabb::centered(half_size.into()))
                // Beams overlap, and the minimum of two inner distances is only a bound.
                exact(false)
                example(Some(Shape::BoxFrame { half_size: [0.45, 0.45, 0.45], half_thickness: 0.06 }));

                /// Torus about the y axis.
                Torus(sd_torus) {
                    /// Distance from the center to the middle of the tube.
                    major_radius: f32 => positive,
                    /// Radius of the tube.
                    minor_radius: f32 => positive,
                }
                words([major_radius, minor_radius])
                bounds(upright(major_radius + minor_radius, -minor_radius, minor_radius))
                exact(true)
                example(Some(Shape::torus(0.4, 0.15)));

                /// Arc of a torus about the z axis, centered on +y, with round ends.
                CappedTorus(sd_capped_torus) {
                    /// Distance from the center to the middle of the tube.
                    major_radius: f32 => positive,
                    /// Radius of the tube.
                    minor_radius: f32 => positive,
                    /// Half of the arc's angle in degrees, up to 180.
                    half_angle_degrees: f32 => within(0.1, 180.0),
                }
                words({
                    let (sin, cos) = half_angle_degrees.to_radians().sin_cos();
                    [sin, cos, major_radius, minor_radius]
                })
                bounds(along_z(Vec2::splat(major_radius + minor_radius), minor_radius))
                exact(true)
                example(Some(Shape::CappedTorus {
                    major_radius: 0.4,
                    minor_radius: 0.12,
                    half_angle_degrees: 120.0,
                }));

                /// Chain link along y.
                Link(sd_link) {
                    /// Half the length of the straight part.
                    half_length: f32 => not_negative,
                    /// Distance from the center of a bend to the middle of the wire.
                    major_radius: f32 => positive,
                    /// Radius of the wire.
                    minor_radius: f32 => positive,
                }
                words([half_length, major_radius, minor_radius])
                bounds({
                    let r = major_radius + minor_radius;
                    along_z(Vec2::new(r, half_length + r), minor_radius)
                })
                exact(true)
                example(Some(Shape::Link { half_length: 0.25, major_radius: 0.25, minor_radius: 0.1 }));

                /// Sphere swept from one point to another.
                Capsule(sd_capsule) {
                    /// One end of the axis.
                    from: [f32; 3] => coordinate,
                    /// The other end of the axis.
                    to: [f32; 3] => coordinate,
                    /// Radius.
                    radius: f32 => positive,
                }
                words({
                    let axis = Vec3::from(to) - Vec3::from(from);
                    let squared = axis.length_squared();
                    let reciprocal = if squared > 0.0 { 1.0 / squared } else { 0.0 };
                    let [x, y, z] = from;
                    [x, y, z, axis.x, axis.y, axis.z, reciprocal, radius]
                })
                bounds(Aabb::around([from.into(), to.into()]).grown(radius))
                exact(true)
                example(Some(Shape::capsule([0.0, -0.35, 0.0], [0.0, 0.35, 0.0], 0.2)));

                /// Cylinder about y. The rounding lies within radius and height.
                Cylinder(sd_cylinder) {
                    /// Radius.
                    radius: f32 => positive,
                    /// Half of the height. A cylinder of 1e6 or more is infinite.
                    half_height: f32 => positive,
                    /// Radius of the rims.
                    #[serde(default)]
                    rounding: f32 => not_negative,
                }
                rule({
                    let limit = radius.min(half_height);
                    at_most("rounding", rounding, limit, "the lesser of radius and half height")
                })
                words([radius - rounding, half_height - rounding, rounding])
                bounds(endless(upright(radius, -half_height, half_height)))
                exact(true)
                example(Some(Shape::Cylinder { radius: 0.4, half_height: 0.45, rounding: 0.03 }));

                /// Cone about y, with its tip at the origin and its base at y = −height.
                Cone(sd_cone) {
                    /// Radius of the base.
                    radius: f32 => positive,
                    /// Distance from base to tip.
                    height: f32 => positive,
                }
                words([radius, height, 1.0 / (radius * radius + height * height)])
                bounds(upright(radius, -height, 0.0))
                exact(true)
                example(Some(Shape::Cone { radius: 0.45, height: 0.9 }));

                /// Truncated cone about y, centered on the origin.
                CappedCone(sd_capped_cone) {
                    /// Half of the height.
                    half_height: f32 => positive,
                    /// Radius at the bottom.
                    bottom_radius: f32 => not_negative,
                    /// Radius at the top.
                    top_radius: f32 => not_negative,
                }
                rule(if bottom_radius.max(top_radius) < 1e-6 {
                    Err(ValidationError::new("bottom_radius", "both radii are 0: one must be positive"))
                } else {
                    Ok(())
                })
                words({
                    // The side runs down from the top rim: (slope, −2 · half height).
                    let slope = bottom_radius - top_radius;
                    let side = 1.0 / (slope * slope + 4.0 * half_height * half_height);
                    [half_height, bottom_radius, top_radius, -slope, side]
                })
                bounds(upright(bottom_radius.max(top_radius), -half_height, half_height))
                exact(true)
                example(Some(Shape::CappedCone { half_height: 0.4, bottom_radius: 0.45, top_radius: 0.2 }));

                /// Convex hull of two spheres on the y axis, at the origin and at y = height.
                RoundCone(sd_round_cone) {
                    /// Radius of the sphere at the origin.
                    bottom_radius: f32 => positive,
                    /// Radius of the sphere at the top.
                    top_radius: f32 => positive,
                    /// Distance between the centers, which must exceed the difference of the radii.
                    height: f32 => positive,
                }
                rule({
                    let least = (bottom_radius - top_radius).abs();
                    if height <= least * 1.0001 {
                        let reason = format!("{height} is not more than the radii differ by, {least}");
                        Err(ValidationError::new("height", reason))
                    } else {
                        Ok(())
                    }
                })
                words({
                    let sine = (bottom_radius - top_radius) / height;
                    let cosine = (1.0 - sine * sine).sqrt();
                    [bottom_radius, top_radius, height, sine, cosine]
                })
                bounds(upright(bottom_radius.max(top_radius), -bottom_radius, height + top_radius))
                exact(true)
                example(Some(Shape::RoundCone { bottom_radius: 0.35, top_radius: 0.15, height: 0.5 }));

                /// Half space: the points p with p · normal ≤ offset. It is infinite: volumes of a scene with a plane
                /// end at the view's bounds or, without bounds, at a box around the finite brushes and the plane, if
                /// it is parallel to two axes.
                Plane(sd_plane) {
                    /// Direction out of the solid, of any length but 0.
                    normal: [f32; 3] => coordinate,
                    /// Position of the surface along the unit normal.
                    #[serde(default)]
                    offset: f32 => coordinate,
                }
                rule(if Vec3::from(normal).length() < 1e-6 {
                    Err(ValidationError::new("normal", "[0, 0, 0] has no direction"))
                } else {
                    Ok(())
                })
                words({
                    let n = Vec3::from(normal).normalize();
                    [n.x, n.y, n.z, offset]
                })
                bounds(half_space(Vec3::from(normal), offset))
                exact(true)
                example(Some(Shape::Plane { normal: [0.0, 1.0, 0.0], offset: 0.0 }));

                /// Hexagonal prism along z, with flat sides at the top and bottom.
                HexPrism(sd_hex_prism) {
                    /// Distance from the center to the middle of a side.
                    apothem: f32 => positive,
                    /// Half of the length along z.
                    half_depth: f32 => positive,
                }
                words([apothem, half_depth])
                bounds(endless(along_z(Vec2::new(apothem * 2.0 / 3f32.sqrt(), apothem), half_depth)))
                exact(true)
                example(Some(Shape::HexPrism { apothem: 0.4, half_depth: 0.25 }));

                /// Prism along z over an equilateral triangle that points up.
                TriPrism(sd_tri_prism) {
                    /// Half of the triangle's side.
                    half_side: f32 => positive,
                    /// Half of the length along z.
                    half_depth: f32 => positive,
                }
                words([half_side, half_depth])
                bounds({
                    let below = half_side / 3f32.sqrt();
                    Aabb::new(
                        Vec3::new(-half_side, -below, -half_depth),
                        Vec3::new(half_side, 2.0 * below, half_depth),
                    )
                })
                exact(true)
                example(Some(Shape::TriPrism { half_side: 0.45, half_depth: 0.25 }));

                /// Regular octahedron with its vertices on the axes.
                Octahedron(sd_octahedron) {
                    /// Distance from the center to a vertex.
                    radius: f32 => positive,
                }
                words([radius])
                bounds(enclosing_sphere_box(radius))
                exact(true)
                example(Some(Shape::Octahedron { radius: 0.55 }));

                /// Pyramid over a square at y = 0.
                Pyramid(sd_pyramid) {
                    /// Side of the square.
                    base: f32 => positive,
                    /// Distance from the base to the tip.
                    height: f32 => positive,
                }
                words({
                    let half = 0.5 * base;
                    let slope = half.hypot(height);
                    [half, height, slope, half / slope, height / slope]
                })
                bounds(upright(0.5 * base, 0.0, height))
                exact(true)
                example(Some(Shape::Pyramid { base: 0.8, height: 0.7 }));

                /// The part of a sphere above y = cut.
                CutSphere(sd_cut_sphere) {
                    /// Radius of the sphere.
                    radius: f32 => positive,
                    /// Height of the cut, between −radius and radius.
                    cut: f32 => coordinate,
                }
                rule(cut_inside_sphere(radius, cut))
                words([radius, cut, rim_radius(radius, cut)])
                bounds(upright(if cut > 0.0 { rim_radius(radius, cut) } else { radius }, cut, radius))
                exact(true)
                example(Some(Shape::CutSphere { radius: 0.5, cut: 0.1 }));

                /// The shell of a sphere below y = cut, with a round rim.
                CutHollowSphere(sd_cut_hollow_sphere) {
                    /// Radius of the sphere.
                    radius: f32 => positive,
                    /// Height of the cut, between −radius and radius.
                    cut: f32 => coordinate,
                    /// Half of the shell's thickness.
                    #[serde(alias = "thickness")]
                    half_thickness: f32 => positive,
                }
                rule(cut_inside_sphere(radius, cut))
                words([radius, cut, rim_radius(radius, cut), half_thickness])
                bounds({
                    let widest = if cut < 0.0 { rim_radius(radius, cut) } else { radius };
                    upright(widest, -radius, cut).grown(half_thickness)
                })
                exact(true)
                example(Some(Shape::CutHollowSphere { radius: 0.5, cut: 0.1, half_thickness: 0.04 }));

                /// The part of a sphere within an angle around +y.
                SolidAngle(sd_solid_angle) {
                    /// Radius of the sphere.
                    radius: f32 => positive,
                    /// Half of the opening angle in degrees, below 180.
                    half_angle_degrees: f32 => within(0.1, 179.9),
                }
                words({
                    let (sin, cos) = half_angle_degrees.to_radians().sin_cos();
                    [sin, cos, radius]
                })
                bounds({
                    let (sin, cos) = half_angle_degrees.to_radians().sin_cos();
                    let widest = if cos > 0.0 { radius * sin } else { radius };
                    upright(widest, (radius * cos).min(0.0), radius)
                })
                exact(true)
                example(Some(Shape::SolidAngle { radius: 0.6, half_angle_degrees: 35.0 }));

                /// Rhombus in the x–z plane, extruded along y. The rounding is added outside.
                Rhombus(sd_rhombus) {
                    /// Half of the diagonal along x.
                    half_length_x: f32 => positive,
                    /// Half of the diagonal along z.
                    half_length_z: f32 => positive,
                    /// Half of the height.
                    half_height: f32 => positive,
                    /// Radius of edges.
                    #[serde(default)]
                    rounding: f32 => not_negative,
                }
                words({
                    let (x, z) = (half_length_x, half_length_z);
                    [x, z, half_height, rounding, 1.0 / (x * x + z * z)]
                })
                bounds(Aabb::centered(Vec3::new(half_length_x, half_height, half_length_z)).grown(rounding))
                exact(true)
                example(Some(Shape::Rhombus {
                    half_length_x: 0.5,
                    half_length_z: 0.3,
                    half_height: 0.15,
                    rounding: 0.02,
                }));

                /// Box with a radius for each of its four upright edges, and with rounded rims, all within the half
                /// size.
                ExtrudedRoundedBox(sd_extruded_rounded_box) {
                    /// Half the length of each side.
                    half_size: [f32; 3] => positive,
                    /// Radii of the upright edges at (+x, +z), (+x, −z), (−x, +z), (−x, −z).
                    corner_radii: [f32; 4] => not_negative,
                    /// Radius of the rim at the top, and at the bottom.
                    #[serde(default)]
                    rounding: [f32; 2] => not_negative,
                }
                rule({
                    let flat = half_size[0].min(half_size[2]) * 1.000_001;
                    let low = least(half_size) * 1.000_001;
                    each_at_most("corner_radii", corner_radii, flat, "the lesser half size in x and z")
                        .and_then(|()| each_at_most("rounding", rounding, low, "the least half size"))
                })
                words({
                    let ([x, y, z], [a, b, c, d], [top, bottom]) = (half_size, corner_radii, rounding);
                    [x, y, z, a, b, c, d, top, bottom]
                })
                bounds(endless(Aabb::centered(half_size.into())))
                // A rim that is rounder than an upright edge cuts that edge's corner, where the path's distance
                // is too small.
                exact({
                    let sharpest = corner_radii.into_iter().fold(f32::INFINITY, f32::min);
                    rounding.into_iter().all(|r| r <= sharpest)
                })
                example(Some(Shape::ExtrudedRoundedBox {
                    half_size: [0.45, 0.3, 0.45],
                    corner_radii: [0.3, 0.1, 0.3, 0.1],
                    rounding: [0.05, 0.05],
                }));

                /// Sheet along a gyroid, sin x cos y + sin y cos z + sin z cos x = 0, in a box.
                Gyroid(sd_gyroid) {
                    /// Half the length of each side of the box, at most a hundred periods.
                    half_size: [f32; 3] => positive,
                    /// Length after which it repeats.
                    period: f32 => positive,
                    /// Thickness of the sheet where it is thinnest; elsewhere it is up to 1.23 times as thick. At
                    /// most 0.27 periods, beyond which the box would be solid.
                    thickness: f32 => positive,
                }
                rule(sheet_in_box(half_size, period, thickness, 0.27))
                words(sheet_words(half_size, period, thickness))
                bounds(Aabb::centered(half_size.into()))
                exact(false)
                example(Some(Shape::Gyroid { half_size: [0.45; 3], period: 0.6, thickness: 0.06 }));

                /// Sheet along Schwarz's P surface, cos x + cos y + cos z = 0, in a box.
                SchwarzP(sd_schwarz_p) {
                    /// Half the length of each side of the box, at most a hundred periods.
                    half_size: [f32; 3] => positive,
                    /// Length after which it repeats.
                    period: f32 => positive,
                    /// Thickness of the sheet where it is thinnest; elsewhere it is up to √3 times as thick. At
                    /// most half of the period, beyond which the box would be solid.
                    thickness: f32 => positive,
                }
                rule(sheet_in_box(half_size, period, thickness, 0.5))
                words(sheet_words(half_size, period, thickness))
                bounds(Aabb::centered(half_size.into()))
                exact(false)
                example(Some(Shape::SchwarzP { half_size: [0.45; 3], period: 0.45, thickness: 0.04 }));

                /// Superellipsoid around the origin: ((|x/a|ᵐ + |z/c|ᵐ)ⁿᐟᵐ + |y/b|ⁿ)¹ᐟⁿ = 1 with semi-axes a, b and
                /// c.
                Superellipsoid(sd_superellipsoid) {
                    /// Semi-axes.
                    radii: [f32; 3] => positive,
                    /// Exponents n of upright sections and m of level ones, each from 1 to 16: 1 gives straight
                    /// sides between the axes, 2 gives ellipses, and large values approach a box.
                    exponents: [f32; 2] => within(1.0, 16.0),
                }
                words(superellipsoid_words(radii, exponents))
                bounds(Aabb::centered(radii.into()))
                exact(false)
                example(Some(Shape::Superellipsoid { radii: [0.55, 0.4, 0.45], exponents: [2.5, 5.0] }));
            }
            searched {
                /// Sphere swept along a quadratic Bézier curve, while its radius changes linearly with the curve's
                /// parameter.
                BezierTube(sd_bezier_tube, bezier_tube_loops) {
                    /// Start of the curve.
                    from: [f32; 3] => coordinate,
                    /// Control point of the curve.
                    control: [f32; 3] => coordinate,
                    /// End of the curve.
                    to: [f32; 3] => coordinate,
                    /// Radius at the start.
                    from_radius: f32 => positive,
                    /// Radius at the end.
                    to_radius: f32 => positive,
                }
                words(tube_words([from, control, to], [from_radius, to_radius]))
                // The curve lies in the hull of its three points.
                bounds({
                    let hull = Aabb::around([from.into(), control.into(), to.into()]);
                    hull.grown(from_radius.max(to_radius))
                })
                exact(false)
                example(Some(Shape::BezierTube {
                    from: [-0.5, -0.3, 0.0],
                    control: [0.0, 0.9, 0.0],
                    to: [0.5, -0.3, 0.0],
                    from_radius: 0.15,
                    to_radius: 0.06,
                }));

                /// Sphere swept along a smooth curve through points, while its radius changes from each point to
                /// the next. Between two points, the curve is two quadratic Bézier curves. Its tangent at a point
                /// is parallel to the line between the neighbors, after Catmull and Rom.
                SplineTube(sd_spline_tube, spline_tube_loops) {
                    /// The points, from 2 to 128, in order.
                    points: Vec<SplinePoint> => spline,
                }
                words(spline_words(points))
                bounds(spline_bounds(points))
                exact(false)
                example(Some(Shape::SplineTube {
                    points: vec![
                        SplinePoint::new([-0.5, -0.35, 0.0], 0.12),
                        SplinePoint::new([-0.2, 0.3, 0.1], 0.09),
                        SplinePoint::new([0.15, -0.2, -0.1], 0.11),
                        SplinePoint::new([0.5, 0.35, 0.0], 0.05),
                    ],
                }));

                /// Path revolved about the y axis. The path's x is the distance from the axis.
                Lathe(sd_lathe, outline_loops) {
                    /// The path, at x ≥ 0.
                    outline: Path2 => outline,
                }
                rule(beside_axis(outline))
                words(outline_words(outline, 0.0, true))
                bounds({
                    let (min, max) = outline.bounds();
                    upright(max.x, min.y, max.y)
                })
                exact(true)
                example(Some(Shape::Lathe {
                    outline: Path2::new([0.0, -0.5])
                        .line([0.3, -0.5])
                        .curve([0.5, -0.1], [0.2, 0.2])
                        .line([0.3, 0.5])
                        .line([0.0, 0.5]),
                }));

                /// Path in the x–y plane, extruded along z.
                Extrusion(sd_extrusion, outline_loops) {
                    /// The path.
                    outline: Path2 => outline,
                    /// Half of the length along z. An extrusion of 1e6 or more is infinite.
                    half_depth: f32 => positive,
                }
                words(outline_words(outline, half_depth, false))
                bounds({
                    let (min, max) = outline.bounds();
                    endless(Aabb::new(min.extend(-half_depth), max.extend(half_depth)))
                })
                exact(true)
                example(Some(Shape::Extrusion {
                    outline: Path2::new([-0.45, -0.4])
                        .line([0.45, -0.4])
                        .line([0.1, 0.0])
                        .curve([0.4, 0.5], [-0.45, 0.4]),
                    half_depth: 0.15,
                }));

                /// Letters in the x–y plane, extruded along z. The first line stands on the x axis, and each line
                /// is centered.
                Text(sd_extrusion, outline_loops) {
                    /// The text, up to 64 characters, in lines.
                    text: String => letters,
                    /// The font size: the distance between lines. Capital letters are about 0.7 times as high.
                    size: f32 => positive,
                    /// Half of the length along z.
                    half_depth: f32 => positive,
                }
                words(text_words(text, size, half_depth))
                bounds(text_bounds(text, size, half_depth))
                exact(true)
                example(Some(Shape::Text { text: "Ag".into(), size: 0.9, half_depth: 0.1 }));

                /// The solid of a mesh file. It is sampled when the scene is loaded, and holes are closed.
                Mesh(sd_sampled, sampled_loops) {
                    /// An OBJ, GLB, PLY, STL or 3MF file, a volume (.vdb, .nvdb, .npy, .nrrd), or a .grid file of sampled
                    /// distances, relative to the scene's file.
                    path: String => mesh_path,
                    /// Samples along the longest side of its box, from 16 to 512. A volume keeps its own.
                    #[serde(default = "mesh_resolution")]
                    resolution: u32 => mesh_resolution,
                    /// Its samples, once it is loaded.
                    #[serde(skip)]
                    grid: LoadedGrid => distances,
                }
                // Lowering reports a grid that is not loaded.
                words(grid.words())
                // Samples differ from the distance, and beyond all of them it is a lower bound.
                bounds(grid.solid())
                exact(false)
                example(None);

                /// Ground from a grayscale image. Black is at y = 0.
                Heightmap(sd_heightmap, sampled_loops) {
                    /// A PNG image, relative to the scene's file. 16 bits make smooth ground. Its rows run along x,
                    /// and the first row is at −z.
                    path: String => image_path,
                    /// Half of the lengths along x and z.
                    half_size: [f32; 2] => positive,
                    /// Height of white.
                    height: f32 => positive,
                    /// Thickness of the ground where the image is black. The flat bottom is at y = −base.
                    #[serde(default = "base")]
                    base: f32 => positive,
                    /// Posts along the image's longer side, from 16 to 2048, if it has as many pixels.
                    #[serde(default = "posts")]
                    resolution: u32 => post_count,
                    /// Its heights, once it is loaded.
                    #[serde(skip)]
                    grid: LoadedGrid => heights,
                }
                // Lowering reports a grid that is not loaded.
                words(heightmap_words(grid.words(), half_size, [height, base]))
                bounds(heightmap_bounds(grid, half_size, [height, base]))
                exact(false)
                example(None);
            }
        }
    };
}
