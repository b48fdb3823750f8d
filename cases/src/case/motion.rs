//! The motions that a case prescribes: formulas, and files beside the case.

use super::checks::Checker;
use super::library::shipped;
use super::source::Source;
use super::{BodyKeys, CaseKeys, MotionKeys, Problem, RotationKeys, TranslationKeys};
use crate::motion_file;
use crate::scene::Motion;
use nalgebra::Point2;
use seakeep_body::{BodyError, Harmonic, Oscillation, TimeSeries};
use std::path::Path;

/// The motion of each body, where it is prescribed. Puts these bodies where their motions start,
/// and makes the paths of files absolute; they are relative to
/// `folder`, and one that is not there may be one of those that come with the program.
///
/// # Errors
/// All motions that cannot be read or followed.
pub(super) fn prescribed(
    keys: &mut CaseKeys,
    folder: &Path,
    source: &Source,
) -> Result<Vec<Option<Motion>>, Vec<Problem>> {
    let mut check = Checker::new(source);
    let end_time = keys.end_time_s;
    let mut motions = Vec::new();
    for (index, body) in keys.body.iter_mut().enumerate() {
        let at = match &body.motion {
            Some(MotionKeys { file: Some(_), .. }) => format!("body[{index}].motion.file"),
            _ => format!("body[{index}].motion"),
        };
        let motion = body.motion.take().map(|mut motion| {
            let read = read(body, &mut motion, folder, end_time);
            body.motion = Some(motion);
            read
        });
        motions.push(match motion.transpose() {
            Ok(motion) => motion,
            Err(reason) => {
                check.require(false, &at, || reason);
                None
            }
        });
    }
    if check.problems.is_empty() { Ok(motions) } else { Err(check.problems) }
}

/// The motion of one body, which is put where it starts.
fn read(
    body: &mut BodyKeys,
    keys: &mut MotionKeys,
    folder: &Path,
    end_time: f64,
) -> Result<Motion, String> {
    let words = |error: BodyError| error.to_string();
    let rest = Point2::from(*body.equilibrium_m.get_or_insert(body.position_m));
    let motion = match &keys.file {
        Some(file) => {
            let path = folder.join(file);
            let known = shipped(folder, file);
            let series = match known {
                Some(text) => motion_file::parse(text.as_bytes(), &path, &body.name),
                None => motion_file::read(&path, &body.name),
            };
            let series = series.map_err(|error| error.to_string())?;
            let series = TimeSeries::new(rest, series.times, &series.samples)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            let [start, end] = series.span();
            if start > 0.0 || end < end_time {
                return Err(format!(
                    "{}: the motion lasts from {start} to {end} s, the run from 0 to {end_time} s",
                    path.display()
                ));
            }
            if known.is_none() {
                keys.file = Some(std::path::absolute(&path).map_err(|error| error.to_string())?);
            }
            Motion::Series(series)
        }
        None => {
            let degrees = [
                keys.sway.as_ref().map(translation),
                keys.heave.as_ref().map(translation),
                keys.roll.as_ref().map(rotation),
            ];
            Motion::Harmonic(Harmonic::new(rest, 0.0, degrees, keys.ramp_s).map_err(words)?)
        }
    };
    let start = motion.kinematics(0.0).map_err(words)?;
    body.position_m = start.position.into();
    body.angle_deg = start.angle.to_degrees();
    Ok(motion)
}

fn translation(keys: &TranslationKeys) -> Oscillation {
    let phase = keys.phase_deg.to_radians();
    Oscillation { amplitude: keys.amplitude_m, period: keys.period_s, phase }
}

fn rotation(keys: &RotationKeys) -> Oscillation {
    let (amplitude, phase) = (keys.amplitude_deg.to_radians(), keys.phase_deg.to_radians());
    Oscillation { amplitude, period: keys.period_s, phase }
}
