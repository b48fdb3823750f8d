//! How far a run is: a bar on a terminal, a line every tenth otherwise.

use indicatif::{ProgressBar, ProgressStyle};
use seakeep::case::Case;
use seakeep::job::Progress;
use std::io::{IsTerminal, Write};

/// Shows progress on standard error.
pub(crate) enum ProgressDisplay {
    /// Nothing.
    Quiet,
    /// A bar with the time left.
    Bar(ProgressBar),
    /// A line for each tenth; the number of those shown.
    Lines(u64),
}

impl ProgressDisplay {
    pub(crate) fn new(quiet: bool, case: &Case) -> Self {
        if quiet {
            return Self::Quiet;
        }
        if !std::io::stderr().is_terminal() {
            return Self::Lines(0);
        }
        let bar = ProgressBar::new(case.scene.steps);
        let template = "{prefix} {wide_bar} {percent:>3} %  {msg}  {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_prefix(case.name.clone());
        Self::Bar(bar)
    }

    pub(crate) fn update(&mut self, progress: Progress) {
        match self {
            Self::Quiet => {}
            Self::Bar(bar) => {
                bar.set_position(progress.step);
                bar.set_message(format!("t = {:.3} s", progress.time));
            }
            Self::Lines(shown) => {
                let tenth = 10 * progress.step / progress.steps;
                if tenth > *shown {
                    *shown = tenth;
                    let _ = writeln!(
                        std::io::stderr(),
                        "{:>3} %  step {} of {}, t = {:.3} s",
                        10 * tenth,
                        progress.step,
                        progress.steps,
                        progress.time
                    );
                }
            }
        }
    }

    pub(crate) fn finish(self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
