//! Case files: what a run is asked to do.
//!
//! A case goes through three forms: the keys as written ([`CaseKeys`]), the same keys checked and
//! with every default filled in, and the [`Scene`] in the terms of the
//! components.

mod body_checks;
mod body_keys;
mod checks;
mod coupling;
mod geometry_checks;
mod keys;
mod library;
mod mooring_keys;
mod moorings;
mod motion;
mod reference_keys;
mod references;
mod resolve;
mod source;
mod wave_checks;
mod wave_keys;
mod wave_plan;

pub use body_keys::{
    BodyKeys, BoxKeys, ContactKeys, Direction, EngineName, MotionKeys, RotationKeys,
    TranslationKeys,
};
pub use coupling::{AccelerationName, CouplingKeys, ExtrapolationName, SchemeName};
pub use keys::{
    CaseKeys, DampingZoneKeys, Device, GaugeKeys, NumericsKeys, OutputKeys, PressureKeys,
    ProbeKeys, StandingWaveKeys, TableName, TankKeys, WaterKeys,
};
pub use library::{LibraryCase, library};
pub use mooring_keys::{LineKind, MooringKeys};
pub use reference_keys::{ComparisonKeys, MeasureName, ReferenceKeys};
pub use wave_keys::{
    AbsorptionKeys, BoardKind, InitialWaveKeys, WaveKeys, WaveKind, WavemakerKeys,
};

use crate::scene::Scene;
use seakeep_fluid::network::{Network, NetworkError};
use source::Source;
use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A case that has passed every check.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Name: that of the file without its extension.
    pub name: String,
    /// The keys, with every default and override in place: a case file that asks for the same.
    pub keys: CaseKeys,
    /// What the components are asked for.
    pub scene: Scene,
    /// What can be run but may not be what was meant, a line each.
    pub warnings: Vec<String>,
}

/// Which variant of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// As the file says.
    Full,
    /// With the overrides under its key `coarse`.
    Coarse,
}

/// One thing wrong with a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// `file:line`, or the override.
    pub place: String,
    /// Dotted key; empty where no single key is at fault.
    pub key: String,
    /// What is wrong, with the value and what is allowed.
    pub message: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.key.as_str() {
            "" => write!(f, "{}: {}", self.place, self.message),
            key => write!(f, "{}: {key}: {}", self.place, self.message),
        }
    }
}

/// Why there is no [`Case`].
#[derive(Debug, Error)]
pub enum CaseError {
    /// Neither a file nor a case of the library.
    #[error(
        "{asked}: no such file, and no case of this name (there are: {})",
        library().iter().map(|case| case.name).collect::<Vec<_>>().join(", ")
    )]
    NotFound {
        /// What was asked for.
        asked: String,
    },
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A weights file that is none, or not for the network.
    #[error("{}: {source}", .path.display())]
    Network {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: NetworkError,
    },
    /// The case asks for something that cannot be: all that is wrong, a line each.
    #[error("{}", .0.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Problem>),
}

/// The network in the weights file `path`, or the one that comes with the program.
///
/// # Errors
/// [`CaseError::Read`] and [`CaseError::Network`].
pub fn network(path: Option<&Path>) -> Result<Network, CaseError> {
    let read = match path {
        None => Network::shipped(),
        Some(path) => {
            let bytes = std::fs::read(path)
                .map_err(|source| CaseError::Read { path: path.to_owned(), source })?;
            Network::from_bytes(&bytes)
        }
    };
    let path = || path.map_or_else(|| "the program's weights".into(), Path::to_path_buf);
    read.map_err(|source| CaseError::Network { path: path(), source })
}

impl Case {
    /// The case in the file `asked`, or the library's case of that name, with `overrides`
    /// (`dotted.key=value`) in place.
    ///
    /// # Errors
    /// [`CaseError`]: a case that is returned can be run.
    pub fn load(asked: &str, overrides: &[String]) -> Result<Self, CaseError> {
        Self::load_as(asked, Resolution::Full, overrides)
    }

    /// The same with, for [`Resolution::Coarse`], the overrides that the case names as `coarse`
    /// before those given; it is called `NAME-coarse` then.
    ///
    /// # Errors
    /// As [`Self::load`]; also for a case without a coarse variant.
    pub fn load_as(
        asked: &str,
        resolution: Resolution,
        overrides: &[String],
    ) -> Result<Self, CaseError> {
        let path = Path::new(asked);
        let known = library().iter().find(|case| case.name == asked);
        let (label, text) = match known {
            _ if path.is_file() => {
                let text = std::fs::read_to_string(path)
                    .map_err(|source| CaseError::Read { path: path.to_owned(), source })?;
                (asked.to_owned(), text)
            }
            Some(case) => (format!("{asked}.toml"), case.text.to_owned()),
            None => return Err(CaseError::NotFound { asked: asked.to_owned() }),
        };
        let name =
            Path::new(&label).file_stem().map_or(asked.into(), |stem| stem.to_string_lossy());
        match resolution {
            Resolution::Full => Self::parse(&name, &label, &text, overrides),
            Resolution::Coarse => {
                let invalid = |problem| CaseError::Invalid(vec![problem]);
                let (keys, source) = Source::read(&label, &text, &[]).map_err(invalid)?;
                if keys.coarse.is_empty() {
                    let message = "missing: the case has no coarse variant".to_owned();
                    return Err(invalid(source.problem("coarse", message)));
                }
                let overrides = [&keys.coarse, overrides].concat();
                Self::parse(&format!("{name}-coarse"), &label, &text, &overrides)
            }
        }
    }

    /// The case `text`, called `label` in messages.
    ///
    /// # Errors
    /// [`CaseError::Invalid`].
    pub fn parse(
        name: &str,
        label: &str,
        text: &str,
        overrides: &[String],
    ) -> Result<Self, CaseError> {
        let (mut keys, source) = Source::read(label, text, overrides)
            .map_err(|problem| CaseError::Invalid(vec![problem]))?;
        let refuse_if_any = |problems: Vec<Problem>| match problems.is_empty() {
            true => Ok(()),
            false => Err(CaseError::Invalid(problems)),
        };
        let folder = Path::new(label).parent().unwrap_or(Path::new(""));
        if let Some(wave) = &mut keys.wave {
            wave_plan::read_motion(wave, folder).map_err(|message| {
                CaseError::Invalid(vec![source.problem("wave.file", message)])
            })?;
        }
        // What was asked for is in place by now.
        keys.coarse.clear();
        references::read(&mut keys, folder, &source).map_err(CaseError::Invalid)?;
        refuse_if_any(checks::check_values(&keys, &source))?;
        let motions = motion::prescribed(&mut keys, folder, &source).map_err(CaseError::Invalid)?;
        refuse_if_any(geometry_checks::check_geometry(&keys, &source))?;
        let mut keys = resolve::resolve(keys);
        let lines = moorings::lines(&mut keys, &source).map_err(CaseError::Invalid)?;
        refuse_if_any(wave_checks::check_wave_fits(&keys, &source))?;
        let network = network(keys.pressure.weights.as_deref())?;
        let wave = wave_plan::wave_plan(&keys);
        let scene = Scene::new(&keys, motions, lines, wave, network);
        let warnings = wave_checks::warnings(&keys);
        Ok(Self { name: name.to_owned(), keys, scene, warnings })
    }

    /// The resolved case as the text of a case file.
    ///
    /// # Errors
    /// When the keys cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(&self.keys)
    }
}
