//! Frames: the pressure equation of one step with its exact solution, from which networks learn.

use crate::error::FluidError;
use crate::fields::Fields;
use crate::fluid::Fluid;
use crate::neighbours::BLOCK;
use crate::pressure::solver::{PressureSettings, Start};
use crate::sparse::SparseMatrix;
use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensorError, SafeTensors};
use std::collections::HashMap;
use thiserror::Error;

/// Tolerance of the pressure that a frame calls exact: residual relative to the right-hand side.
const EXACT: f64 = 1e-10;
/// Distance to a wall from which on all are alike, in spacings; Eq. (29) asks up to 6.
const FAR: f64 = 8.0;

/// The scales of a frame, in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scales {
    /// Time at the start of the step, s.
    pub time: f64,
    /// Particle spacing dx, m.
    pub spacing: f64,
    /// Time step dt, s.
    pub time_step: f64,
    /// Still-water depth D, m.
    pub depth: f64,
    /// Density ρ, kg/m³.
    pub density: f64,
    /// Gravitational acceleration g, m/s².
    pub gravity: f64,
}

/// The pressure equation of one step, A p = b with a unit diagonal, for n particles, together with
/// what a network may look at and what it should find.
///
/// Pressures are dynamic, p + ρ g (y − D); in the equation they are zero on the surface, whose
/// known pressure is part of b.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// The scales.
    pub scales: Scales,
    /// Position of each particle where the step is assembled, m: x and y in turn, 2 n.
    pub position: Vec<f32>,
    /// Velocity u* of each particle, m/s, 2 n.
    pub velocity: Vec<f32>,
    /// Ψ of Eq. (9b) at each particle, kg/(m³ s).
    pub source: Vec<f32>,
    /// Where each row of A begins among its off-diagonal entries, n + 1.
    pub row_start: Vec<u32>,
    /// Columns of the off-diagonal entries.
    pub column: Vec<u32>,
    /// The off-diagonal entries.
    pub value: Vec<f32>,
    /// What each row was divided by for its unit diagonal, n.
    pub divisor: Vec<f32>,
    /// 1 for a particle on the surface.
    pub on_surface: Vec<u8>,
    /// Number of wall particles around each particle, at most 255.
    pub walls: Vec<u8>,
    /// Distance of each particle to the nearest wetted wall particle in spacings, at most 8.
    pub wall_distance: Vec<f32>,
    /// Dynamic pressure of the step before at each particle, that on the surface included, Pa.
    pub last: Vec<f32>,
    /// Change of the dynamic pressure over the step before, Pa.
    pub change: Vec<f32>,
    /// b − A p of the last pressure, Pa.
    pub residual: Vec<f32>,
    /// Exact minus last pressure, Pa.
    pub target: Vec<f32>,
}

/// Tensors of a frame's file: name, which ends in the unit, and shape for n particles and m entries.
pub const TENSORS: [(&str, &str); 14] = [
    ("position_m", "n, 2"),
    ("velocity_m_s", "n, 2"),
    ("source_kg_m3_s", "n"),
    ("row_start", "n + 1"),
    ("column", "m"),
    ("value", "m"),
    ("divisor", "n"),
    ("on_surface", "n"),
    ("walls", "n"),
    ("wall_distance_spacings", "n"),
    ("last_pa", "n"),
    ("change_pa", "n"),
    ("residual_pa", "n"),
    ("target_pa", "n"),
];

