//! A table: a CSV file that is complete up to the last row written.

use super::OutputError;
use super::rows::Row;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Larger than the rows of one sample, so that these reach the file at once and whole.
const BUFFER_BYTES: usize = 1 << 18;

/// A CSV file with a header.
#[derive(Debug)]
pub(super) struct Table {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl Table {
    /// Creates `<directory>/<table>.csv` with the header of `R`.
    pub(super) fn create<R: Row>(directory: &Path) -> Result<Self, OutputError> {
        let path = directory.join(R::TABLE).with_extension("csv");
        let file = File::create(&path).map_err(OutputError::at(&path))?;
        let mut builder = csv::WriterBuilder::new();
        let writer = builder.has_headers(false).buffer_capacity(BUFFER_BYTES).from_writer(file);
        let mut table = Self { path, writer };
        table.writer.write_record(R::COLUMNS).map_err(|error| table.failed(error))?;
        table.flush()?;
        Ok(table)
    }

    /// Adds the rows of one sample and hands them to the operating system.
    pub(super) fn write<R: Row>(
        &mut self,
        rows: impl Iterator<Item = R>,
    ) -> Result<(), OutputError> {
        for row in rows {
            self.writer.serialize(row).map_err(|error| self.failed(error))?;
        }
        self.flush()
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        self.writer.flush().map_err(OutputError::at(&self.path))
    }

    fn failed(&self, error: csv::Error) -> OutputError {
        OutputError::Write { path: self.path.clone(), source: error.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rows::{
        DiagnosticsRow, GaugesRow, LoadsRow, MooringRow, MotionRow, ProbesRow,
    };
    use super::*;

    /// The names of the fields of a row, as serde sees them.
    fn fields(row: &impl Row) -> Vec<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.serialize(row).unwrap();
        let text = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        text.lines().next().unwrap().split(',').map(str::to_owned).collect()
    }

    fn check<R: Row>(row: &R) {
        assert_eq!(fields(row), R::COLUMNS, "{}", R::TABLE);
    }

    #[test]
    fn the_columns_are_the_fields_in_their_order() {
        check(&MotionRow {
            time_s: 0.0,
            body: "body",
            sway_m: 0.0,
            heave_m: 0.0,
            roll_rad: 0.0,
            sway_velocity_m_s: 0.0,
            heave_velocity_m_s: 0.0,
            roll_rate_rad_s: 0.0,
            sway_acceleration_m_s2: 0.0,
            heave_acceleration_m_s2: 0.0,
            roll_acceleration_rad_s2: 0.0,
        });
        check(&LoadsRow {
            time_s: 0.0,
            body: "body",
            force_x_n_per_m: 0.0,
            force_y_n_per_m: 0.0,
            torque_n_m_per_m: 0.0,
        });
        check(&MooringRow {
            time_s: 0.0,
            line: "a",
            tension_n_per_m: 0.0,
            length_m: 0.0,
            fairlead_x_m: 0.0,
            fairlead_y_m: 0.0,
        });
        check(&GaugesRow { time_s: 0.0, gauge: "a", x_m: 0.0, elevation_m: None });
        check(&ProbesRow {
            time_s: 0.0,
            probe: "a",
            x_m: 0.0,
            y_m: 0.0,
            pressure_pa: None,
            velocity_x_m_s: None,
            velocity_y_m_s: None,
        });
        check(&DiagnosticsRow {
            time_s: 0.0,
            kinetic_energy_j_per_m: 0.0,
            potential_energy_j_per_m: 0.0,
            volume_error: 0.0,
            divergence_rms_per_s: 0.0,
            density_error_rms: 0.0,
            pressure_iterations: 0,
            pressure_residual: 0.0,
            particles_active: 0,
            load_evaluations: 0,
            coupling_residual: 0.0,
            power_bond_residual_j_per_m: 0.0,
        });
    }
}
