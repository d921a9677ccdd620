//! Packages of our crates, and whether they hold what their sources include. Nothing is compiled here: the release
//! workflow compiles each crate from its package.

use crate::apt::quietly;
use crate::{root, run};
use anyhow::{Context, bail};
use std::fs;
use std::path::{Path, PathBuf};

/// Where packages are.
const TARGET: &str = "target/packages";
/// What is in front of the path of an included file, without spaces.
const INCLUDES: [&str; 4] = ["include_str!(", "include_bytes!(", "include!(", "#[path="];

/// What is in front of a file that only tests of documentation read. They do not run in packages.
const ONLY_TESTED: &str = "#[cfg(doctest)]#[doc=include_str!(";

/// Packages every crate but some, and checks what the packages hold.
///
/// # Errors
/// If a crate cannot be packaged, or a package lacks a file.
pub fn check(excluded: &[&str]) -> anyhow::Result<()> {
    let packages = root().join(TARGET).join("package");
    let unpacked = root().join(TARGET).join("unpacked");
    for folder in [&packages, &unpacked] {
        // What earlier runs left would be found, too.
        let _ = fs::remove_dir_all(folder);
    }
    fs::create_dir_all(&unpacked)?;
    let mut arguments = vec!["package", "--workspace", "--no-verify", "--quiet"];
    arguments.extend(["--locked", "--allow-dirty", "--target-dir", TARGET]);
    arguments.extend(excluded.iter().flat_map(|name| ["--exclude", name]));
    run("cargo", &arguments)?;
    let into = unpacked.display().to_string();
    for package in entries(&packages)? {
        if package.extension().is_some_and(|ending| ending == "crate") {
            let package = package.display().to_string();
            if !quietly("tar", &["-xzf", &package, "-C", &into]) {
                bail!("tar could not unpack {package}");
            }
        }
    }
    let mut included = 0;
    for package in entries(&unpacked)? {
        included += includes(&package, &package.join("src"))?;
    }
    println!("  packages hold all {included} files that their sources include");
    if included < 100 {
        bail!("that is too few: are files included in another way?");
    }
    Ok(())
}

/// Returns how many files the sources in a package's folder include.
///
/// # Errors
/// If the package lacks one of them.
fn includes(package: &Path, folder: &Path) -> anyhow::Result<usize> {
    let package = package.canonicalize()?;
    let mut count = 0;
    for path in entries(folder)? {
        if path.is_dir() {
            count += includes(&package, &path)?;
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            for name in included(&fs::read_to_string(&path)?) {
                let file = folder.join(&name).canonicalize();
                if !file.is_ok_and(|file| file.starts_with(&package)) {
                    bail!(
                        "{} includes {name}, which its package lacks",
                        path.display()
                    );
                }
                count += 1;
            }
        }
    }
    Ok(count)
}

/// Returns the paths of the files that a source includes.
fn included(source: &str) -> Vec<String> {
    let dense: String = source.split_whitespace().collect();
    let dense = dense.replace(ONLY_TESTED, "");
    let after = INCLUDES.iter().flat_map(|word| dense.split(word).skip(1));
    let quoted = after.filter_map(|text| text.strip_prefix('"')?.split('"').next());
    quoted.map(str::to_owned).collect()
}

fn entries(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let found = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    Ok(found.flatten().map(|entry| entry.path()).collect())
}

#[cfg(test)]
mod tests {
    use super::includes;
    use std::fs;

    #[test]
    fn a_file_that_a_package_lacks_is_found() -> anyhow::Result<()> {
        let folder = std::env::temp_dir().join(format!("argil-packages-{}", std::process::id()));
        let (package, source) = (folder.join("one-0.1.0"), folder.join("one-0.1.0/src"));
        fs::create_dir_all(source.join("part"))?;
        fs::write(folder.join("outside.txt"), "")?;
        fs::write(source.join("inside.txt"), "")?;
        let with = |text: &str| {
            fs::write(source.join("part/a.rs"), text)?;
            includes(&package, &source)
        };
        assert_eq!(
            with("const A: &str = include_str!(\n \"../inside.txt\");")?,
            1
        );
        assert_eq!(
            with("#[cfg(doctest)]\n#[doc = include_str!(\"../../../outside.txt\")]")?,
            0
        );
        assert!(with("const A: &str = include_str!(\"../missing.txt\");").is_err());
        assert!(with("#[path = \"../../../outside.txt\"] mod outside;").is_err());
        fs::remove_dir_all(&folder)?;
        Ok(())
    }
}
