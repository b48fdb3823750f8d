//! What a case asks for, as plain data: the wave, and what makes it.

use super::focused::{Focus, GroupForm, focused_group, repeat_period};
use super::irregular::irregular_sea;
use super::linear::LinearWaves;
use super::paddle::{ActiveAbsorption, Board, PaddleMotion, Wavemaker};
use super::solitary::{SolitaryTheory, SolitaryWave};
use super::spectrum::{Spectrum, SpectrumForm};
use super::stokes::StokesWave;
use super::stream_function::{Current, Extent, StreamFunctionWave};
use super::{StillWater, WaveError, WaveTheory};
use nalgebra::{Point2, Vector2};
use seakeep_fluid::setup::InitialFlow;
use std::sync::Arc;

/// A wave.
#[derive(Clone, Debug, PartialEq)]
pub enum WaveForm {
    /// Regular, first order.
    Linear {
        /// Height, m.
        height: f64,
        /// Period, s.
        period: f64,
    },
    /// Regular, second order.
    Stokes {
        /// Height, m.
        height: f64,
        /// Period, s.
        period: f64,
    },
    /// Regular, to any order, without mean mass transport.
    StreamFunction {
        /// Height, m.
        height: f64,
        /// Period, s.
        period: f64,
        /// Number of harmonics.
        order: usize,
    },
    /// Irregular.
    Irregular {
        /// The spectrum.
        spectrum: SpectrumPlan,
        /// Number of components.
        components: usize,
        /// Seed of phases and frequencies.
        seed: u64,
    },
    /// Focused group.
    Focused {
        /// How the amplitude is shared out.
        form: GroupPlan,
        /// Where, when and how high.
        focus: Focus,
        /// Number of components.
        components: usize,
    },
    /// Solitary.
    Solitary {
        /// Height, m.
        height: f64,
        /// Which theory.
        theory: SolitaryTheory,
    },
    /// What a recorded motion of the paddle makes: no theory says.
    Recorded {
        /// Times, s.
        times: Vec<f64>,
        /// Displacement (m) of a piston, angle (rad) of a flap.
        values: Vec<f64>,
    },
}

/// A spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumPlan {
    /// Its form.
    pub form: SpectrumForm,
    /// Significant height, m.
    pub significant_height: f64,
    /// Peak period, s.
    pub peak_period: f64,
    /// Highest frequency over that of the peak.
    pub highest: f64,
}

/// The form of a focused group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GroupPlan {
    /// In proportion to a spectrum.
    NewWave(SpectrumPlan),
    /// Equal steepness between two frequencies, Hz.
    EqualSteepness {
        /// Lowest frequency, Hz.
        lowest: f64,
        /// Highest frequency, Hz.
        highest: f64,
    },
}

/// How a wave gets into the tank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WaveSource {
    /// A paddle at the left end makes it, with full stroke after `ramp` (s).
    Paddle {
        /// The board.
        board: Board,
        /// Time to full stroke, s.
        ramp: f64,
        /// Return time of active absorption, s, where the paddle absorbs.
        absorption: Option<f64>,
    },
    /// It is there at the start, a crest at x = `crest` (m).
    Start {
        /// Place of a crest at t = 0, m.
        crest: f64,
    },
}

/// A wave and how it gets into the tank.
#[derive(Clone, Debug, PartialEq)]
pub struct WavePlan {
    /// The wave.
    pub form: WaveForm,
    /// Where it comes from.
    pub source: WaveSource,
}

impl SpectrumPlan {
    fn spectrum(&self) -> Result<Spectrum, WaveError> {
        Spectrum::new(self.form, self.significant_height, self.peak_period, self.highest)
    }
}

impl GroupPlan {
    fn form(&self) -> Result<GroupForm, WaveError> {
        Ok(match *self {
            Self::NewWave(plan) => GroupForm::NewWave(plan.spectrum()?),
            Self::EqualSteepness { lowest, highest } => {
                GroupForm::EqualSteepness { lowest, highest }
            }
        })
    }
}

impl WaveForm {
    /// Period by which ramps and the like are measured, s: of a regular wave, of the peak, of the
    /// middle of a band; none of a solitary wave or a recorded motion.
    #[must_use]
    pub fn reference_period(&self) -> Option<f64> {
        match self {
            Self::Linear { period, .. }
            | Self::Stokes { period, .. }
            | Self::StreamFunction { period, .. } => Some(*period),
            Self::Irregular { spectrum, .. } => Some(spectrum.peak_period),
            Self::Focused { form: GroupPlan::NewWave(spectrum), .. } => Some(spectrum.peak_period),
            Self::Focused { form: GroupPlan::EqualSteepness { lowest, highest }, .. } => {
                Some(2.0 / (lowest + highest))
            }
            Self::Solitary { .. } | Self::Recorded { .. } => None,
        }
    }

    /// Shortest period in the wave, s, as far as it is a sum of linear waves.
    #[must_use]
    pub fn shortest_period(&self) -> Option<f64> {
        match self {
            Self::Irregular { spectrum, .. }
            | Self::Focused { form: GroupPlan::NewWave(spectrum), .. } => {
                Some(spectrum.peak_period / spectrum.highest)
            }
            Self::Focused { form: GroupPlan::EqualSteepness { highest, .. }, .. } => {
                Some(highest.recip())
            }
            _ => self.reference_period(),
        }
    }

    /// Time after which a focused group comes again, s.
    #[must_use]
    pub fn repeat_period(&self) -> Option<f64> {
        match self {
            Self::Focused { form, components, .. } => {
                Some(repeat_period(form.form().ok()?, *components))
            }
            _ => None,
        }
    }
}

