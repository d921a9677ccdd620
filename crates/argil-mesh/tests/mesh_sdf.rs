//! Tests distances to triangles: against the shape that they came from, and for meshes that are not solids.
//!
//! *Length.* A test for each kind of mesh that is no solid, with the meshes that they share.

use argil_field::{Grid, Program};
use argil_mesh::marching::dense;
use argil_mesh::{
    Mesh, MeshFormat, MeshReadError, MeshReport, MeshSdf, MeshWriteOptions, from_bytes, repair,
    thicken, write,
};
use argil_scene::{Brush, DistanceSampler, LoadedGrid, SampledBlock, Scene, Shape};
use glam::Vec3;
use std::path::Path;
use std::sync::Arc;

fn field(p: Vec3) -> f32 {
    let ring = glam::vec2(glam::vec2(p.x, p.z).length() - 0.5, p.y).length() - 0.2;
    ring.min(p.distance(Vec3::new(0.9, 0.0, 0.0)) - 0.25)
}

/// Extracts triangles of a field at a resolution.
fn mesh(n: u32) -> Mesh {
    let grid = Grid::spanning(Vec3::splat(-1.2), Vec3::splat(1.2), n);
    let at = |i: u32, axis: usize| grid.min[axis] + grid.spacing[axis] * i as f32;
    let d: Vec<f32> = (0..n.pow(3))
        .map(|i| field(Vec3::new(at(i % n, 0), at(i / n % n, 1), at(i / n / n, 2))))
        .collect();
    dense::march(&d, &grid, 0.0, false)
}

fn points() -> Vec<Vec3> {
    let mut state = 7u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..3000)
        .map(|_| Vec3::new(number(), number(), number()))
        .collect()
}

/// Computes the distance by testing every triangle, and the sign by summing all solid angles.
fn slow(mesh: &Mesh, p: Vec3) -> f64 {
    let (mut best, mut turns) = (f64::INFINITY, 0.0);
    for i in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.triangle_vertices(i).map(|c| (c - p).as_dvec3());
        let n = (b - a).cross(c - a);
        let within = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(u, v)| (v - u).cross(n).dot(-u) <= 0.0);
        let side = |u: glam::DVec3, v: glam::DVec3| {
            let t = ((-u).dot(v - u) / (v - u).length_squared()).clamp(0.0, 1.0);
            (u + (v - u) * t).length()
        };
        let d = if within {
            a.dot(n.normalize()).abs()
        } else {
            side(a, b).min(side(b, c)).min(side(c, a))
        };
        best = best.min(d);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        turns += 2.0 * a.dot(b.cross(c)).atan2(under);
    }
    if turns > std::f64::consts::TAU {
        -best
    } else {
        best
    }
}

#[test]
fn the_tree_equals_brute_force() {
    let mesh = mesh(24);
    let solid = MeshSdf::new(&mesh).expect("a solid");
    let points = points();
    let mut d = vec![0.0; points.len()];
    solid.distances(&points, &mut d);
    for (&p, &d) in points.iter().zip(&d) {
        let right = slow(&mesh, p);
        assert!(
            (f64::from(d) - right).abs() < 1e-5,
            "{d} and {right} at {p}"
        );
        // One by one, without the point before.
        assert!((solid.distance(p) - d).abs() < 1e-6);
    }
}

