//! Writing while a run goes on.

use super::OutputError;
use super::recording::Recording;
use super::rows::{
    self, DiagnosticsRow, GaugesRow, LoadsRow, MooringRow, MotionRow, ProbesRow, Row,
};
use super::table::Table;
use crate::case::{Case, TableName};
use crate::scene::Scene;
use crate::simulation::{FramePoint, Sample};
use std::path::Path;

/// The open files of a run: those that the case asks for, and no others.
pub struct Recorder {
    tables: Vec<(TableName, Table)>,
    recording: Option<Recording>,
}

impl Recorder {
    /// Opens the files of `case` in `directory`, which exists. `resolved` is the resolved case
    /// as text.
    ///
    /// # Errors
    /// When a file cannot be created.
    pub fn create(directory: &Path, case: &Case, resolved: &str) -> Result<Self, OutputError> {
        let output = &case.scene.output;
        let open = |table: &TableName| {
            let open = match table {
                TableName::Motion => Table::create::<MotionRow<'_>>,
                TableName::Loads => Table::create::<LoadsRow<'_>>,
                TableName::Mooring => Table::create::<MooringRow<'_>>,
                TableName::Gauges => Table::create::<GaugesRow<'_>>,
                TableName::Probes => Table::create::<ProbesRow<'_>>,
                TableName::Diagnostics => Table::create::<DiagnosticsRow>,
            };
            Ok((*table, open(directory)?))
        };
        let tables = output.tables.iter().map(open).collect::<Result<_, OutputError>>()?;
        let recording = match output.mcap {
            true => Some(Recording::create(&directory.join("run.mcap"), resolved)?),
            false => None,
        };
        Ok(Self { tables, recording })
    }

    /// Adds one sample to every table and to the recording.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn sample(&mut self, scene: &Scene, sample: &Sample) -> Result<(), OutputError> {
        let recording = &mut self.recording;
        for (name, table) in &mut self.tables {
            let time = sample.time;
            match name {
                TableName::Motion => write(table, recording, time, || rows::motion(scene, sample))?,
                TableName::Loads => write(table, recording, time, || rows::loads(scene, sample))?,
                TableName::Mooring => {
                    write(table, recording, time, || rows::mooring(scene, sample))?;
                }
                TableName::Gauges => write(table, recording, time, || rows::gauges(scene, sample))?,
                TableName::Probes => write(table, recording, time, || rows::probes(scene, sample))?,
                TableName::Diagnostics => {
                    write(table, recording, time, || std::iter::once(sample.diagnostics))?;
                }
            }
        }
        Ok(())
    }

    /// Adds a frame of particles to the recording.
    ///
    /// # Errors
    /// When the recording cannot be written.
    pub fn frame(&mut self, time: f64, points: &[FramePoint]) -> Result<(), OutputError> {
        self.recording.as_mut().map_or(Ok(()), |recording| recording.frame(time, points))
    }

    /// Closes every file.
    ///
    /// # Errors
    /// When the index of the recording cannot be written.
    pub fn finish(self) -> Result<(), OutputError> {
        self.recording.map_or(Ok(()), Recording::finish)
    }
}

fn write<R: Row, I: Iterator<Item = R>>(
    table: &mut Table,
    recording: &mut Option<Recording>,
    time: f64,
    rows: impl Fn() -> I,
) -> Result<(), OutputError> {
    if let Some(recording) = recording {
        for row in rows() {
            recording.row(time, &row)?;
        }
    }
    table.write(rows())
}