impl WavePlan {
    /// The wave as theory has it over the tank; `None` for a recorded motion.
    ///
    /// # Errors
    /// A wave that cannot be.
    pub fn theory(&self, water: StillWater) -> Result<Option<Arc<dyn WaveTheory>>, WaveError> {
        let wave: Arc<dyn WaveTheory> = match self.form {
            WaveForm::Linear { height, period } => {
                Arc::new(LinearWaves::regular(water, height, period)?)
            }
            WaveForm::Stokes { height, period } => {
                Arc::new(StokesWave::new(water, height, period)?)
            }
            WaveForm::StreamFunction { height, period, order } => {
                Arc::new(stream_function(water, height, period, order)?)
            }
            WaveForm::Irregular { spectrum, components, seed } => {
                Arc::new(irregular_sea(water, &spectrum.spectrum()?, components, seed)?)
            }
            WaveForm::Focused { form, focus, components } => {
                Arc::new(focused_group(water, form.form()?, focus, components)?)
            }
            WaveForm::Solitary { height, theory } => match self.source {
                WaveSource::Paddle { .. } => {
                    Arc::new(SolitaryWave::from_paddle(water, height, theory)?)
                }
                WaveSource::Start { crest } => {
                    return Ok(Some(Arc::new(SolitaryWave::new(water, height, theory, crest)?)));
                }
            },
            WaveForm::Recorded { .. } => return Ok(None),
        };
        Ok(Some(match self.source {
            WaveSource::Paddle { .. } => wave,
            WaveSource::Start { crest } => Arc::new(Moved { wave, by: crest }),
        }))
    }

    /// The water at the start, where the wave is there then.
    ///
    /// # Errors
    /// A wave that cannot be.
    pub fn initial_flow(&self, water: StillWater) -> Result<Option<WaveAtStart>, WaveError> {
        Ok(match self.source {
            WaveSource::Start { .. } => self.theory(water)?.map(WaveAtStart),
            WaveSource::Paddle { .. } => None,
        })
    }

    /// The paddle that makes the wave; `None` for one that is there at the start.
    ///
    /// # Errors
    /// A wave that cannot be, or that this paddle cannot make.
    pub fn wavemaker(&self, water: StillWater) -> Result<Option<Wavemaker>, WaveError> {
        let WaveSource::Paddle { board, ramp, absorption } = self.source else { return Ok(None) };
        let motion = match &self.form {
            WaveForm::Linear { height, period } => {
                let wave = LinearWaves::regular(water, *height, *period)?;
                PaddleMotion::linear(water, board, &wave, ramp)?
            }
            WaveForm::Stokes { height, period } => {
                let wave = StokesWave::new(water, *height, *period)?;
                PaddleMotion::regular(water, board, &wave, *period, 0.5 * height, ramp)?
            }
            WaveForm::StreamFunction { height, period, order } => {
                let wave = stream_function(water, *height, *period, *order)?;
                PaddleMotion::regular(water, board, &wave, *period, 0.5 * height, ramp)?
            }
            WaveForm::Irregular { spectrum, components, seed } => {
                let sea = irregular_sea(water, &spectrum.spectrum()?, *components, *seed)?;
                PaddleMotion::linear(water, board, &sea, ramp)?
            }
            WaveForm::Focused { form, focus, components } => {
                let group = focused_group(water, form.form()?, *focus, *components)?;
                PaddleMotion::linear(water, board, &group, ramp)?
            }
            WaveForm::Solitary { height, theory } => {
                let wave = SolitaryWave::from_paddle(water, *height, *theory)?;
                PaddleMotion::solitary(water, board, &wave)?
            }
            WaveForm::Recorded { times, values } => {
                PaddleMotion::series(water, board, times.clone(), values.clone(), ramp)?
            }
        };
        let absorption = match absorption {
            Some(time) => {
                let absorption = ActiveAbsorption::new(water, time)?;
                self.theory(water)?.map(|theory| (absorption, theory))
            }
            None => None,
        };
        Ok(Some(Wavemaker::new(motion, absorption)))
    }
}

/// In a closed flume.
fn stream_function(
    water: StillWater,
    height: f64,
    period: f64,
    order: usize,
) -> Result<StreamFunctionWave, WaveError> {
    let (extent, current) = (Extent::Period(period), Current::MassTransport(0.0));
    StreamFunctionWave::new(water, height, extent, current, order)
}

/// A wave as the water at the start.
#[derive(Clone, Debug)]
pub struct WaveAtStart(Arc<dyn WaveTheory>);

impl InitialFlow for WaveAtStart {
    fn elevation(&self, x: f64) -> f64 {
        self.0.elevation(x, 0.0)
    }

    fn velocity(&self, point: Point2<f64>) -> Vector2<f64> {
        self.0.velocity(point.x, point.y, 0.0)
    }
}

/// A wave moved along x.
#[derive(Debug)]
struct Moved {
    wave: Arc<dyn WaveTheory>,
    by: f64,
}

impl WaveTheory for Moved {
    fn elevation(&self, x: f64, time: f64) -> f64 {
        self.wave.elevation(x - self.by, time)
    }

    fn velocity(&self, x: f64, y: f64, time: f64) -> Vector2<f64> {
        self.wave.velocity(x - self.by, y, time)
    }

    fn celerity(&self) -> Option<f64> {
        self.wave.celerity()
    }

    fn wavelength(&self) -> Option<f64> {
        self.wave.wavelength()
    }
}