#[test]
fn flipped_split_and_open_meshes_come_out_solid() {
    let whole = mesh(40);
    let solid = MeshSdf::new(&whole).expect("a solid");
    let points = points();
    let mut right = vec![0.0; points.len()];
    solid.distances(&points, &mut right);
    let same = |mesh: &Mesh, tolerance: f32| {
        let solid = MeshSdf::new(mesh).expect("a solid");
        let mut d = vec![0.0; points.len()];
        solid.distances(&points, &mut d);
        for ((&a, &b), p) in right.iter().zip(&d).zip(&points) {
            assert!((a - b).abs() <= tolerance, "{a} and {b} at {p}");
        }
        *solid.repairs()
    };

    // Inside out as a whole; here and there; with corners of its own for each triangle, as STL has it.
    let mut turned = whole.clone();
    turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert!(same(&turned, 1e-6).parts_flipped > 0);
    let mut some = whole.clone();
    some.triangles
        .iter_mut()
        .step_by(7)
        .for_each(|t| t.swap(1, 2));
    assert!(same(&some, 1e-6).flipped > 100);
    let unshared = whole.unindexed(false);
    assert!(same(&unshared, 1e-6).welded > 1000);

    // Without a patch of triangles.
    let mut open = whole.clone();
    let far = Vec3::new(0.0, 0.2, -0.5);
    open.triangles.retain(|t| {
        t.iter()
            .all(|&i| whole.positions[i as usize].distance(far) > 0.08)
    });
    assert!(!MeshReport::of(&open).is_watertight());
    let repairs = same(&open, 0.02);
    assert_eq!(repairs.holes, 1);
    let (closed, _) = repair(&open);
    assert!(MeshReport::of(&closed).is_watertight());
}

#[test]
fn a_cavity_stays_hollow_and_crossing_parts_are_one_solid() {
    let ball = |radius: f32, at: Vec3, inwards: bool| {
        let grid = Grid::spanning(Vec3::splat(-1.2), Vec3::splat(1.2), 30);
        let n = 30;
        let place = |i: u32, axis: usize| grid.min[axis] + grid.spacing[axis] * i as f32;
        let d: Vec<f32> = (0..27_000u32)
            .map(|i| {
                Vec3::new(place(i % n, 0), place(i / n % n, 1), place(i / n / n, 2)).distance(at)
                    - radius
            })
            .collect();
        let mut mesh = dense::march(&d, &grid, 0.0, false);
        if inwards {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        mesh
    };
    let joined = |mut a: Mesh, b: Mesh| {
        let base = a.positions.len() as u32;
        a.positions.extend(b.positions);
        a.triangles
            .extend(b.triangles.iter().map(|t| t.map(|i| base + i)));
        MeshSdf::new(&a).expect("a solid")
    };
    let hollow = joined(ball(0.9, Vec3::ZERO, false), ball(0.5, Vec3::ZERO, true));
    assert!(hollow.distance(Vec3::ZERO) > 0.45 && hollow.distance(Vec3::X * 0.7) < -0.15);
    // A part that is turned over and lies in no other is not a cavity.
    let both = joined(
        ball(0.4, Vec3::X * 0.25, false),
        ball(0.4, Vec3::X * -0.25, true),
    );
    for x in [-0.5, 0.0, 0.5] {
        assert!(both.distance(Vec3::X * x) < 0.0, "{x}");
    }
    assert_eq!(both.repairs().parts_flipped, 1);
}

#[test]
fn samples_follow_the_triangles() {
    let mesh = mesh(60);
    let solid = MeshSdf::new(&mesh).expect("a solid");
    let grid = solid.sample(96).expect("an inside");
    assert!(grid.lipschitz() <= 1.74, "{}", grid.lipschitz());
    let spacing = grid.spacing();
    let mut scene = Scene::new();
    let shape = Shape::Mesh {
        path: "ring.obj".into(),
        resolution: 96,
        grid: LoadedGrid(Some(Arc::new(grid))),
    };
    scene.push(Brush::new(shape)).expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    for p in points() {
        let (d, right) = (program.distance(p), solid.distance(p));
        assert_eq!(
            d < 0.0 && right < -0.6 * spacing,
            right < -0.6 * spacing,
            "{d} {right} at {p}"
        );
        assert!(
            d.signum() == right.signum() || right.abs() < 0.6 * spacing,
            "{d} {right} at {p}"
        );
        if right.abs() < spacing {
            assert!((d - right).abs() < 0.6 * spacing, "{d} {right} at {p}");
        }
    }
}

#[test]
fn files_come_back_as_they_were_written() {
    let mesh = mesh(30);
    let written = MeshReport::of(&mesh);
    for format in [
        MeshFormat::Glb,
        MeshFormat::Gltf,
        MeshFormat::Obj,
        MeshFormat::Ply,
        MeshFormat::Stl,
        MeshFormat::ThreeMf,
    ] {
        let mut bytes = Vec::new();
        write(&mesh, format, &MeshWriteOptions::default(), &mut bytes).expect("a file");
        let back = from_bytes(&bytes, format, Path::new("mesh"))
            .expect("a mesh")
            .mesh
            .welded();
        let report = MeshReport::of(&back);
        assert!(report.is_watertight(), "{format:?} {report:?}");
        assert_eq!(
            (
                report.vertices,
                report.triangles,
                report.euler_characteristic
            ),
            (
                written.vertices,
                written.triangles,
                written.euler_characteristic
            )
        );
        assert!((report.volume - written.volume).abs() < 1e-6, "{format:?}");

        // Cut short anywhere: an error or a smaller mesh, never a panic.
        for cut in (0..bytes.len()).step_by(bytes.len() / 97 + 1) {
            let _ = from_bytes(&bytes[..cut], format, Path::new("mesh"));
        }
        // Damaged anywhere.
        for at in (0..bytes.len()).step_by(bytes.len() / 211 + 1) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x55;
            let _ = from_bytes(&damaged, format, Path::new("mesh"))
                .map(|file| MeshSdf::new(&file.mesh).map(|s| s.triangles()));
        }
    }
}

