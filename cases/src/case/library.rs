//! The cases that come with the program.

use std::path::Path;

/// A case file inside the program.
#[derive(Clone, Copy, Debug)]
pub struct LibraryCase {
    /// Name to run it by.
    pub name: &'static str,
    /// Text of the file.
    pub text: &'static str,
}

macro_rules! cases {
    ($($name:literal),* $(,)?) => {
        &[$(LibraryCase {
            name: $name,
            text: include_str!(concat!("../../", $name, ".toml")),
        }),*]
    };
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../", $name)))),*]
    };
}

/// The text of a file that comes with the program, by its path beside the case files, unless there
/// is such a file in `folder`.
#[must_use]
pub(super) fn shipped(folder: &Path, path: &Path) -> Option<&'static str> {
    if folder.join(path).is_file() {
        return None;
    }
    let files: &[(&str, &str)] = files![
        "reference/lobovsky2014/elevation.csv",
        "reference/lobovsky2014/pressure.csv",
        "reference/spheric10/motion.csv",
        "reference/spheric10/pressure.csv",
        "reference/ren2015/elevation.csv",
        "reference/ren2015/heave.csv",
        "reference/ren2015/roll.csv",
        "reference/ren2015/sway.csv",
    ];
    files.iter().find(|(name, _)| Path::new(name) == path).map(|(_, text)| *text)
}

/// Every case that comes with the program, in the order of `seakeep list`.
#[must_use]
pub fn library() -> &'static [LibraryCase] {
    cases![
        "still_tank",
        "standing_wave",
        "regular_wave",
        "solitary_wave",
        "focused_wave",
        "irregular_sea",
        "buoyancy",
        "heave_decay",
        "roll_decay",
        "free_box_waves",
        "solitary_box",
        "moored_breakwater",
        "green_water",
        "ship_section",
        "two_boxes",
        "dam_break",
        "sloshing"
    ]
}

#[cfg(test)]
mod tests {
    use super::super::{Case, Resolution};
    use super::*;

    #[test]
    fn every_case_passes_and_its_resolved_form_is_the_same_case() {
        for known in library() {
            let case = Case::load(known.name, &[]).unwrap();
            assert!(!case.keys.description.is_empty(), "{} has no description", known.name);
            let text = case.to_toml().unwrap();
            let again = Case::parse(known.name, "resolved.toml", &text, &[]).unwrap();
            assert_eq!(again, case);
            let coarse = Case::load_as(known.name, Resolution::Coarse, &[]).unwrap();
            let spacing = |case: &Case| case.keys.numerics.particle_spacing_m;
            assert!(spacing(&coarse) > spacing(&case), "{}", known.name);
        }
    }

    #[test]
    fn every_case_file_is_in_the_library() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"));
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if name != "Cargo.toml" && name.ends_with(".toml") {
                let known = library().iter().any(|case| format!("{}.toml", case.name) == name);
                assert!(known, "{name} is not in the library");
            }
        }
    }
}
