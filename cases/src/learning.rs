//! The commands around the networks.

use crate::cli::{DatasetArguments, EvaluateArguments, TrainArguments};
use crate::{FAILED, Stop, refused, say, stop_on_signal, threads};
use seakeep::case::network;
use seakeep::dataset::{self, Campaign, GenerateError, Options};
use seakeep::evaluate::{self, EvaluateError};
use seakeep::output::OutputError;
use std::io::Write;
use std::time::{Duration, Instant};

/// Runs what is missing of a campaign.
pub(crate) fn dataset(arguments: &DatasetArguments) -> Result<(), Stop> {
    let campaign = Campaign::load(&arguments.campaign).map_err(refused)?;
    let mut planned = campaign.plan();
    if let Some(name) = arguments.case.iter().find(|name| planned.iter().all(|p| p.name != **name))
    {
        return Err(refused(format!("--case {name}: the campaign has no such case")));
    }
    planned.retain(|case| arguments.case.is_empty() || arguments.case.contains(&case.name));
    let options = Options { overrides: arguments.set.clone(), threads: threads(arguments.threads) };
    let stop = stop_on_signal()?;
    let (begun, count) = (Instant::now(), planned.len());
    let mut skipped = 0;
    for (index, case) in planned.iter().enumerate() {
        let mut last = 0;
        let mut observe = |part: f64| {
            let tenth = (10.0 * part) as usize;
            if !arguments.quiet && tenth > last {
                last = tenth;
                let done = (index - skipped) as f64 + part;
                let left = (count - skipped) as f64 - done;
                let left = begun.elapsed().mul_f64(left / done);
                show(&format!(
                    "case {} of {count}, {}: {:>3} %, {} left",
                    index + 1,
                    case.name,
                    10 * tenth,
                    clock(left),
                ));
            }
        };
        let made =
            dataset::generate(case, campaign.seed, &arguments.out, &options, &stop, &mut observe)
                .map_err(|error| match error {
                GenerateError::Case { .. } => refused(error),
                _ => Stop { message: error.to_string(), code: FAILED },
            })?;
        skipped += usize::from(!made);
    }
    if !arguments.quiet {
        show(&format!("{} cases made, {skipped} were there", count - skipped));
    }
    Ok(())
}

/// Trains a network.
#[cfg(feature = "torch")]
pub(crate) fn train(arguments: &TrainArguments) -> Result<(), Stop> {
    use seakeep::training::{self, TrainingError};
    use seakeep_learning::LearningError;

    let options = training::Options {
        out: arguments.out.clone(),
        device: arguments.device.clone(),
        threads: arguments.threads.get(),
    };
    let stop = stop_on_signal()?;
    let begun = Instant::now();
    let mut first = None;
    let mut observe = |row: &training::CurveRow, steps: u64| {
        // The steps of an earlier part of the training took no time in this one.
        let (before, then) = *first.get_or_insert((row.step, begun.elapsed()));
        let done = row.step.saturating_sub(before).max(1) as f64;
        let left = (begun.elapsed() - then).mul_f64((steps - row.step) as f64 / done);
        if !arguments.quiet {
            show(&format!(
                "step {:>6} of {steps}: loss {:.4}, skill {:.4}, on test frames {:.4}, residual left \
                 {:.4}, {} left",
                row.step,
                row.loss,
                row.training_skill,
                row.test_skill,
                row.test_residual,
                clock(left),
            ));
        }
    };
    let weights =
        training::train(&arguments.config, &options, &stop, &mut observe).map_err(|error| {
            match error {
                TrainingError::Output(_)
                | TrainingError::Interrupted(_)
                | TrainingError::Learning(LearningError::Diverged { .. }) => {
                    Stop { message: error.to_string(), code: FAILED }
                }
                _ => refused(error),
            }
        })?;
    if !arguments.quiet {
        show(&format!("weights in {}", weights.display()));
    }
    Ok(())
}

/// Training is not part of this build.
#[cfg(not(feature = "torch"))]
pub(crate) fn train(arguments: &TrainArguments) -> Result<(), Stop> {
    Err(refused(format!(
        "train {}: this program was built without the feature torch",
        arguments.config.display()
    )))
}

