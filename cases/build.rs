//! Where the program finds libtorch, if it is built with it.

fn main() {
    if let Ok(folder) = std::env::var("DEP_SEAKEEP_LEARNING_LIBTORCH") {
        println!("cargo:rustc-link-arg=-Wl,-rpath,{folder}");
    }
}
