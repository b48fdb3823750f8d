//! Spectra of wind seas: Pierson & Moskowitz (1964) and JONSWAP (Hasselmann et al. 1973).

use super::quadrature::simpson;
use super::{WaveError, require, require_positive};
use serde::{Deserialize, Serialize};

/// The form of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SpectrumForm {
    /// Fully developed sea.
    PiersonMoskowitz,
    /// Growing sea, with a sharper peak.
    Jonswap {
        /// Peak enhancement γ, 1 to 10; 3.3 on average, 1 gives Pierson and Moskowitz's.
        peak_enhancement: f64,
    },
}

/// Lowest frequency of a spectrum over that of its peak: less than 1e-8 of the energy lies below.
pub const LOWEST: f64 = 0.5;

/// A spectrum of the elevation between a lowest and a highest frequency, scaled so that it has
/// its significant height within them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    form: SpectrumForm,
    /// Peak frequency, Hz.
    peak: f64,
    /// Lowest and highest frequency, Hz.
    band: (f64, f64),
    /// m²/Hz per unit of the bare form.
    scale: f64,
}

impl Spectrum {
    /// A spectrum of significant height 4 √m₀ = `significant_height` (m) whose peak is at
    /// 1/`peak_period` (s), cut off at `highest` times the peak frequency.
    ///
    /// # Errors
    /// Parameters out of range.
    pub fn new(
        form: SpectrumForm,
        significant_height: f64,
        peak_period: f64,
        highest: f64,
    ) -> Result<Self, WaveError> {
        require_positive("significant wave height (m)", significant_height)?;
        require_positive("peak period (s)", peak_period)?;
        let sound = (1.2..=10.0).contains(&highest);
        require(sound, "highest over peak frequency", highest, "1.2 to 10")?;
        if let SpectrumForm::Jonswap { peak_enhancement } = form {
            let sound = (1.0..=10.0).contains(&peak_enhancement);
            require(sound, "peak enhancement", peak_enhancement, "1 to 10")?;
        }
        let peak = peak_period.recip();
        let mut spectrum = Self { form, peak, band: (LOWEST * peak, highest * peak), scale: 1.0 };
        let (low, high) = spectrum.band;
        spectrum.scale = (0.25 * significant_height).powi(2) / spectrum.energy(low, high);
        Ok(spectrum)
    }

    /// Lowest and highest frequency, Hz.
    #[must_use]
    pub fn band(&self) -> (f64, f64) {
        self.band
    }

    /// Peak frequency, Hz.
    #[must_use]
    pub fn peak_frequency(&self) -> f64 {
        self.peak
    }

    /// Density at `frequency` (Hz), m²/Hz; 0 outside the band.
    #[must_use]
    pub fn density(&self, frequency: f64) -> f64 {
        if frequency < self.band.0 || frequency > self.band.1 {
            return 0.0;
        }
        let f = frequency / self.peak;
        let sea = f.powi(-5) * (-1.25 * f.powi(-4)).exp();
        let enhancement = match self.form {
            SpectrumForm::PiersonMoskowitz => 1.0,
            SpectrumForm::Jonswap { peak_enhancement } => {
                let width = if f <= 1.0 { 0.07 } else { 0.09 };
                peak_enhancement.powf((-0.5 * ((f - 1.0) / width).powi(2)).exp())
            }
        };
        self.scale * sea * enhancement
    }

    /// Variance of the elevation between two frequencies of the band (Hz), m².
    #[must_use]
    pub fn energy(&self, low: f64, high: f64) -> f64 {
        // Fine enough for the peak of JONSWAP whatever the interval.
        let panels = ((high - low) / (0.005 * self.peak)).ceil().max(2.0) as usize;
        // The ends of the band belong to it.
        let within = |f: f64| f.clamp(self.band.0, self.band.1);
        simpson(low, high, panels, |f| self.density(within(f)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pierson_moskowitz_has_its_closed_form() {
        // m0 of f⁻⁵ exp(−1.25 f⁻⁴) over all frequencies is 1/5, so S = 5 (Hs/4)² fp⁴ f⁻⁵ exp(...).
        let form = SpectrumForm::PiersonMoskowitz;
        let spectrum = Spectrum::new(form, 0.08, 1.5, 10.0).unwrap();
        let fp = 1.0 / 1.5f64;
        for f in [0.8 * fp, fp, 2.0 * fp] {
            let exact =
                5.0 * 0.02f64.powi(2) * fp.powi(4) * f.powi(-5) * (-1.25 * (fp / f).powi(4)).exp();
            assert!((spectrum.density(f) / exact - 1.0).abs() < 2e-4, "{f}");
        }
    }

    #[test]
    fn jonswap_peaks_and_keeps_its_height() {
        let pm = Spectrum::new(SpectrumForm::PiersonMoskowitz, 0.1, 2.0, 4.0).unwrap();
        let form = SpectrumForm::Jonswap { peak_enhancement: 3.3 };
        let jonswap = Spectrum::new(form, 0.1, 2.0, 4.0).unwrap();
        let (low, high) = jonswap.band();
        // A sum over other points than those of the scaling.
        let m0 = |s: &Spectrum| {
            (0..10_000)
                .map(|i| s.density(low + (high - low) * (f64::from(i) + 0.5) / 1e4))
                .sum::<f64>()
                * (high - low)
                / 1e4
        };
        assert!((4.0 * m0(&jonswap).sqrt() - 0.1).abs() < 1e-6);
        assert!((4.0 * m0(&pm).sqrt() - 0.1).abs() < 1e-6);
        // Hasselmann: γ is the ratio of the peaks before scaling, the energy ratio is about 1.52.
        let ratio = jonswap.density(0.5) / pm.density(0.5);
        assert!((ratio - 3.3 / 1.52).abs() < 0.05, "{ratio}");
        assert!(jonswap.density(0.5) > jonswap.density(0.49));
        assert!(jonswap.density(0.5) > jonswap.density(0.51));
    }

    #[test]
    fn ranges() {
        let form = SpectrumForm::Jonswap { peak_enhancement: 20.0 };
        assert!(Spectrum::new(form, 0.1, 2.0, 3.0).is_err());
        assert!(Spectrum::new(SpectrumForm::PiersonMoskowitz, 0.0, 2.0, 3.0).is_err());
        assert!(Spectrum::new(SpectrumForm::PiersonMoskowitz, 0.1, 2.0, 1.0).is_err());
    }
}
