//! libtorch, for the training of networks: three wheels with known hashes, pruned to what the processor
//! needs, in the user's cache, and the link `.libtorch` to it that `.cargo/config.toml` names.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The version that `tch` is bound to.
const VERSION: &str = "2.11.0";

/// What pip installs: name, version and SHA-256 of the wheels (cp311, manylinux_2_28, x86_64).
const REQUIREMENTS: &str = "\
torch==2.11.0 --hash=sha256:7aa2f9bbc6d4595ba72138026b2074be1233186150e9292865e04b7a63b8c67a
nvidia-cuda-runtime==13.0.96 --hash=sha256:7f82250d7782aa23b6cfe765ecc7db554bd3c2870c43f3d1821f1d18aebf0548
nvidia-cuda-cupti==13.0.85 --hash=sha256:4eb01c08e859bf924d222250d2e8f8b8ff6d3db4721288cf35d14252a4d933c8
";

/// The libraries that are kept: file, and the folder of the wheels that it is in.
const LIBRARIES: [(&str, &str); 5] = [
    ("libtorch_cpu.so", "torch/lib"),
    ("libc10.so", "torch/lib"),
    ("libgomp.so.1", "torch/lib"),
    ("libcudart.so.13", "nvidia/cu13/lib"),
    ("libcupti.so.13", "nvidia/cu13/lib"),
];

/// Makes sure that libtorch is there and linked from `root`.
pub(crate) fn provide(root: &Path) -> Result<(), String> {
    let cache = cache()?;
    let home = cache.join(format!("libtorch-{VERSION}"));
    if !is_whole(&home) {
        fs::create_dir_all(&cache).map_err(at(&cache))?;
        let stage = cache.join(format!("stage-{}", std::process::id()));
        let made = install(&stage).and_then(|()| keep(&stage, &home));
        let _ = fs::remove_dir_all(&stage);
        made?;
    }
    link(&home, &root.join(".libtorch"))
}

fn cache() -> Result<PathBuf, String> {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("XDG_CACHE_HOME")
        .or_else(|| set("HOME").map(|home| home.join(".cache")))
        .map(|cache| cache.join("seakeep"))
        .ok_or_else(|| "neither XDG_CACHE_HOME nor HOME is set: no place for libtorch".to_owned())
}

fn is_whole(home: &Path) -> bool {
    fs::read_to_string(home.join("build-version")).is_ok_and(|version| version.trim() == VERSION)
}

/// Installs the wheels into `stage`.
fn install(stage: &Path) -> Result<(), String> {
    fs::create_dir_all(stage).map_err(at(stage))?;
    let requirements = stage.join("requirements.txt");
    fs::write(&requirements, REQUIREMENTS).map_err(at(&requirements))?;
    let platforms = ["manylinux_2_28_x86_64", "manylinux_2_25_x86_64", "manylinux2014_x86_64"];
    let mut command = Command::new("python3");
    command
        .args(["-m", "pip", "install", "--quiet", "--no-deps", "--require-hashes"])
        .args(["--disable-pip-version-check", "--no-cache-dir", "--only-binary=:all:"])
        .args(platforms.iter().flat_map(|platform| ["--platform", platform]))
        .args(["--python-version", "3.11", "--implementation", "cp", "--abi", "cp311"])
        .arg("--target")
        .arg(stage.join("wheels"))
        .arg("-r")
        .arg(&requirements);
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("libtorch: pip failed ({status})")),
        Err(error) => Err(format!("libtorch: python3 -m pip cannot be run: {error}")),
    }
}

/// Moves what is needed of the wheels in `stage` to `home`, which appears whole or not at all.
fn keep(stage: &Path, home: &Path) -> Result<(), String> {
    let (wheels, pruned) = (stage.join("wheels"), stage.join("libtorch"));
    let lib = pruned.join("lib");
    fs::create_dir_all(&lib).map_err(at(&lib))?;
    for (file, folder) in LIBRARIES {
        let from = find(&wheels.join(folder), &wheels, file)?;
        fs::rename(&from, lib.join(file)).map_err(at(&from))?;
    }
    let alias = lib.join("libtorch.so");
    std::os::unix::fs::symlink("libtorch_cpu.so", &alias).map_err(at(&alias))?;
    let include = wheels.join("torch/include");
    fs::rename(&include, pruned.join("include")).map_err(at(&include))?;
    let version = pruned.join("build-version");
    fs::write(&version, format!("{VERSION}\n")).map_err(at(&version))?;
    if home.exists() {
        fs::remove_dir_all(home).map_err(at(home))?;
    }
    match fs::rename(&pruned, home) {
        // Another run was quicker.
        Err(_) if is_whole(home) => Ok(()),
        result => result.map_err(at(home)),
    }
}

/// `file` in `folder`, or else anywhere below `root`.
fn find(folder: &Path, root: &Path, file: &str) -> Result<PathBuf, String> {
    let expected = folder.join(file);
    if expected.is_file() {
        return Ok(expected);
    }
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).map_err(at(&folder))?.flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name() == Some(OsStr::new(file)) {
                return Ok(path);
            }
        }
    }
    Err(format!("libtorch: the wheels hold no {file}"))
}

fn link(home: &Path, link: &Path) -> Result<(), String> {
    if fs::read_link(link).is_ok_and(|target| target == home) {
        return Ok(());
    }
    if fs::symlink_metadata(link).is_ok() {
        fs::remove_file(link).map_err(at(link))?;
    }
    std::os::unix::fs::symlink(home, link).map_err(at(link))
}

fn at(path: &Path) -> impl Fn(io::Error) -> String + '_ {
    move |error| format!("{}: {error}", path.display())
}
