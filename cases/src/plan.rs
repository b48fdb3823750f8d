//! The plan of a case: every stage, kept or left out, with the reason.

use crate::case::{Case, TableName};
use crate::scene::{Body, Scene, has_rows};
use crate::simulation::fluid_stages;
use crate::waves::plan::WaveSource;
use std::fmt;

/// One line of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanLine {
    /// What part of the run the stage belongs to.
    pub group: &'static str,
    /// The stage.
    pub stage: String,
    /// Whether it is part of the run.
    pub kept: bool,
    /// Why, or why not.
    pub reason: String,
}

impl fmt::Display for PlanLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mark = if self.kept { "kept" } else { "left out" };
        write!(f, "{:<7} {:<20} {:<9} {}", self.group, self.stage, mark, self.reason)
    }
}

/// The plan of a case: the fluid's stages, then those of the bodies and of the output.
#[must_use]
pub fn plan(case: &Case) -> Vec<PlanLine> {
    let scene = &case.scene;
    let mut lines: Vec<PlanLine> = fluid_stages(scene)
        .into_iter()
        .map(|(stage, kept, reason)| PlanLine { group: "fluid", stage, kept, reason })
        .collect();
    lines.extend(body_stages(case));
    lines.extend(TableName::ALL.map(|table| table_line(case, table)));
    let output = &scene.output;
    let mut add = |stage: &str, kept: bool, reason: String| {
        lines.push(PlanLine { group: "output", stage: stage.to_owned(), kept, reason });
    };
    add("run.mcap", output.mcap, format!("output.mcap = {}", output.mcap));
    add(
        "particle frames",
        output.frames_every.is_some(),
        match output.frames_every {
            Some(steps) => format!("every {steps} steps"),
            None if output.mcap => "output.frame_interval_s = 0".to_owned(),
            None => "there is no run.mcap to hold them".to_owned(),
        },
    );
    let plot = output.plot && !(scene.bodies.is_empty() && scene.gauges.is_empty());
    add(
        "plot",
        plot,
        match (output.plot, plot) {
            (false, _) => "output.plot = false".to_owned(),
            (true, true) => "output.plot = true".to_owned(),
            (true, false) => "neither a body nor a gauge to plot".to_owned(),
        },
    );
    lines
}

fn body_stages(case: &Case) -> Vec<PlanLine> {
    let scene = &case.scene;
    let names: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
    let line = |stage: &str, kept: bool, yes: String, no: &str| PlanLine {
        group: "body",
        stage: stage.to_owned(),
        kept,
        reason: if kept { yes } else { no.to_owned() },
    };
    let none = scene.bodies.is_empty();
    let lines: Vec<&str> = scene.lines.iter().map(|line| line.name.as_str()).collect();
    let moored = format!("{}; {} substeps in a step", lines.join(", "), scene.substeps);
    let no_motion = if none { "no body in the case" } else { "every body is held" };
    let moving: Vec<String> = scene.bodies.iter().filter_map(moved_by).collect();
    let coupling = &case.keys.coupling;
    let rates = format!("{} : {}", coupling.fluid_substeps, coupling.body_substeps);
    let scheme = format!("{}, steps of water to bodies {rates}", coupling.scheme.name());
    vec![
        wavemaker(scene),
        line("rigid bodies", !none, names.join(", "), "no body in the case"),
        line("coupling", !none, scheme, "no body in the case"),
        line("motion", !moving.is_empty(), moving.join(", "), no_motion),
        line("moorings", !lines.is_empty(), moored, "no mooring in the case"),
    ]
}

/// The paddle, and whether it absorbs waves.
fn wavemaker(scene: &Scene) -> PlanLine {
    let (kept, reason) = match scene.wave.as_ref().map(|wave| wave.source) {
        Some(WaveSource::Paddle { absorption: Some(_), .. }) => (true, "with active absorption"),
        Some(WaveSource::Paddle { absorption: None, .. }) => (true, "without active absorption"),
        Some(WaveSource::Start { .. }) => (false, "the wave is in the tank at the start"),
        None => (false, "no wave in the case"),
    };
    let (stage, reason) = ("wavemaker".to_owned(), reason.to_owned());
    PlanLine { group: "body", stage, kept, reason }
}

/// What moves a body, in words.
fn moved_by(body: &Body) -> Option<String> {
    match body.motion {
        Some(_) => Some(format!("prescribed: {}", body.name)),
        None => body.is_free().then(|| format!("free: {}", body.name)),
    }
}

fn table_line(case: &Case, table: TableName) -> PlanLine {
    let scene = &case.scene;
    let kept = scene.output.tables.contains(&table);
    let reason = if kept {
        format!("every {} steps", scene.output.series_every)
    } else if has_rows(&case.keys, table) {
        "not in output.tables".to_owned()
    } else {
        match table {
            TableName::Motion | TableName::Loads => "no body in the case",
            TableName::Mooring => "no mooring in the case",
            TableName::Gauges => "no gauge in the case",
            TableName::Probes => "no probe in the case",
            TableName::Diagnostics => "nothing to write",
        }
        .to_owned()
    };
    PlanLine { group: "output", stage: format!("{}.csv", table.name()), kept, reason }
}
