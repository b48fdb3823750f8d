//! The checks of this workspace in one command: `cargo xtask test`.
//!
//! `cargo nextest` is used where it is installed, `cargo test` otherwise. The tests of training need
//! libtorch, which is fetched once: Linux on x86-64 with Python's pip.

mod libtorch;

use std::env;
use std::ffi::OsStr;
use std::io::Write;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

const USAGE: &str = "\
usage: cargo xtask test        format, lints, documentation and all tests
       cargo xtask libtorch    fetch libtorch, once, and link it: for the training of networks";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["test"] => test(),
        ["libtorch"] => match libtorch::provide(root()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                say(&error);
                ExitCode::FAILURE
            }
        },
        _ => {
            say(USAGE);
            ExitCode::from(2)
        }
    }
}

/// One check: a `cargo` command, what is added to the environment.
struct Check {
    name: &'static str,
    arguments: &'static [&'static str],
    environment: &'static [(&'static str, &'static str)],
}

const FORMAT: Check =
    Check { name: "format", arguments: &["fmt", "--all", "--check"], environment: &[] };
const LINTS: Check = Check {
    name: "lints",
    arguments: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
    environment: &[],
};
const DOCUMENTATION: Check = Check {
    name: "documentation",
    arguments: &["doc", "--workspace", "--no-deps", "--document-private-items"],
    environment: &[("RUSTDOCFLAGS", "-D warnings")],
};
const NEXTEST: Check = Check {
    name: "tests",
    arguments: &["nextest", "run", "--workspace", "--no-fail-fast"],
    environment: &[],
};
const TESTS: Check = Check {
    name: "tests",
    arguments: &["test", "--workspace", "--all-targets", "--no-fail-fast"],
    environment: &[],
};
const DOCUMENTATION_TESTS: Check = Check {
    name: "documentation tests",
    arguments: &["test", "--workspace", "--doc"],
    environment: &[],
};

/// Training, which is no part of the default build. Its tests alone: all else is the same without.
const LINTS_OF_TRAINING: Check = Check {
    name: "lints of training",
    arguments: &[
        "clippy",
        "-p",
        "seakeep",
        "-p",
        "seakeep-learning",
        "--features",
        "seakeep/doc-only",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ],
    environment: &[],
};
const TESTS_OF_TRAINING: Check = Check {
    name: "tests of training",
    arguments: &["test", "-p", "seakeep", "--features", "torch", "--test", "training"],
    environment: &[],
};

/// Runs every check, so that one report names all that is wrong, and the tests last, so that
/// their closing line is the last that is seen.
fn test() -> ExitCode {
    let tests = if has_nextest() { NEXTEST } else { TESTS };
    let mut failed = Vec::new();
    let checks = [FORMAT, LINTS, LINTS_OF_TRAINING, DOCUMENTATION, DOCUMENTATION_TESTS];
    failed.extend(checks.iter().filter(|check| !passes(check)).map(|check| check.name));
    match libtorch::provide(root()) {
        Ok(()) if passes(&TESTS_OF_TRAINING) => {}
        Ok(()) => failed.push(TESTS_OF_TRAINING.name),
        Err(error) => {
            say(&error);
            failed.push("libtorch");
        }
    }
    if !passes(&tests) {
        failed.push(tests.name);
    }
    if failed.is_empty() {
        say("all checks passed");
        return ExitCode::SUCCESS;
    }
    say(&format!("failed: {}", failed.join(", ")));
    ExitCode::FAILURE
}

fn passes(check: &Check) -> bool {
    say(&format!("{}: cargo {}", check.name, check.arguments.join(" ")));
    let begun = Instant::now();
    let status = cargo(check.arguments).envs(check.environment.iter().copied()).status();
    say(&format!("{}: {:.0} s", check.name, begun.elapsed().as_secs_f64()));
    status.is_ok_and(|status| status.success())
}

fn has_nextest() -> bool {
    let mut command = cargo(["nextest", "--version"]);
    let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}

/// `cargo` in the root of the workspace.
fn cargo<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let program = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root());
    command
}

/// Root of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("."))
}

fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}