#[test]
fn axes_and_units() {
    use argil_mesh::UpAxis;
    let mesh = mesh(20);
    for axes in [
        UpAxis::YUp,
        UpAxis::ZUp,
        UpAxis::YUpLeftHanded,
        UpAxis::ZUpLeftHanded,
    ] {
        let options = MeshWriteOptions { axes, scale: 100.0 };
        let mut bytes = Vec::new();
        write(&mesh, MeshFormat::Ply, &options, &mut bytes).expect("a file");
        let back = from_bytes(&bytes, MeshFormat::Ply, Path::new("mesh")).expect("a mesh");
        let back = back.mesh;
        let volume = MeshReport::of(&back).volume;
        // The cross product of two sides points out.
        assert!(
            (volume / (MeshReport::of(&mesh).volume * 1e6) - 1.0).abs() < 1e-4,
            "{axes:?} {volume}"
        );
        let first = axes.convert(mesh.positions[0]) * 100.0;
        assert!(back.positions[0].distance(first) < 1e-3);
    }
}

#[test]
fn files_that_are_not_meshes_are_refused() {
    let nothing = from_bytes(b"", MeshFormat::Obj, Path::new("empty.obj"))
        .map(|file| MeshSdf::new(&file.mesh).map(|_| ()));
    assert!(matches!(
        nothing,
        Ok(Err(MeshReadError::NoTriangles)) | Err(_)
    ));
    let flat = b"v 0 0 0\nv 1 0 0\nv 2 0 0\nv nan 0 1\nf 1 2 3\nf 1 2 4\n";
    let flat = from_bytes(flat, MeshFormat::Obj, Path::new("flat.obj")).expect("a mesh");
    assert!(matches!(
        MeshSdf::new(&flat.mesh),
        Err(MeshReadError::NoTriangles)
    ));
    for format in [
        MeshFormat::Glb,
        MeshFormat::Ply,
        MeshFormat::Stl,
        MeshFormat::ThreeMf,
    ] {
        let error = from_bytes(b"solid nonsense", format, Path::new("x"))
            .map(|file| file.mesh.triangles.len());
        assert!(!matches!(error, Ok(1..)), "{format:?} {error:?}");
    }
    let beyond = from_bytes(
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
        MeshFormat::Obj,
        Path::new("x.obj"),
    );
    assert!(beyond.is_err());
}