/// What is wrong with a frame's file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// No safetensors file, or a truncated one.
    #[error("the frame cannot be read: {0}")]
    Unreadable(String),
    /// A scale is not there or no positive number.
    #[error("the frame's metadata have no number \"{0}\"")]
    Scale(&'static str),
    /// A tensor is not there, or not of the type it should have.
    #[error("the frame has no tensor {name} of type {dtype:?}")]
    Missing {
        /// Its name.
        name: &'static str,
        /// Its type.
        dtype: Dtype,
    },
    /// A tensor of another length than the particles ask for.
    #[error("tensor {name} of the frame has {found} values, {expected} expected")]
    Length {
        /// Its name.
        name: &'static str,
        /// Its length.
        found: usize,
        /// What it should be.
        expected: usize,
    },
    /// A tensor holds NaN or infinity, or a column that there is not.
    #[error("tensor {0} of the frame holds a value that cannot be")]
    Value(&'static str),
}

impl From<SafeTensorError> for FrameError {
    fn from(error: SafeTensorError) -> Self {
        Self::Unreadable(error.to_string())
    }
}

/// Names of the scales in the metadata, with their units.
const SCALES: [&str; 6] =
    ["time_s", "spacing_m", "time_step_s", "depth_m", "density_kg_m3", "gravity_m_s2"];

impl Scales {
    fn values(&self) -> [f64; 6] {
        [self.time, self.spacing, self.time_step, self.depth, self.density, self.gravity]
    }
}

impl Frame {
    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.on_surface.len()
    }

    /// Whether there is no particle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.on_surface.is_empty()
    }

    /// The pressure matrix A.
    pub(crate) fn matrix(&self) -> SparseMatrix {
        let mut matrix = SparseMatrix::default();
        matrix.blocks.resize_with(self.len().div_ceil(BLOCK), Default::default);
        for (block, rows) in matrix.blocks.iter_mut().enumerate() {
            rows.clear();
            for i in block * BLOCK..((block + 1) * BLOCK).min(self.len()) {
                let range = self.row_start[i] as usize..self.row_start[i + 1] as usize;
                let values = self.value[range.clone()].iter().map(|value| f64::from(*value));
                let entries = self.column[range].iter().copied().zip(values);
                rows.add_row(entries, f64::from(self.divisor[i]));
            }
        }
        matrix
    }

    /// The frame as a safetensors file.
    ///
    /// # Errors
    /// [`FrameError::Unreadable`] where it cannot be written as one.
    pub fn to_bytes(&self) -> Result<Vec<u8>, FrameError> {
        let floats = [
            ("position_m", &self.position, 2),
            ("velocity_m_s", &self.velocity, 2),
            ("source_kg_m3_s", &self.source, 1),
            ("value", &self.value, 1),
            ("divisor", &self.divisor, 1),
            ("wall_distance_spacings", &self.wall_distance, 1),
            ("last_pa", &self.last, 1),
            ("change_pa", &self.change, 1),
            ("residual_pa", &self.residual, 1),
            ("target_pa", &self.target, 1),
        ];
        let words = [("row_start", &self.row_start), ("column", &self.column)];
        let bytes = [("on_surface", &self.on_surface), ("walls", &self.walls)];
        let mut data = Vec::new();
        for (name, values, width) in floats {
            let shape = if width == 1 { vec![values.len()] } else { vec![values.len() / 2, 2] };
            let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            data.push((name, Dtype::F32, shape, raw));
        }
        for (name, values) in words {
            let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            data.push((name, Dtype::U32, vec![values.len()], raw));
        }
        for (name, values) in bytes {
            data.push((name, Dtype::U8, vec![values.len()], values.clone()));
        }
        let metadata: HashMap<String, String> = SCALES
            .iter()
            .zip(self.scales.values())
            .map(|(name, value)| ((*name).to_owned(), value.to_string()))
            .collect();
        let views = data
            .iter()
            .map(|(name, dtype, shape, raw)| {
                TensorView::new(*dtype, shape.clone(), raw).map(|view| (*name, view))
            })
            .collect::<Result<Vec<_>, _>>()?;
        Ok(safetensors::serialize(views, Some(metadata))?)
    }

    /// The frame in a safetensors file.
    ///
    /// # Errors
    /// [`FrameError`]: a frame that is returned is whole, and all its numbers are finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FrameError> {
        let (_, metadata) = SafeTensors::read_metadata(bytes)?;
        let metadata = metadata.metadata().clone().unwrap_or_default();
        let scale = |name: &'static str| {
            let value = metadata.get(name).and_then(|text| text.parse::<f64>().ok());
            value.filter(|value| value.is_finite() && *value >= 0.0).ok_or(FrameError::Scale(name))
        };
        let [time, spacing, time_step, depth, density, gravity] = SCALES.map(scale);
        let file = SafeTensors::deserialize(bytes)?;
        let raw = |name: &'static str, dtype| {
            let tensor = file.tensor(name).ok().filter(|tensor| tensor.dtype() == dtype);
            tensor.map(|tensor| tensor.data()).ok_or(FrameError::Missing { name, dtype })
        };
        let floats = |name| {
            let values: Vec<f32> = raw(name, Dtype::F32)?
                .as_chunks()
                .0
                .iter()
                .map(|bytes| f32::from_le_bytes(*bytes))
                .collect();
            let finite = values.iter().all(|value| value.is_finite());
            finite.then_some(values).ok_or(FrameError::Value(name))
        };
        let words = |name| {
            let raw = raw(name, Dtype::U32)?;
            Ok::<Vec<u32>, FrameError>(
                raw.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect(),
            )
        };
        let frame = Self {
            scales: Scales {
                time: time?,
                spacing: spacing?,
                time_step: time_step?,
                depth: depth?,
                density: density?,
                gravity: gravity?,
            },
            position: floats("position_m")?,
            velocity: floats("velocity_m_s")?,
            source: floats("source_kg_m3_s")?,
            row_start: words("row_start")?,
            column: words("column")?,
            value: floats("value")?,
            divisor: floats("divisor")?,
            on_surface: raw("on_surface", Dtype::U8)?.to_vec(),
            walls: raw("walls", Dtype::U8)?.to_vec(),
            wall_distance: floats("wall_distance_spacings")?,
            last: floats("last_pa")?,
            change: floats("change_pa")?,
            residual: floats("residual_pa")?,
            target: floats("target_pa")?,
        };
        frame.check()?;
        Ok(frame)
    }

    fn check(&self) -> Result<(), FrameError> {
        let (n, entries) = (self.len(), self.column.len());
        for (name, found, expected) in [
            ("position_m", self.position.len(), 2 * n),
            ("velocity_m_s", self.velocity.len(), 2 * n),
            ("source_kg_m3_s", self.source.len(), n),
            ("row_start", self.row_start.len(), n + 1),
            ("value", self.value.len(), entries),
            ("divisor", self.divisor.len(), n),
            ("walls", self.walls.len(), n),
            ("wall_distance_spacings", self.wall_distance.len(), n),
            ("last_pa", self.last.len(), n),
            ("change_pa", self.change.len(), n),
            ("residual_pa", self.residual.len(), n),
            ("target_pa", self.target.len(), n),
        ] {
            if found != expected {
                return Err(FrameError::Length { name, found, expected });
            }
        }
        let starts = &self.row_start;
        if starts.first() != Some(&0)
            || starts.last().map(|last| *last as usize) != Some(entries)
            || !starts.is_sorted()
        {
            return Err(FrameError::Value("row_start"));
        }
        if self.column.iter().any(|column| *column as usize >= n) {
            return Err(FrameError::Value("column"));
        }
        Ok(())
    }
}

