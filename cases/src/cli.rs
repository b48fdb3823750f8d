//! The command line.

use clap::{Args, Parser, Subcommand};
use seakeep::bench::Variation;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// The case that is run where no command is given.
const MAIN_CASE: &str = "roll_decay";

/// Floating bodies in waves, in two dimensions.
///
/// Without a command, the main case is run: `seakeep run roll_decay`.
#[derive(Debug, Parser)]
#[command(version)]
pub(crate) struct Cli {
    /// What to do
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a case and write its results
    Run(RunArguments),
    /// Check a case without running it
    Check {
        #[command(flatten)]
        case: CaseArguments,
        /// Print every stage of the run, kept or left out, with the reason
        #[arg(long)]
        plan: bool,
    },
    /// Show what the wave of a case should be, by theory, and how the paddle moves
    Wave(WaveArguments),
    /// Run cases and hold them against their references
    Validate(ValidateArguments),
    /// Run a case over a grid of settings and set its error against its run time
    Bench(BenchArguments),
    /// Tensions of the mooring lines of a case for a motion that is given, without water
    Mooring(MooringArguments),
    /// List the cases that come with the program
    List,
    /// Run the cases of a campaign and keep frames for the training of networks
    Dataset(DatasetArguments),
    /// Measure a network beside other ways to find the pressure
    Evaluate(EvaluateArguments),
    /// Train a network on data sets; needs a build with the feature torch
    Train(TrainArguments),
    /// Compare the pressure solvers at the sizes of Table 1 of Ma, Zhang, Yan & Li (2024)
    BenchPressure(BenchPressureArguments),
}