/// A ring, and needles that are thinner than the distance between samples.
#[test]
fn blocks_of_samples_are_exact() {
    let mut mesh = mesh(60);
    for k in 0..40 {
        let turn = 0.7 * k as f32;
        let foot = Vec3::new(turn.cos(), 0.3 * turn.sin(), turn.sin()) * 0.8;
        let tip = foot + 0.1 * Vec3::new((3.0 * turn).sin(), turn.cos(), 0.3);
        let first = mesh.positions.len() as u32;
        let side = 0.004 * Vec3::new(1.0, -0.5, 0.2);
        let other = 0.004 * Vec3::new(0.3, 0.8, -0.4);
        mesh.positions
            .extend([foot, foot + side, foot + other, tip]);
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        mesh.triangles
            .extend(faces.map(|t: [u32; 3]| t.map(|i| first + i)));
    }
    let solid = MeshSdf::new(&mesh).expect("a solid");
    let step = 0.02;
    for p in points().into_iter().take(150) {
        let first = p - 4.0 * step;
        let corner = |c: usize| {
            let at = glam::uvec3(c as u32 & 1, c as u32 >> 1 & 1, c as u32 >> 2);
            solid.distance(first + 8.0 * step * at.as_vec3())
        };
        let block = SampledBlock {
            first,
            step,
            corners: std::array::from_fn(corner),
        };
        let mut samples = vec![0.0; 729];
        solid.sample_block(&block, &mut samples);
        for (i, &d) in samples.iter().enumerate() {
            let right = solid.distance(block.position(i));
            assert!((d - right).abs() < 1e-6, "{d} {right}");
        }
    }
}

/// Builds a GLB file of one tetrahedron, with changed JSON.
fn glb_with(change: impl Fn(&mut serde_json::Value)) -> Result<Mesh, MeshReadError> {
    let tetrahedron = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        ..Mesh::default()
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    write(
        &tetrahedron,
        MeshFormat::Glb,
        &MeshWriteOptions::default(),
        &mut bytes,
    )
    .expect("a file");
    let file = gltf::binary::Glb::from_slice(bytes.get_ref()).expect("a GLB");
    let mut root: serde_json::Value = serde_json::from_slice(&file.json).expect("JSON");
    change(&mut root);
    let changed = gltf::binary::Glb {
        json: serde_json::to_vec(&root).expect("JSON").into(),
        ..file
    };
    let bytes = changed.to_vec().expect("a GLB");
    from_bytes(&bytes, MeshFormat::Glb, Path::new("changed.glb")).map(|file| file.mesh)
}

#[test]
fn senseless_glbs_are_refused_and_end() {
    use serde_json::json;
    assert_eq!(glb_with(|_| {}).map(|m| m.triangles.len()).ok(), Some(4));
    let damaged = |change: &dyn Fn(&mut serde_json::Value)| {
        let found = glb_with(change).map(|mesh| mesh.triangles.len());
        assert!(
            matches!(found, Err(MeshReadError::Damaged { .. })),
            "{found:?}"
        );
    };
    // Nodes in a circle, or twice.
    damaged(&|root| root["nodes"][0]["children"] = json!([0]));
    damaged(&|root| {
        root["nodes"] = json!([{ "children": [1, 1] }, { "mesh": 0 }]);
    });
    let accessors = |root: &serde_json::Value| {
        let primitive = &root["meshes"][0]["primitives"][0];
        let of = |value: &serde_json::Value| value.as_u64().expect("an index") as usize;
        [
            of(&primitive["attributes"]["POSITION"]),
            of(&primitive["indices"]),
        ]
    };
    for (which, key, value) in [
        (0, "type", json!("VEC2")),
        (0, "count", json!(4_000_000_000_u64)),
        (0, "byteOffset", json!(1_000_000)),
        (0, "byteOffset", json!(u64::MAX)),
        (1, "componentType", json!(5126)),
        (1, "type", json!("VEC3")),
    ] {
        damaged(&|root| {
            let at = accessors(root)[which];
            root["accessors"][at][key] = value.clone();
        });
    }
    damaged(&|root| {
        let at = accessors(root)[0];
        let view = root["accessors"][at]["bufferView"]
            .as_u64()
            .expect("a view") as usize;
        root["bufferViews"][view]["byteStride"] = json!(4);
    });
    damaged(&|root| {
        let at = accessors(root)[0];
        let view = root["accessors"][at]["bufferView"]
            .as_u64()
            .expect("a view") as usize;
        root["bufferViews"][view]["byteOffset"] = json!(1_000_000);
    });
}

