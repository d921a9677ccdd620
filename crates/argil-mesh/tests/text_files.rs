//! OBJ, STL and PLY files as other programs write them.

use argil_abi::GpuMaterial;
use argil_mesh::{Mesh, MeshFile, MeshFormat, MeshReport, MeshWriteOptions, from_bytes, write};
use std::path::Path;

fn read(bytes: &[u8], format: MeshFormat) -> Result<MeshFile, String> {
    from_bytes(bytes, format, Path::new("a")).map_err(|error| error.to_string())
}

fn fault(bytes: &[u8], format: MeshFormat) -> String {
    read(bytes, format).expect_err("a fault")
}

/// Returns a mesh, of a file that has no warning.
fn plain(bytes: &[u8], format: MeshFormat) -> Mesh {
    let file = read(bytes, format).unwrap_or_else(|error| panic!("{error}"));
    assert!(file.warnings.is_empty(), "{:?}", file.warnings);
    file.mesh
}

fn volume(mesh: &Mesh) -> f64 {
    MeshReport::of(&mesh.welded()).volume
}

/// Corners of a U of height 1 around a notch, and its caps as one concave polygon each.
const U: [[i32; 2]; 8] = [
    [0, 0],
    [3, 0],
    [3, 3],
    [2, 3],
    [2, 1],
    [1, 1],
    [1, 3],
    [0, 3],
];

fn u_prism(start: usize) -> (Vec<[i32; 3]>, Vec<Vec<usize>>) {
    let corners = (0..2).flat_map(|z| U.map(|[x, y]| [x, y, z])).collect();
    let cap = |z: usize| (0..8).map(move |i| 8 * z + (i + start) % 8);
    let mut faces = vec![cap(0).rev().collect::<Vec<_>>(), cap(1).collect()];
    faces.extend((0..8).map(|i| vec![i, (i + 1) % 8, 8 + (i + 1) % 8, 8 + i]));
    (corners, faces)
}

