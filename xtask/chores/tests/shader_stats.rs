//! What a hardware compiler makes of our shaders is what the committed table says, or better.

/// No entry point gets scratch, loses waves, or outgrows its limit. A process of its own, because the Vulkan loader reads its
/// environment once. Only Linux has the compiler.
#[cfg(target_os = "linux")]
#[test]
fn shaders_are_no_worse_than_the_table_on_hardware() {
    let check = std::process::Command::new(env!("CARGO_BIN_EXE_argil-chores"))
        .args(["shader-stats", "--check"])
        .output()
        .expect("the program of tasks");
    let [out, fault] = [&check.stdout, &check.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(check.status.success(), "{out}{fault}");
}