/// What a frame is made of.
pub(crate) struct Assembled<'a> {
    pub(crate) scales: Scales,
    pub(crate) fields: Fields<'a>,
    pub(crate) matrix: &'a SparseMatrix,
    /// Ψ of Eq. (9b), kg/(m³ s).
    pub(crate) source: &'a [f64],
    /// Pressure of the step before, zero on the surface, its change over that step, and what of the
    /// equation it leaves, Pa.
    pub(crate) last: &'a [[f64; 1]],
    pub(crate) change: &'a [f64],
    pub(crate) residual: &'a [[f64; 1]],
}

impl Frame {
    /// The frame of an equation whose solution is not known: no `target`.
    pub(crate) fn of(assembled: &Assembled<'_>) -> Self {
        let Assembled { scales, fields, matrix, source, last, change, residual } = *assembled;
        let count = last.len();
        let weight = scales.density * scales.gravity;
        let surface_pressure = |i: usize| weight * (fields.position[i].y - scales.depth);
        let single = |values: &[f64]| values.iter().map(|value| *value as f32).collect();
        let rows = matrix.all_rows();
        Self {
            scales,
            position: pairs(fields.position.iter().map(|x| [x.x, x.y])),
            velocity: pairs(fields.velocity.iter().map(|u| [u.x, u.y])),
            source: single(source),
            row_start: rows.start,
            column: rows.column,
            value: rows.value,
            divisor: (0..count).map(|i| matrix.divisor(i)).collect(),
            on_surface: fields.on_surface.iter().map(|surface| u8::from(*surface)).collect(),
            walls: (0..count).map(|i| fields.wall_lists.of(i).len().min(255) as u8).collect(),
            wall_distance: wall_distances(fields),
            last: (last.iter().enumerate())
                .map(|(i, p)| if fields.on_surface[i] { surface_pressure(i) } else { p[0] })
                .map(|p| p as f32)
                .collect(),
            change: single(change),
            residual: residual.iter().map(|r| r[0] as f32).collect(),
            target: vec![0.0; count],
        }
    }
}

