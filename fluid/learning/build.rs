//! Tells this package's tests, and the packages that depend on it, where they find libtorch.

fn main() {
    if let Ok(folder) = std::env::var("DEP_TCH_LIBTORCH_LIB") {
        println!("cargo:rustc-link-arg=-Wl,-rpath,{folder}");
        println!("cargo:libtorch={folder}");
    }
}