/// Measures a network.
pub(crate) fn evaluate(arguments: &EvaluateArguments) -> Result<(), Stop> {
    network(Some(&arguments.model)).map_err(refused)?;
    if arguments.campaign.is_none() && arguments.rollout.is_empty() && arguments.data.is_none() {
        return Err(refused("evaluate: name a --campaign, a case for a --rollout or --data"));
    }
    if let Some(data) = &arguments.data {
        on_device(arguments, data)?;
    }
    let campaign =
        arguments.campaign.as_deref().map(Campaign::load).transpose().map_err(refused)?;
    let out = &arguments.out;
    std::fs::create_dir_all(out)
        .map_err(|source| refused(OutputError::Write { path: out.clone(), source }))?;
    let threads = threads(arguments.threads);
    let weights = format!("pressure.weights={:?}", arguments.model.display().to_string());
    let stop = |error: EvaluateError| match error {
        EvaluateError::Case(_) | EvaluateError::NoTest => refused(error),
        _ => Stop { message: error.to_string(), code: FAILED },
    };
    if let Some(campaign) = campaign {
        let mut observe = |case: &str| show(&format!("single steps of {case}"));
        let overrides = [weights.clone()];
        let (skills, factors) =
            evaluate::single_steps(&campaign, arguments.steps, &overrides, threads, &mut observe)
                .map_err(stop)?;
        evaluate::write_skills(out, &skills).map_err(stop)?;
        evaluate::write_factors(out, &factors).map_err(stop)?;
        say("solver            skill  surface    walls     bulk  residual  ms/1000\n");
        for row in &skills {
            say(&format!(
                "{:<14} {:>8.5} {:>8.5} {:>8.5} {:>8.5} {:>9.2e} {:>8.4}\n",
                row.solver,
                row.skill,
                row.skill_surface,
                row.skill_walls,
                row.skill_bulk,
                row.residual,
                row.time_ms,
            ));
        }
        say("what the network leaves of errors: wavelength in spacings, e, all\n");
        for row in factors.iter().filter(|row| row.solver == "network") {
            let length = row.wavelength_spacings;
            say(&format!("{length:>5.0} {:>8.4} {:>8.4}\n", row.factor, row.left));
        }
    }
    let mut rows = Vec::new();
    let set = [&[weights], &arguments.set[..]].concat();
    for case in &arguments.rollout {
        /// Time between samples, s.
        const INTERVAL: f64 = 0.05;
        let mut observe = |solver: &str| show(&format!("{case}: {solver}"));
        let found = evaluate::rollout(case, &set, INTERVAL, threads, &mut observe).map_err(stop)?;
        for group in found.chunk_by(|a, b| a.solver == b.solver) {
            let Some(last) = group.last() else { continue };
            let mean = group.iter().filter_map(|row| row.error).sum::<f64>() / group.len() as f64;
            let ended = last.error.map_or("failed".to_owned(), |error| format!("{error:.2e}"));
            say(&format!(
                "{case}, {:<14} error {mean:.2e}, at the end {ended}, volume {:+.1e}, divergence \
                 {:.1e} 1/s, pressure {:.3} ms a step\n",
                last.solver, last.volume_error, last.divergence_rms_per_s, last.pressure_ms,
            ));
        }
        rows.extend(found);
        evaluate::write_rollouts(out, &rows).map_err(stop)?;
    }
    Ok(())
}

/// The network on a device beside the program's own inference.
#[cfg(feature = "torch")]
fn on_device(arguments: &EvaluateArguments, data: &std::path::Path) -> Result<(), Stop> {
    let threads = threads(arguments.threads);
    let row =
        evaluate::on_device(&arguments.model, data, &arguments.device, threads).map_err(refused)?;
    say(&format!(
        "libtorch, {}: {} frames, {} particles, largest difference to the program's own inference \
         {:.1e} of the largest correction, skill {:.5}\nms for a thousand particles: own {:.4}, libtorch \
         {:.4}, and {:.4} until a frame is there\n",
        arguments.device,
        row.frames,
        row.particles,
        row.difference,
        row.skill,
        row.own_ms,
        row.device_ms,
        row.transfer_ms,
    ));
    Ok(())
}

/// libtorch is not part of this build.
#[cfg(not(feature = "torch"))]
fn on_device(arguments: &EvaluateArguments, _data: &std::path::Path) -> Result<(), Stop> {
    Err(refused(format!(
        "evaluate --device {}: this program was built without the feature torch",
        arguments.device
    )))
}

/// Hours, minutes and seconds.
fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    format!("{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

fn show(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
