//! Files to begin with, made by the writers where there are some.

use argil::scene::{Scene, Shape};
use argil::{
    BricksOptions, DenseOptions, Engine, ExportFormat, ExportOptions, OctreeOptions, Representation,
};
use argil_mesh::{Mesh, MeshFormat, MeshWriteOptions, write};
use glam::Vec3;
use std::io::Cursor;
use std::path::Path;

fn tetrahedron() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        ..Mesh::default()
    }
}

/// Returns a mesh in one format.
pub(crate) fn meshes(format: MeshFormat) -> Vec<Vec<u8>> {
    let mut bytes = Vec::new();
    let written = write(
        &tetrahedron(),
        format,
        &MeshWriteOptions::default(),
        &mut bytes,
    );
    written.expect("a mesh can be written");
    vec![bytes]
}

fn texts(all: &[&str]) -> Vec<Vec<u8>> {
    all.iter().map(|text| text.as_bytes().to_vec()).collect()
}

pub(crate) fn gltf() -> Vec<Vec<u8>> {
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=";
    let buffer = format!(
        r#""buffers":[{{"uri":"data:application/octet-stream;base64,{data}","byteLength":44}}]"#
    );
    let text = |rest: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":6}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],{rest},{buffer}}}"#
        )
    };
    let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4}]}]"#;
    let plain = text(&format!(
        r#""nodes":[{{"mesh":0,"children":[1]}},{{"mesh":0,"scale":[2,-1,1]}}],{mesh}"#
    ));
    let many = text(&format!(
        r#""nodes":[{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":0}}}}}}}}],{mesh},"extensionsRequired":["EXT_mesh_gpu_instancing"]"#
    ));
    let sparse = plain.replacen(
        r#""bufferView":0,"componentType":5126,"#,
        r#""componentType":5126,"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":0}},"#,
        1,
    );
    let packed = plain.replacen(
        r#"{"buffer":0,"byteLength":36}"#,
        r#"{"buffer":0,"byteLength":36,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":36,"byteStride":12,"count":3,"mode":"ATTRIBUTES","filter":"NONE"}}}"#,
        1,
    );
    let mut all = meshes(MeshFormat::Gltf);
    all.extend([plain, many, sparse, packed].map(String::into_bytes));
    all
}

pub(crate) fn obj() -> Vec<Vec<u8>> {
    let mut all = texts(&[
        "# a\nv 0 0 0 1 0 0\nv 3 0 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0.1\nv 1 3 0\nv 0 3 0\nf 1/1 2/2 3 4 5 6 7 8\nf -1 -2 -3 \\\n -4\n",
        "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\np 1\nf 1//1 2//2 3//3\ncurv 0 1 1 2\nusemtl\n",
    ]);
    all.extend(meshes(MeshFormat::Obj));
    all
}

pub(crate) fn ply() -> Vec<Vec<u8>> {
    let mut all = texts(&[
        "ply\nformat ascii 1.0\ncomment a\nelement vertex 5\nproperty float x\nproperty double y\nproperty int z\nproperty uchar red\n\
         element face 2\nproperty list uchar int vertex_indices\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
         0 0 0 1\n3 0 0 2\n1 1 0 3\n0 3 0 4\n0 0 1 5\n4 0 1 2 3\n3 0 1 4\n5 0 1 2 -1 3\n",
        "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar uchar vertex_index\nend_header\n\0\0\0\0\0\0\0\0\0\0\0\0\x03\0\0\0",
    ]);
    all.extend(meshes(MeshFormat::Ply));
    all
}

pub(crate) fn stl() -> Vec<Vec<u8>> {
    let mut all = texts(&[
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n\
         solid b\nfacet normal nan 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1e-3 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid b\n",
    ]);
    all.extend(meshes(MeshFormat::Stl));
    all
}

pub(crate) fn three_mf_model() -> Vec<Vec<u8>> {
    let vertices = r#"<vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices>"#;
    let triangles = r#"<triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="3"/></triangles>"#;
    let text = format!(
        r#"<?xml version="1.0"?><model unit="inch" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06" requiredextensions="p"><resources><object id="1" type="model"><mesh>{vertices}{triangles}</mesh></object><object id="2"><components><component objectid="1" p:path="/3D/3dmodel.model" transform="-1 0 0 0 1 0 0 0 1 9 0 0"/><component objectid="1"/></components></object></resources><build><item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 0"/><item objectid="1" printable="0"/></build></model>"#
    );
    vec![text.into_bytes()]
}

/// Returns a small picture in each format that is read.
pub(crate) fn images() -> Vec<Vec<u8>> {
    use image::{DynamicImage, ImageFormat, Rgb32FImage};
    let color = |x: u32, y: u32| image::Rgb([x as f32 / 8.0, y as f32 / 8.0, 0.5]);
    let light = DynamicImage::from(Rgb32FImage::from_fn(8, 6, color));
    let bytes = light.to_rgb8();
    let wide = light.to_luma16();
    [
        (ImageFormat::Png, DynamicImage::from(bytes.clone())),
        (ImageFormat::Png, DynamicImage::from(wide)),
        (ImageFormat::Jpeg, DynamicImage::from(bytes)),
        (ImageFormat::Hdr, light.clone()),
        (ImageFormat::OpenExr, light),
    ]
    .into_iter()
    .map(|(format, picture)| {
        let mut file = Cursor::new(Vec::new());
        picture
            .write_to(&mut file, format)
            .expect("a picture can be written");
        file.into_inner()
    })
    .collect()
}

fn ball() -> Scene {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.5)).expect("a brush");
    scene
}

/// Returns a small volume of each kind, with a scene.
pub(crate) fn volume_files() -> Vec<Vec<u8>> {
    let scene = ball();
    let resolution = 8;
    let kinds: [Representation; 3] = [
        DenseOptions {
            resolution,
            ..DenseOptions::default()
        }
        .into(),
        BricksOptions {
            resolution: 16,
            ..BricksOptions::default()
        }
        .into(),
        OctreeOptions {
            resolution: 16,
            ..OctreeOptions::default()
        }
        .into(),
    ];
    kinds
        .into_iter()
        .map(|kind| {
            let world = Engine::cpu()
                .build(&scene)
                .and_then(|build| build.with_representation(kind));
            let mut bytes = Vec::new();
            world.expect("a volume").write(&mut bytes).expect("a file");
            bytes
        })
        .collect()
}

/// Returns a small volume for other programs.
pub(crate) fn exports(extension: &str) -> Vec<Vec<u8>> {
    let scene = ball();
    let world = Engine::cpu().build(&scene).expect("a world").field();
    let name = format!("a.{extension}");
    let format = ExportFormat::from_path(Path::new(&name)).expect("a format");
    let options = ExportOptions {
        resolution: 8,
        ..ExportOptions::default()
    };
    let mut file = Cursor::new(Vec::new());
    world
        .export_to(&mut file, format, &options)
        .expect("a volume");
    vec![file.into_inner()]
}