/// Which case.
#[derive(Debug, Args)]
pub(crate) struct CaseArguments {
    /// A case file, or the name of a case that comes with the program
    pub(crate) case: String,
    /// Take the coarse variant of the case, which runs in a minute or two
    #[arg(long)]
    pub(crate) coarse: bool,
    /// Override a key, such as water.depth_m=0.5 or body[0].angle_deg=5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

/// Where the results go.
#[derive(Debug, Default, Args)]
pub(crate) struct OutArguments {
    /// Directory for the results; without it one in results/ with the name of the case, numbered if
    /// that is taken
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write into the directory named by --out even if it is not empty
    #[arg(long, requires = "out")]
    pub(crate) force: bool,
}

/// For which motion.
#[derive(Debug, Args)]
pub(crate) struct MooringArguments {
    #[command(flatten)]
    pub(crate) case: CaseArguments,
    /// Table (CSV) with the columns time_s, sway_m, heave_m and roll_rad, and body if several are
    /// moored: such as the motion.csv of a run
    #[arg(long, value_name = "FILE")]
    pub(crate) motion: PathBuf,
    #[command(flatten)]
    pub(crate) into: OutArguments,
    /// Print nothing but errors
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// How to run it.
#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    #[command(flatten)]
    pub(crate) case: CaseArguments,
    /// What finds the pressure, in place of the case's pressure.solver: ppe, network or guarded
    #[arg(long, value_name = "SOLVER")]
    pub(crate) pressure: Option<String>,
    /// Where the network is evaluated, in place of the case's pressure.device: own (the program's own
    /// code), cpu or cuda (libtorch, in a build with the feature torch)
    #[arg(long, value_name = "DEVICE")]
    pub(crate) device: Option<String>,
    #[command(flatten)]
    pub(crate) into: OutArguments,
    /// Threads to use; without it as many as there are processors. Results do not depend on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Print nothing but errors
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Which wave, and where it goes.
#[derive(Debug, Args)]
pub(crate) struct WaveArguments {
    #[command(flatten)]
    pub(crate) case: CaseArguments,
    /// Time of the profile along the tank, s; without it the end of the run
    #[arg(long, value_name = "SECONDS")]
    pub(crate) at: Option<f64>,
    #[command(flatten)]
    pub(crate) into: OutArguments,
}

/// Which settings, and what is compared.
#[derive(Debug, Args)]
pub(crate) struct BenchArguments {
    #[command(flatten)]
    pub(crate) case: CaseArguments,
    /// A key and its values, such as numerics.particle_spacing_m=0.02,0.01; repeated, every
    /// combination is run
    #[arg(long, value_name = "KEY=VALUE,VALUE", required = true)]
    pub(crate) vary: Vec<Variation>,
    /// The error of the plot, by its name in the table; without it the first
    #[arg(long, value_name = "NAME")]
    pub(crate) error: Option<String>,
    #[command(flatten)]
    pub(crate) into: OutArguments,
    /// Threads to use; without it as many as there are processors
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
}

/// What is validated.
#[derive(Debug, Args)]
pub(crate) struct ValidateArguments {
    /// Case files, or names of cases that come with the program; without any, all of those that
    /// name references
    pub(crate) cases: Vec<String>,
    /// Run the cases as they stand, not their coarse variants: hours for all of them
    #[arg(long)]
    pub(crate) full: bool,
    /// Run once with each of these pressure solvers: ppe, network or guarded
    #[arg(long, value_name = "SOLVERS", value_delimiter = ',')]
    pub(crate) pressure: Vec<String>,
    /// Override a key in every case; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Run nothing: compare the results in this directory; may be repeated, one for each case
    #[arg(long, value_name = "DIR", requires = "cases", conflicts_with_all = ["full", "pressure", "set"])]
    pub(crate) results: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) into: OutArguments,
    /// Threads to use; without it as many as there are processors
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
}

/// Which sizes to compare the pressure solvers at.
#[derive(Debug, Args)]
pub(crate) struct BenchPressureArguments {
    /// Rows of Table 1, from 1 to 5: 80,000 to 1,280,000 particles
    #[arg(long, value_name = "ROWS", value_delimiter = ',', default_values_t = [1])]
    pub(crate) rows: Vec<usize>,
    /// Steps that are compared, after 8 that are not
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub(crate) steps: u64,
    /// Residual relative to the right-hand side to which the warm pressure equation is solved
    #[arg(long, value_name = "T", default_value_t = 1e-3)]
    pub(crate) tolerance: f64,
    /// Where the network is evaluated once more: cpu or cuda (libtorch, in a build with the feature
    /// torch)
    #[arg(long, value_name = "DEVICE")]
    pub(crate) device: Option<String>,
    /// Threads to use; without it as many as there are processors
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
    /// A file for the table as CSV
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// Which data.
#[derive(Debug, Args)]
pub(crate) struct DatasetArguments {
    /// A campaign file
    pub(crate) campaign: PathBuf,
    /// Folder for the cases; those that are there already are left alone
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Run this case of the campaign alone; may be repeated
    #[arg(long, value_name = "NAME")]
    pub(crate) case: Vec<String>,
    /// Override a key of every case, such as pressure.solver="network"; may be repeated. The
    /// pressure of the frames is exact whatever finds that of the run
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Threads to use; without it as many as there are processors. Frames do not depend on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Print nothing but errors
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Which training.
#[derive(Debug, Args)]
pub(crate) struct TrainArguments {
    /// A training file
    pub(crate) config: PathBuf,
    /// Folder for weights, checkpoint and learning curve; a training that is there goes on
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Where to train: cpu or cuda
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub(crate) device: String,
    /// Threads to use. Weights are the same for the same number
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) threads: NonZeroUsize,
    /// Print nothing but errors
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// What to measure a network on.
#[derive(Debug, Args)]
pub(crate) struct EvaluateArguments {
    /// A weights file
    pub(crate) model: PathBuf,
    /// A campaign, on single steps of whose test cases it is measured
    #[arg(long, value_name = "FILE")]
    pub(crate) campaign: Option<PathBuf>,
    /// Steps of each test case that are looked at
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub(crate) steps: usize,
    /// A case that is run whole with each solver; may be repeated
    #[arg(long, value_name = "CASE")]
    pub(crate) rollout: Vec<String>,
    /// Override a key of these cases; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// A data set, on whose test frames libtorch runs the network beside the program's own
    /// inference; needs a build with the feature torch
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Where libtorch runs it: cpu or cuda
    #[arg(long, value_name = "NAME", default_value = "cpu", requires = "data")]
    pub(crate) device: String,
    /// Folder for tables and plots
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Threads to use; without it as many as there are processors
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
}

/// The command that is run where none is given.
pub(crate) fn main_job() -> Command {
    Command::Run(RunArguments {
        case: CaseArguments { case: MAIN_CASE.to_owned(), coarse: false, set: Vec::new() },
        pressure: None,
        device: None,
        into: OutArguments::default(),
        threads: None,
        quiet: false,
    })
}