#[test]
fn surfaces_with_two_sides_come_out_solid() {
    let whole = mesh(40);
    let solid = MeshSdf::new(&whole).expect("a solid");
    for turned in [false, true] {
        let mut both = whole.clone();
        let again = whole
            .triangles
            .iter()
            .map(|&[a, b, c]| if turned { [a, c, b] } else { [b, c, a] });
        both.triangles.extend(again);
        let doubled = MeshSdf::new(&both).expect("a solid");
        assert_eq!(doubled.triangles(), whole.triangles.len());
        assert_eq!(doubled.repairs().parts, solid.repairs().parts);
        for p in points().into_iter().take(500) {
            assert!(
                (doubled.distance(p) - solid.distance(p)).abs() < 1e-6,
                "{p}"
            );
        }
    }
}

#[test]
fn meshes_without_a_volume_are_refused() {
    let square = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    assert!(matches!(
        MeshSdf::new(&square),
        Err(MeshReadError::Sheets { size: 1.0 })
    ));
    // A sheet beside a solid is left out, and told; with a thickness it is a wall.
    let mut both = mesh(30);
    let base = both.positions.len() as u32;
    let moved = square.positions.iter().map(|p| *p + 2.0 * Vec3::Y);
    both.positions.extend(moved);
    let sheet = square.triangles.iter().map(|t| t.map(|i| base + i));
    both.triangles.extend(sheet);
    let solid = MeshSdf::new(&both).expect("a solid");
    assert_eq!(solid.repairs().sheets, 1);
    assert!(solid.aabb().max.y < 2.0, "{:?}", solid.aabb());
    assert_eq!(solid.repairs().sheet_box, [0.0, 2.0, 0.0, 1.0, 3.0, 0.0]);
    assert!(solid.distance(Vec3::new(0.5, 2.5, 0.0)) > 1.0);
    assert!(solid.repairs().warnings()[0].contains("[0, 2, 0] to [1, 3, 0]"));
    let (walls, parts) = thicken(&both, 0.1);
    assert_eq!(parts, 1);
    assert!(MeshReport::of(&walls).is_watertight());
    let solid = MeshSdf::new(&walls).expect("a solid");
    assert_eq!((solid.repairs().sheets, solid.repairs().holes), (0, 0));
    let d = solid.distance(Vec3::new(0.5, 2.5, 0.0));
    assert!((d + 0.05).abs() < 1e-4, "{d}");
    // Corners that are no numbers are counted.
    let mut odd = mesh(20);
    let triangles = odd.triangles.iter().filter(|t| t.contains(&7)).count() as u64;
    odd.positions[7].y = f32::NAN;
    let solid = MeshSdf::new(&odd).expect("a solid");
    assert_eq!(solid.repairs().not_finite, triangles);
    assert!(solid.repairs().warnings()[0].contains("not finite"));
    for scale in [1e-30, 1e-6, 1e7, 1e30, 3e38] {
        let mut scaled = mesh(20);
        scaled.positions.iter_mut().for_each(|p| *p *= scale);
        let found = MeshSdf::new(&scaled).map(|solid| solid.triangles());
        assert!(found.is_err(), "{scale}: {found:?}");
    }
    for scale in [1e-3, 1e4] {
        let mut scaled = mesh(20);
        scaled.positions.iter_mut().for_each(|p| *p *= scale);
        let solid = MeshSdf::new(&scaled).expect("a solid");
        let d = solid.distance(Vec3::X * (0.5 * scale)) / scale;
        assert!((d + 0.2).abs() < 0.02, "{scale}: {d}");
    }
    let mut away = mesh(20);
    away.positions.iter_mut().for_each(|p| p.x += 1e6);
    assert!(matches!(
        MeshSdf::new(&away),
        Err(MeshReadError::Extent { .. })
    ));
}