#[test]
fn concave_polygons_of_files_keep_their_notches() {
    for start in 0..8 {
        let (corners, faces) = u_prism(start);
        let join = |all: Vec<String>| all.join(" ");
        let mut obj = String::new();
        let mut ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 16\nproperty int x\nproperty int y\nproperty int z\n\
             element face {}\nproperty list uchar int vertex_index\nend_header\n",
            faces.len()
        );
        for [x, y, z] in &corners {
            obj += &format!("v {x} {y} {z}\n");
            ply += &format!("{x} {y} {z}\n");
        }
        for face in &faces {
            let from = |base: usize| join(face.iter().map(|i| (i + base).to_string()).collect());
            obj += &format!("f {}\n", from(1));
            ply += &format!("{} {}\n", face.len(), from(0));
        }
        for (text, format) in [(obj, MeshFormat::Obj), (ply, MeshFormat::Ply)] {
            let mesh = plain(text.as_bytes(), format);
            let report = MeshReport::of(&mesh);
            assert!(report.is_watertight(), "{format:?} {report:?}");
            let is_right = (report.volume - 7.0).abs() < 1e-6 && (report.area - 30.0).abs() < 1e-6;
            assert!(is_right, "{format:?} {start} {report:?}");
        }
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn objs_of_other_programs_are_read() {
    let expected = plain(format!("{TRIANGLE}f 1 2 3\n").as_bytes(), MeshFormat::Obj);
    let returns = format!("{TRIANGLE}f 1 2 3\n").replace('\n', "\r");
    let pairs = format!("{TRIANGLE}f 1 2 3\n").replace('\n', "\r\n");
    for text in [
        &format!("{TRIANGLE}f 1 2 3 # a side\n")[..],
        &format!("{TRIANGLE}f 1 2 3#a side\n"),
        &format!("{TRIANGLE}f -3 -2 -1\n"),
        &format!("{TRIANGLE}f 1/1/1 2/2/2 3//3\n"),
        &format!("{TRIANGLE}fo 1 2 3\n"),
        &format!("{TRIANGLE}f 1 \\\n2 3\n"),
        &format!("# C:\\work\\\n{TRIANGLE}# in D:\\\nf 1 2 3\n"),
        &format!("mtllib C:\\work\\\n{TRIANGLE}o D:\\\nf 1 2 3\n"),
        &format!("f 1 2 3\n{TRIANGLE}"),
        &format!("usemtl\nusemtl \nmtllib\ng\no\ns off\n{TRIANGLE}f 1 2 3"),
        "v 0 0 0 # p\nv 1 0 0 1 0 0\nv 0 1 0 1\nf 1 2 3\n",
        "\u{feff}v 0 0 0\n\n  v\t1 0 0\nv 0 1 0\nf 1 2 3\n",
        &returns,
        &pairs,
    ] {
        assert_eq!(plain(text.as_bytes(), MeshFormat::Obj), expected, "{text}");
    }
    let latin = [
        b"# caf\xe9\no Stra\xdfe\n",
        TRIANGLE.as_bytes(),
        b"f 1 2 3\n",
    ]
    .concat();
    assert_eq!(plain(&latin, MeshFormat::Obj), expected);
}

#[test]
fn objs_name_what_is_not_a_surface() {
    let text = format!(
        "{TRIANGLE}l 1 2 3\nl 3 2 1\np 1\ncstype bezier\ncurv 0 1 1 2 3\nsurf 0 1 0 1 1 2 3\nend\ncall other.obj\n\
         facet 1 2 3\nf 1 2\nf 1 2 3\n"
    );
    let file = read(text.as_bytes(), MeshFormat::Obj).expect("a mesh");
    assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
    let said = file.warnings.join("\n");
    for part in [
        "2 lines",
        "1 point element:",
        "1 free-form curve:",
        "1 free-form surface:",
        "1 reference to another file",
        "line 12: \"facet 1 2 3\"",
        "fewer than three corners",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let curves = fault(format!("{TRIANGLE}l 1 2 3\n").as_bytes(), MeshFormat::Obj);
    assert!(curves.contains("1 line:"), "{curves}");
}

#[test]
fn damaged_objs_name_the_line() {
    for face in ["f 1 2 4", "f 1 2 -4", "f 0 1 2", "f 1 2 x"] {
        let text = format!("{TRIANGLE}f 1 2 3\n{face}\n");
        let found = fault(text.as_bytes(), MeshFormat::Obj);
        assert!(found.ends_with(&format!("line 5: \"{face}\"")), "{found}");
    }
    let found = fault(b"v 0 0 0\nv 1 x 0\nf 1 2 3\n", MeshFormat::Obj);
    assert!(found.ends_with("line 2: \"v 1 x 0\""), "{found}");
    assert!(fault(b"v 0 0 0\0\x01", MeshFormat::Obj).contains("not text"));
    let wide: Vec<u8> = "v 0 0 0"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let marked = [&[0xff, 0xfe], &wide[..]].concat();
    assert!(fault(&marked, MeshFormat::Obj).contains("UTF-16"));
}

/// The corners of a tetrahedron's triangles, moved along x.
fn tetrahedron(x: f32) -> Vec<[[f32; 3]; 3]> {
    let corners = [
        [x, 0.0, 0.0],
        [x + 1.0, 0.0, 0.0],
        [x, 1.0, 0.0],
        [x, 0.0, 1.0],
    ];
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    triangles.map(|t| t.map(|i: usize| corners[i])).to_vec()
}

fn ascii_stl(name: &str, triangles: &[[[f32; 3]; 3]]) -> String {
    let mut text = format!("solid{name}\n");
    for triangle in triangles {
        text += " facet normal 0 0 1\n  outer loop\n";
        for [x, y, z] in triangle {
            text += &format!("   vertex {x} {y} {z:e}\n");
        }
        text += "  endloop\n endfacet\n";
    }
    text + &format!("endsolid{name}\n")
}

fn binary_stl(header: &[u8], count: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([7, 9]);
    }
    bytes
}

#[test]
fn all_solids_of_an_stl_arrive() {
    let one = ascii_stl(" a", &tetrahedron(0.0));
    let two = ascii_stl(" b", &tetrahedron(5.0));
    let mesh = plain(format!("{one}{two}").as_bytes(), MeshFormat::Stl);
    assert_eq!((mesh.triangles.len(), mesh.aabb().max.x), (8, 6.0));
    let empty = "solid nothing\nendsolid nothing\n";
    let mesh = plain(format!("{empty}{two}{empty}").as_bytes(), MeshFormat::Stl);
    assert_eq!(mesh.triangles.len(), 4);
    // Binary files, one after the other.
    let blocks = [0.0, 5.0].map(|x| binary_stl(b"one", 4, &tetrahedron(x)));
    let mesh = plain(&blocks.concat(), MeshFormat::Stl);
    assert_eq!((mesh.triangles.len(), mesh.aabb().max.x), (8, 6.0));
}

#[test]
fn ascii_stls_of_other_programs_are_read() {
    let text = ascii_stl(" cube", &tetrahedron(0.0));
    let expected = plain(text.as_bytes(), MeshFormat::Stl);
    assert!((volume(&expected) - 1.0 / 6.0).abs() < 1e-6);
    for (from, to) in [
        ("normal 0 0 1", "normal NaN NaN nan"),
        ("normal 0 0 1", "normal inf -inf 0"),
        ("normal 0 0 1", "normal -1.#IND 1.#INF -1.#QNAN"),
        ("normal 0 0 1", "normal"),
        ("solid cube", "solid"),
        ("solid cube", "solid\tcube"),
        ("solid cube", "solid vertex facet, the second"),
        ("solid cube\n f", "\n \n  solid cube\n f"),
        ("solid cube\n f", "\u{feff}solid cube\n f"),
        (
            "solid cube\n f",
            "; made by hand\nsolid cube\n; color 1 0 0\n# b\n// c\n f",
        ),
        ("solid cube\n f", "solid cube  f"),
        ("\n", "\r"),
        ("\n", "\r\n"),
    ] {
        let odd = text.replace(from, to);
        assert_ne!(odd, text);
        assert_eq!(plain(odd.as_bytes(), MeshFormat::Stl), expected, "{odd}");
    }
    let upper = plain(text.to_uppercase().as_bytes(), MeshFormat::Stl);
    assert_eq!(upper, expected);
    let latin = text.replace("cube", "caf*").into_bytes();
    let latin: Vec<u8> = latin
        .iter()
        .map(|&b| if b == b'*' { 0xe9 } else { b })
        .collect();
    assert_eq!(plain(&latin, MeshFormat::Stl), expected);
    let open = read(
        text.replace("endsolid cube\n", "").as_bytes(),
        MeshFormat::Stl,
    )
    .expect("a mesh");
    assert!(open.mesh == expected && open.warnings[0].contains("no end"));
    let cut = &text[..text.len() - 30];
    assert!(fault(cut.as_bytes(), MeshFormat::Stl).contains("truncated"));
    let bad = text.replace("vertex 1 0", "vertex 1 zero");
    assert!(fault(bad.as_bytes(), MeshFormat::Stl).contains("line 6: \"vertex 1 zero"));
}

/// The length decides, not the header.
#[test]
fn binary_stls_may_begin_with_solid() {
    let ten = [tetrahedron(0.0), tetrahedron(2.0), tetrahedron(4.0)].concat();
    let expected = plain(&binary_stl(b"", 10, &ten[..10]), MeshFormat::Stl);
    for header in [&b"solid part"[..], b"solid\nfacet normal", b"solid \xe9\r"] {
        assert_eq!(
            plain(&binary_stl(header, 10, &ten[..10]), MeshFormat::Stl),
            expected
        );
    }
    let mut longer = binary_stl(b"part", 10, &ten[..10]);
    longer.extend(b"and a comment");
    let longer = read(&longer, MeshFormat::Stl).expect("a mesh");
    assert!(
        longer.mesh == expected && longer.warnings[0].contains("13 bytes"),
        "{:?}",
        longer.warnings
    );
    let mut solid = binary_stl(b"solid part", 10, &ten[..10]);
    solid.extend(b"and a comment");
    assert!(read(&solid, MeshFormat::Stl).is_ok_and(|file| file.mesh == expected));
    let uncounted = read(&binary_stl(b"part", 0, &ten[..10]), MeshFormat::Stl).expect("a mesh");
    assert!(uncounted.mesh == expected && uncounted.warnings[0].contains("10 follow"));
    let cut = fault(&binary_stl(b"part", 11, &ten[..10]), MeshFormat::Stl);
    assert!(
        cut.contains("announces 11") && cut.contains("for 10"),
        "{cut}"
    );
}

fn ply(encoding: &str, faces: &str) -> String {
    format!(
        "ply\nformat {encoding} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{faces}end_header\n"
    )
}

const FACE: &str = "element face 1\nproperty list uchar int vertex_indices\n";

#[test]
fn plys_of_other_programs_are_read() {
    let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let whole = ply("ascii", FACE) + body;
    let expected = plain(whole.as_bytes(), MeshFormat::Ply);
    let commented = whole.replace("element face", "comment caf*\nobj_info * x\n\nelement face");
    let latin: Vec<u8> = commented
        .bytes()
        .map(|b| if b == b'*' { 0xe9 } else { b })
        .collect();
    for odd in [
        latin,
        whole.replace("1 0 0\n", "\n1 0 0\n\n").into_bytes(),
        whole.replace('\n', "\r\n").into_bytes(),
        whole.replace('\n', "\r").into_bytes(),
        whole.replace("vertex_indices", "vertex_index").into_bytes(),
        whole
            .replace("float", "double")
            .replace("int vertex", "uint16 vertex")
            .into_bytes(),
        whole.replace("1 0 0\n", "1 0\n0\n").into_bytes(),
        whole
            .replace(
                "element vertex",
                "comment by\nanother program\nelement vertex",
            )
            .into_bytes(),
        format!("{whole}\n \n").into_bytes(),
    ] {
        assert_eq!(
            plain(&odd, MeshFormat::Ply),
            expected,
            "{}",
            String::from_utf8_lossy(&odd)
        );
    }
    // More numbers than the header declares.
    let long = read(
        whole.replace("1 0 0\n", "1 0 0 5\n").as_bytes(),
        MeshFormat::Ply,
    )
    .expect("a mesh");
    assert!(
        long.mesh == expected && long.warnings[0].contains("line 11"),
        "{:?}",
        long.warnings
    );
    // Faces before vertices, and properties that are not needed.
    let other = "ply\nformat ascii 1.0\nelement face 1\nproperty uchar flags\nproperty list uchar float uv\n\
        property list uchar uint vertex_indices\nelement vertex 3\nproperty float z\nproperty uchar red\n\
        property float y\nproperty float x\nend_header\n9 2 0.5 0.5 3 0 1 2\n0 7 0 0\n0 7 0 1\n0 7 1 0\n";
    assert_eq!(plain(other.as_bytes(), MeshFormat::Ply), expected);
}

#[test]
fn binary_plys_are_read_in_both_orders() {
    let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let expected = plain((ply("ascii", FACE) + body).as_bytes(), MeshFormat::Ply);
    let corners = [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let little = corners.iter().flat_map(|n| n.to_le_bytes());
    let little = little
        .chain([3])
        .chain([0i32, 1, 2].into_iter().flat_map(i32::to_le_bytes));
    let big = corners.iter().flat_map(|n| n.to_be_bytes());
    let big = big
        .chain([3])
        .chain([0i32, 1, 2].into_iter().flat_map(i32::to_be_bytes));
    let bodies = [
        ("binary_little_endian", little.collect::<Vec<u8>>()),
        ("binary_big_endian", big.collect()),
    ];
    for (encoding, body) in bodies {
        for end in ["\n", "\r\n", "\r"] {
            let header = ply(encoding, FACE).replace('\n', end).into_bytes();
            let whole = [header, body.clone()].concat();
            assert_eq!(
                plain(&whole, MeshFormat::Ply),
                expected,
                "{encoding} {end:?}"
            );
            let cut = fault(&whole[..whole.len() - 1], MeshFormat::Ply);
            assert!(cut.contains("truncated"), "{cut}");
        }
    }
}

#[test]
fn strips_and_edges_of_plys() {
    let strips = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nelement edge 1\nproperty int vertex1\n\
        property int vertex2\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n8 0 1 2 3 -1 0 2 4\n0 1\n";
    let file = read(strips.as_bytes(), MeshFormat::Ply).expect("a mesh");
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [2, 1, 3], [0, 2, 4]]);
    assert!(
        file.warnings[0].contains("1 of its \"edge\""),
        "{:?}",
        file.warnings
    );
    // Vertices of no triangle are left out.
    let ring = format!("v 9 9 9\n{TRIANGLE}v 9 9 9\nl 1 5\nf 2 3 4\n");
    let file = read(ring.as_bytes(), MeshFormat::Obj).expect("a mesh");
    assert_eq!(
        (file.mesh.positions.len(), file.mesh.aabb().max.x),
        (3, 1.0)
    );
    let points = fault(
        (ply("ascii", "") + "0 0 0\n1 0 0\n0 1 0\n").as_bytes(),
        MeshFormat::Ply,
    );
    assert!(points.contains("cloud of 3 points"), "{points}");
}

