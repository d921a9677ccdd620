//! Runs every example, and checks the images that it promises.

use std::path::Path;
use std::process::Command;

/// Runs an example in its own folder, without a window. Returns what it printed. Cargo builds examples next to the tests.
fn run(name: &str) -> (tempfile::TempDir, String) {
    let tests = std::env::current_exe().expect("this test");
    let folder = tests.ancestors().nth(2).expect("the build's folder");
    let program = folder
        .join("examples")
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let out = tempfile::tempdir().expect("a folder");
    let arguments: &[&str] = match name.starts_with("host_") {
        true => &["--headless", "--frames", "8", "--json"],
        false => &[],
    };
    let run = Command::new(&program)
        .args(arguments)
        .current_dir(&out)
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}: build all targets first", program.display()));
    assert!(
        run.status.success(),
        "{name}: {}",
        String::from_utf8_lossy(&run.stderr)
    );
    (out, String::from_utf8_lossy(&run.stdout).into_owned())
}

#[test]
fn every_example_runs() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut count = 0;
    for source in std::fs::read_dir(sources).expect("examples").flatten() {
        let path = source.path();
        let name = path
            .file_stem()
            .and_then(|name| name.to_str())
            .expect("a name");
        // A folder holds what the program has besides us.
        let (main, most) = match path.is_dir() {
            true => (path.join("main.rs"), 75),
            false => (path.clone(), 60),
        };
        let lines = std::fs::read_to_string(main).expect("text").lines().count();
        assert!(lines <= most, "{name} has {lines} lines");
        let (out, printed) = run(name);
        if name.starts_with("host_") {
            let later = printed.split("\"later\": ").nth(1);
            let later = later.unwrap_or_else(|| panic!("{name} prints {printed}"));
            assert!(
                later.starts_with("{\"submissions\": 1, \"waits\": 0,"),
                "{later}"
            );
            assert!(later.contains("\"pipelines\": 0"), "{later}");
        }
        let picture = if name == "animation" {
            "animation-0"
        } else {
            name
        };
        assert!(out.path().join(format!("{picture}.png")).exists(), "{name}");
        count += 1;
    }
    assert_eq!(count, 11);
}