/// A part inside another part does not affect distances, because it is not a surface of the solid.
#[test]
fn nested_and_overlapping_parts_are_one_solid() {
    let sphere = |radius: f32, at: Vec3| {
        let n = 40;
        let grid = Grid::spanning(Vec3::splat(-1.2), Vec3::splat(1.2), n);
        let place = |i: u32, axis: usize| grid.min[axis] + grid.spacing[axis] * i as f32;
        let d: Vec<f32> = (0..n.pow(3))
            .map(|i| {
                let p = Vec3::new(place(i % n, 0), place(i / n % n, 1), place(i / n / n, 2));
                p.length() - radius
            })
            .collect();
        let mut mesh = dense::march(&d, &grid, 0.0, false);
        mesh.positions.iter_mut().for_each(|p| *p += at);
        mesh
    };
    let both = |one: Mesh, other: Mesh| {
        let base = one.positions.len() as u32;
        let more = other.triangles.iter().map(|t| t.map(|i| base + i));
        Mesh {
            positions: [one.positions, other.positions].concat(),
            triangles: one.triangles.iter().copied().chain(more).collect(),
            ..Mesh::default()
        }
    };
    let nested = both(sphere(1.0, Vec3::ZERO), sphere(0.5, Vec3::ZERO));
    let solid = MeshSdf::new(&nested).expect("a solid");
    for (p, expected) in [(0.0, -1.0), (0.4, -0.6), (0.6, -0.4), (1.5, 0.5)] {
        let d = solid.distance(p * Vec3::X);
        assert!((d - expected).abs() < 0.01, "{p}: {d}");
    }
    let crossing = both(sphere(0.8, Vec3::ZERO), sphere(0.8, 0.8 * Vec3::X));
    let solid = MeshSdf::new(&crossing).expect("a solid");
    // From the middle of the first, the second's sheet was the nearest before.
    for (p, expected) in [(Vec3::ZERO, -0.8), (Vec3::new(0.3, 0.0, 0.0), -0.747)] {
        let d = solid.distance(p);
        assert!((d - expected).abs() < 0.06, "{p}: {d}");
    }
    // A cavity stays one.
    let mut inner = sphere(0.5, Vec3::ZERO);
    inner.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let hollow = MeshSdf::new(&both(sphere(1.0, Vec3::ZERO), inner)).expect("a solid");
    assert!((hollow.distance(Vec3::ZERO) - 0.5).abs() < 0.01);
    assert!((hollow.distance(0.75 * Vec3::X) + 0.25).abs() < 0.01);
}

/// Compressed files are refused by name.
#[test]
fn compressed_files_are_named() {
    let json = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"]}  "#;
    let json = &json.as_bytes()[..json.len() / 4 * 4];
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((20 + json.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json);
    let text = from_bytes(&glb, MeshFormat::Glb, Path::new("a.glb"))
        .expect_err("a fault")
        .to_string();
    assert!(
        text.contains("Draco") && !text.contains("damaged"),
        "{text}"
    );
}

/// Another library reads what is written.
#[test]
fn written_gltf_is_read_by_another_library() {
    let mesh = mesh(12);
    for format in [MeshFormat::Gltf, MeshFormat::Glb] {
        let mut bytes = Vec::new();
        write(&mesh, format, &MeshWriteOptions::default(), &mut bytes).expect("a file");
        let read = gltf::Gltf::from_slice(&bytes).expect("glTF");
        let counts: Vec<usize> = read.accessors().map(|accessor| accessor.count()).collect();
        let expected = [mesh.positions.len(), 3 * mesh.triangles.len()];
        assert!(
            expected.iter().all(|count| counts.contains(count)),
            "{counts:?}"
        );
    }
}