impl Fluid {
    /// Asks for the frame of the next step that is solved; [`Self::take_frame`] hands it over.
    pub fn record_frame(&mut self) {
        self.recording = true;
    }

    /// The frame that was asked for, once its step is solved.
    pub fn take_frame(&mut self) -> Option<Frame> {
        self.frame.take()
    }

    /// Keeps the frame of the step of `h` (s) whose pressure has just been solved, if one was asked
    /// for. Its pressure is solved once more, to 1e-10.
    pub(crate) fn keep_frame(&mut self, h: f64) -> Result<(), FluidError> {
        if !std::mem::take(&mut self.recording) {
            return Ok(());
        }
        let start = self.last_pressure();
        let exact = self.exact_pressure(h)?;
        let mut product = vec![[0.0]; start.len()];
        let rhs = &self.work.rhs;
        let rows = 0..start.len();
        self.work.matrix.multiply::<1, 1>(
            rows,
            &start,
            &mut product,
            &mut Vec::new(),
            |i, r, _| {
                r[0] = rhs[i][0] - r[0];
            },
        );
        let particles = &self.state.particles;
        let mut frame = Frame::of(&Assembled {
            scales: self.scales(h),
            fields: Self::fields(&self.setup, particles, &self.walls, &self.work),
            matrix: &self.work.matrix,
            source: &self.work.source,
            last: &start,
            change: &particles.pressure_change,
            residual: &product,
        });
        frame.target = exact.iter().zip(&start).map(|(p, last)| (p[0] - last[0]) as f32).collect();
        self.frame = Some(frame);
        Ok(())
    }

    /// The scales of a step of `h` (s).
    pub(crate) fn scales(&self, h: f64) -> Scales {
        let water = &self.setup.water;
        Scales {
            time: self.state.time,
            spacing: self.setup.numerics.particle_spacing,
            time_step: h,
            depth: water.depth,
            density: water.density,
            gravity: water.gravity,
        }
    }

    /// The solution of the assembled equation to 1e-10, Pa.
    pub(crate) fn exact_pressure(&mut self, h: f64) -> Result<Vec<[f64; 1]>, FluidError> {
        let settings = PressureSettings {
            start: Start::Given,
            tolerance: EXACT,
            divergence_tolerance: 0.0,
            ..PressureSettings::default()
        };
        let (start, mut rival) = (self.work.solution.clone(), self.rival(settings, None));
        self.solve_again(h, start, &mut rival).map(|(_, exact)| exact)
    }
}

/// Distance of each particle to the nearest wall that bounds the water, in spacings.
fn wall_distances(fields: Fields) -> Vec<f32> {
    let (walls, dx) = (fields.walls, fields.spacing);
    let mut wet: Vec<_> =
        (0..walls.len()).filter(|&w| walls.activity[w] > 0.0).map(|w| walls.position[w]).collect();
    wet.sort_by(|a, b| a.x.total_cmp(&b.x));
    let distance = |x: &nalgebra::Point2<f64>| {
        let from = wet.partition_point(|wall| wall.x < x.x - FAR * dx);
        let near = wet[from..].iter().take_while(|wall| wall.x <= x.x + FAR * dx);
        let square = near.map(|wall| (wall - x).norm_squared()).fold(f64::INFINITY, f64::min);
        (square.sqrt() / dx).min(FAR) as f32
    };
    fields.position.iter().map(distance).collect()
}

fn pairs(values: impl Iterator<Item = [f64; 2]>) -> Vec<f32> {
    values.flat_map(|pair| pair.map(|value| value as f32)).collect()
}
