//! What is said at the end of a run, and of a case that passes its checks.

use seakeep::bench::Trial;
use seakeep::case::Case;
use seakeep::mooring_job::LineRange;
use seakeep::output::summary::{Finding, Summary};
use seakeep::theory::Theory;
use seakeep::waves::WaveTheory;
use std::fmt::Write;

/// The figures of a run as a short table.
pub(crate) fn report(summary: &Summary) -> String {
    let mut text = format!(
        "\n{}: {} steps, {:.3} s simulated in {:.1} s on {} threads",
        summary.case, summary.steps, summary.simulated_time_s, summary.wall_time_s, summary.threads
    );
    if let Some(particles) = summary.particles {
        let _ = write!(text, ", {} particles", particles.fluid);
    }
    if let Some(bytes) = summary.peak_memory_bytes {
        let _ = write!(text, ", {:.0} MB", bytes as f64 / 1e6);
    }
    let _ = writeln!(text, "\n\n{:<40} {:>12} {:<8} {:>12}", "found", "value", "", "theory");
    for finding in &summary.findings {
        let _ = writeln!(text, "{}", line(finding).trim_end());
    }
    let total: f64 = summary.stage_time_s.values().sum();
    let _ = writeln!(text, "\n{:<20} {:>9} {:>6}", "time per stage", "s", "%");
    let mut stages: Vec<_> = summary.stage_time_s.iter().collect();
    stages.sort_by(|a, b| b.1.total_cmp(a.1));
    for (stage, time) in stages {
        let share = if total > 0.0 { 100.0 * time / total } else { 0.0 };
        let _ = writeln!(text, "{stage:<20} {time:>9.2} {share:>6.1}");
    }
    text.push('\n');
    text
}

/// The range of every line's tension as a short table.
pub(crate) fn tensions(lines: &[LineRange]) -> String {
    let mut text = format!(
        "{:<16} {:>12} {:>12} {:>12} {:>8}\n",
        "tension, N/m", "least", "mean", "largest", "slack, %"
    );
    for LineRange { name, least, mean, largest, slack } in lines {
        let [least, mean, largest] = [least, mean, largest].map(|value| number(*value));
        let slack = 100.0 * slack;
        let _ = writeln!(text, "{name:<16} {least:>12} {mean:>12} {largest:>12} {slack:>8.1}");
    }
    text
}

fn line(finding: &Finding) -> String {
    let start = format!("{:<40} {:>12} {:<8}", finding.name, number(finding.value), finding.unit);
    match finding.theory {
        None => start,
        Some(theory) if theory.abs() > 1e-9 => {
            let difference = 100.0 * (finding.value / theory - 1.0);
            format!("{start} {:>12} {difference:>+7.2} %", number(theory))
        }
        Some(theory) => format!("{start} {:>12}", number(theory)),
    }
}

/// One trial of a bench in a few lines.
pub(crate) fn trial(index: usize, count: usize, settings: &str, trial: &Trial) -> String {
    let summary = &trial.summary;
    let mut text = format!("{index}/{count} {settings}: {:.1} s", summary.wall_time_s);
    match &summary.failure {
        Some(failure) => {
            let _ = write!(text, ", failed: {failure}");
        }
        None => {
            for (name, error) in &trial.errors {
                let _ = write!(text, "\n    {name:<40} {error:.3e}");
            }
        }
    }
    text.push('\n');
    text
}

/// The wave of a case in a few lines.
pub(crate) fn wave(case: &Case, theory: &Theory) -> String {
    let mut text = String::new();
    let mut add = |name: &str, value: Option<f64>, unit: &str| {
        if let Some(value) = value {
            let _ = writeln!(text, "{name:<28} {:>12} {unit}", number(value));
        }
    };
    let wave = theory.wave.as_deref();
    let celerity = wave.and_then(WaveTheory::celerity);
    let wavelength = wave.and_then(WaveTheory::wavelength);
    let extreme =
        |pick: fn(f64, f64) -> f64| theory.profile.iter().map(|row| row.elevation_m).reduce(pick);
    add("celerity", celerity, "m/s");
    add("wavelength", wavelength, "m");
    add(
        "particles in a wavelength",
        wavelength.map(|length| length / case.keys.numerics.particle_spacing_m),
        "",
    );
    add("highest in the profile", extreme(f64::max), "m");
    add("lowest in the profile", extreme(f64::min), "m");
    if let Some(maker) = &theory.wavemaker {
        let (low, high) = maker.motion().range(case.keys.end_time_s);
        add("paddle, furthest back", Some(low), "m");
        add("paddle, furthest forward", Some(high), "m");
    }
    text
}

/// Five significant digits, without an exponent where that is shorter.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let decimals = (4 - size.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

/// One line on a case that has passed its checks.
pub(crate) fn overview(case: &Case) -> String {
    let scene = &case.scene;
    let rows = scene.depth() / scene.fluid.numerics.particle_spacing;
    format!(
        "{}: ok, {} steps of {} s to t = {} s, {rows:.1} particles over the depth, {} bodies\n",
        case.name,
        scene.steps,
        scene.communication_step(),
        case.keys.end_time_s,
        scene.bodies.len(),
    )
}