#[test]
fn damaged_plys_name_the_place() {
    let bad = ply("ascii", FACE) + "0 0 0\n1 a 0\n0 1 0\n3 0 1 2\n";
    assert!(fault(bad.as_bytes(), MeshFormat::Ply).contains("line 11: \"1 a 0\""));
    let short = ply("ascii", FACE) + "0 0 0\n";
    assert!(fault(short.as_bytes(), MeshFormat::Ply).contains("truncated"));
    let far = ply("ascii", FACE) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n";
    assert!(fault(far.as_bytes(), MeshFormat::Ply).contains("missing vertex"));
    let longer = ply("ascii", FACE) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n\n3 0 2 1\n";
    let file = read(longer.as_bytes(), MeshFormat::Ply).expect("a mesh");
    assert!(
        file.warnings[0].contains("first at line 15"),
        "{:?}",
        file.warnings
    );
    let odd = ply("ascii", &FACE.replace("indices", "list")) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    assert!(fault(odd.as_bytes(), MeshFormat::Ply).contains("\"vertex_indices\""));
    let flat = ply("ascii", FACE).replace("property float z\n", "");
    assert!(fault(flat.as_bytes(), MeshFormat::Ply).contains("x, y and z"));
    let many = ply(
        "binary_little_endian",
        "element face 4000000000\nproperty list uchar int vertex_indices\n",
    );
    assert!(
        fault((many + &"0".repeat(36)).as_bytes(), MeshFormat::Ply).contains("4000000000 times")
    );
}

/// Vertex colors are sRGB in all files: half of the light is 0.735 or 188 of 255.
#[test]
fn vertex_colors_are_srgb() {
    let material = GpuMaterial {
        base_roughness: [0.5, 1.0, 0.001, 0.3],
        ..GpuMaterial::default()
    };
    let mut mesh = plain(format!("{TRIANGLE}f 1 2 3\n").as_bytes(), MeshFormat::Obj);
    mesh.materials = vec![material; 3];
    let bytes = |format| {
        let mut bytes = Vec::new();
        write(&mesh, format, &MeshWriteOptions::default(), &mut bytes).expect("a file");
        bytes
    };
    let obj = String::from_utf8(bytes(MeshFormat::Obj)).expect("text");
    assert!(obj.contains("v 1 0 0 0.7354 1.0000 0.0129\n"), "{obj}");
    let ply = bytes(MeshFormat::Ply);
    assert!(ply.windows(3).any(|rgb| rgb == [188, 255, 3]));
}
