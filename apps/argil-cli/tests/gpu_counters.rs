//! Tests what the command counts of a GPU.

use crate::common::{argil, json, scene};

/// What the GPU was asked to do is counted. A process creates only the pipelines that it runs, so a mesh takes none of images, a
/// bake none of meshes, and a second frame no more than the first.
#[test]
fn only_pipelines_that_run_are_created() {
    let folder = tempfile::tempdir().expect("a folder");
    let png = folder.path().join("x.png").display().to_string();
    let brick = scene("brick");
    let count = |arguments: &[&str], name: &str| {
        let small = [
            "--via",
            "bricks",
            "--resolution",
            "32",
            "--device",
            "gpu",
            "--json",
        ];
        let report = json(&argil(&[arguments, &small].concat()));
        let count = report["gpu"][name].as_u64();
        count.unwrap_or_else(|| panic!("{name}: {report}"))
    };
    let baked = count(&["bake", &brick], "pipelines");
    assert!((5..=10).contains(&baked), "{baked}");
    let meshed = count(&["mesh", &brick], "pipelines");
    assert!((12..=18).contains(&meshed), "{meshed}");
    let picture = ["render", &brick, "-o", &png, "--size", "32x32"];
    let drawn = count(&picture, "pipelines");
    let frames = |frames| count(&[&picture[..], &["--frames", frames]].concat(), "pipelines");
    assert!(drawn > baked, "{drawn}");
    assert_eq!(frames("2"), frames("3"));
    // Negative control: work that takes more is counted.
    for name in ["submissions", "waits"] {
        let submitted = |frames| count(&[&picture[..], &["--frames", frames]].concat(), name);
        assert!(submitted("3") > submitted("2"), "{name}");
    }
    let on_cpu = [
        "bake",
        &brick,
        "--resolution",
        "32",
        "--device",
        "cpu",
        "--json",
    ];
    assert!(json(&argil(&on_cpu))["gpu"].is_null());
}
