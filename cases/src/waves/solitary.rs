//! Solitary waves: Boussinesq, third order (Grimshaw 1971) and exact.

use super::solitary_exact::ExactSolitary;
use super::{StillWater, WaveError, WaveTheory, require, require_positive};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// The highest solitary wave over the depth (Miche's limit for them, Hunter & Vanden-Broeck 1983).
const HIGHEST: f64 = 0.833_197;

/// The highest wave over the depth that the exact solution is computed for: speed and height rise
/// together only up to here.
pub const HIGHEST_EXACT: f64 = 0.7;

/// Which theory gives the form of a solitary wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolitaryTheory {
    /// η = H sech²(√(3H/4D³) X), c = √(g (D + H)).
    Boussinesq,
    /// Third order in H/D, Grimshaw (1971).
    ThirdOrder,
    /// The solution of the full equations.
    Exact,
}

#[derive(Clone, Debug)]
enum Profile {
    Boussinesq,
    ThirdOrder,
    Exact(Box<ExactSolitary>),
}

/// A solitary wave that travels along x.
#[derive(Clone, Debug)]
pub struct SolitaryWave {
    water: StillWater,
    height: f64,
    celerity: f64,
    /// Decay rate of the tails, 1/m: α for sech² α X.
    outskirt: f64,
    profile: Profile,
    /// Place of the crest at t = 0, m.
    crest: f64,
}

impl SolitaryWave {
    /// The wave of `height` (m) with its crest at x = `crest` (m) at t = 0.
    ///
    /// # Errors
    /// Parameters out of range; a wave above 0.833 depths, which breaks, or above
    /// [`HIGHEST_EXACT`] depths for the exact theory; an exact solution that does not converge.
    pub fn new(
        water: StillWater,
        height: f64,
        theory: SolitaryTheory,
        crest: f64,
    ) -> Result<Self, WaveError> {
        water.validate()?;
        require_positive("wave height (m)", height)?;
        require(crest.is_finite(), "place of the crest (m)", crest, "a finite number")?;
        let (depth, e) = (water.depth, height / water.depth);
        if e > HIGHEST {
            let limit = HIGHEST * depth;
            return Err(WaveError::Breaking { height, limit, length: None, depth });
        }
        let first_order = (0.75 * e).sqrt();
        let (froude, rate, profile) = match theory {
            SolitaryTheory::Boussinesq => ((1.0 + e).sqrt(), first_order, Profile::Boussinesq),
            SolitaryTheory::ThirdOrder => (
                froude_of_third_order(e),
                first_order * (1.0 - 0.625 * e + 71.0 / 128.0 * e * e),
                Profile::ThirdOrder,
            ),
            SolitaryTheory::Exact => {
                let allowed = format!(
                    "at most {:.4} for the exact solitary wave in water {depth} m deep",
                    HIGHEST_EXACT * depth
                );
                require(e <= HIGHEST_EXACT, "wave height (m)", height, &allowed)?;
                let found = ExactSolitary::new(e)?;
                (found.froude(), 0.5 * found.tail_rate(), Profile::Exact(Box::new(found)))
            }
        };
        let celerity = froude * water.long_wave_speed();
        Ok(Self { water, height, celerity, outskirt: rate / depth, profile, crest })
    }

    /// Part of its height that the elevation has at the paddle when a paddle begins to make it.
    pub const START: f64 = 1e-4;

    /// The wave that a paddle at x = 0 makes from t = 0: its crest starts where the elevation at
    /// the paddle is [`Self::START`] of the height.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_paddle(
        water: StillWater,
        height: f64,
        theory: SolitaryTheory,
    ) -> Result<Self, WaveError> {
        let mut wave = Self::new(water, height, theory, 0.0)?;
        wave.crest = -wave.reach(Self::START);
        Ok(wave)
    }

    /// Height H, m.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Rate at which the tails rise and fall: α for sech² α X, 1/m.
    pub(super) fn tail_rate(&self) -> f64 {
        self.outskirt
    }

    /// Distance (m) from the crest at which the elevation has fallen to `part` of the height.
    #[must_use]
    pub fn reach(&self, part: f64) -> f64 {
        // sech² α X = part, and then by bisection: the tails of the three differ a little.
        let mut far = 2.0 * (2.0 / part.sqrt()).ln() / self.outskirt;
        let mut near = 0.0;
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            if self.form(middle) > part * self.height {
                near = middle;
            } else {
                far = middle;
            }
        }
        far
    }

    /// Elevation at the distance `x` (m) from the crest, m.
    fn form(&self, x: f64) -> f64 {
        let (depth, e) = (self.water.depth, self.height / self.water.depth);
        match &self.profile {
            Profile::Boussinesq => self.height * sech_squared(self.outskirt * x),
            Profile::ThirdOrder => {
                let s = sech_squared(self.outskirt * x);
                let t = 1.0 - s;
                let third = e * s * t * (0.625 - 101.0 / 80.0 * s);
                self.height * (s - 0.75 * e * s * t + e * third)
            }
            Profile::Exact(wave) => depth * wave.elevation(x / depth),
        }
    }

    /// Velocity at the distance `x` from the crest and `y` above the bed, m/s.
    fn flow(&self, x: f64, y: f64) -> Vector2<f64> {
        let speed = self.water.long_wave_speed();
        let depth = self.water.depth;
        match &self.profile {
            Profile::Boussinesq => self.boussinesq_flow(x, y),
            Profile::ThirdOrder => {
                speed * third_order_flow(self.height / depth, self.outskirt * x, y / depth)
            }
            Profile::Exact(wave) => speed * wave.velocity(x / depth, y / depth),
        }
    }

    /// The velocity that goes with the elevation: its mean over the depth is c η/(D + η), which
    /// conserves mass; its profile is the parabola that makes it irrotational as far as the
    /// theory goes, u = ū + ((D + η)²/6 − y²/2) ū_xx; v follows from continuity.
    fn boussinesq_flow(&self, x: f64, y: f64) -> Vector2<f64> {
        let (depth, a) = (self.water.depth, self.outskirt);
        let s = sech_squared(a * x);
        let t = (a * x).tanh();
        // η and its derivatives.
        let n0 = self.height * s;
        let n1 = -2.0 * a * n0 * t;
        let n2 = a * a * n0 * (4.0 - 6.0 * s);
        let n3 = a * a * n1 * (4.0 - 12.0 * s);
        // ū = c (1 − D/d) with d = D + η.
        let d = depth + n0;
        let f = self.celerity * depth / (d * d);
        let u0 = self.celerity * n0 / d;
        let u1 = f * n1;
        let u2 = f * (n2 - 2.0 * n1 * n1 / d);
        let u3 = f * (n3 - 6.0 * n1 * n2 / d + 6.0 * n1.powi(3) / (d * d));
        Vector2::new(
            u0 + (d * d / 6.0 - 0.5 * y * y) * u2,
            -y * u1 - (d * d / 6.0 * y - y.powi(3) / 6.0) * u3 - d * n1 / 3.0 * y * u2,
        )
    }
}

fn sech_squared(x: f64) -> f64 {
    let e = (-2.0 * x.abs()).exp();
    4.0 * e / (1.0 + e).powi(2)
}

/// c/√(g D) to third order in `e` = H/D.
pub(super) fn froude_of_third_order(e: f64) -> f64 {
    (1.0 + e * (1.0 + e * (-0.05 - 3.0 / 70.0 * e))).sqrt()
}

/// Grimshaw's (1971) velocity over √(g D) at `ax` = α X, `y` in depths.
fn third_order_flow(e: f64, ax: f64, y: f64) -> Vector2<f64> {
    let s = sech_squared(ax);
    let (s2, s3) = (s * s, s * s * s);
    let (y2, y4) = (y * y, y.powi(4));
    let u = e * s
        - e.powi(2) * (-0.25 * s + s2 + y2 * (1.5 * s - 2.25 * s2))
        - e.powi(3)
            * (0.475 * s + 0.2 * s2 - 1.2 * s3
                + y2 * (-1.5 * s - 3.75 * s2 + 7.5 * s3)
                + y4 * (-0.375 * s + 2.8125 * s2 - 2.8125 * s3));
    let v = e * s
        - e.powi(2) * (0.375 * s + 2.0 * s2 + y2 * (0.5 * s - 1.5 * s2))
        - e.powi(3)
            * (49.0 / 640.0 * s - 0.85 * s2 - 3.6 * s3
                + y2 * (-0.8125 * s - 1.5625 * s2 + 7.5 * s3)
                + y4 * (-0.075 * s + 1.125 * s2 - 1.6875 * s3));
    Vector2::new(u, (3.0 * e).sqrt() * ax.tanh() * y * v)
}

impl WaveTheory for SolitaryWave {
    fn elevation(&self, x: f64, time: f64) -> f64 {
        self.form(x - self.crest - self.celerity * time)
    }

    fn velocity(&self, x: f64, y: f64, time: f64) -> Vector2<f64> {
        self.flow(x - self.crest - self.celerity * time, y)
    }

    fn celerity(&self) -> Option<f64> {
        Some(self.celerity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::tests::{assert_potential_flow, surface_residual};
    use SolitaryTheory::{Boussinesq, Exact, ThirdOrder};

    const WATER: StillWater = StillWater { depth: 0.25, gravity: 9.81 };

    fn wave(part: f64, theory: SolitaryTheory) -> SolitaryWave {
        SolitaryWave::new(WATER, part * WATER.depth, theory, 0.0).unwrap()
    }

    fn froude(part: f64, theory: SolitaryTheory) -> f64 {
        wave(part, theory).celerity().unwrap() / WATER.long_wave_speed()
    }

    #[test]
    fn exact_wave_of_the_reference() {
        // The abscissae of the reference are asymmetric by up to 3e-3, an error linear in x: the
        // mean of the two sides is free of it.
        let found = wave(0.32, Exact);
        let text = include_str!("../../reference/waves/solitary_exact_0.32.csv");
        let number = |cell: &str| cell.parse::<f64>().unwrap();
        let rows: Vec<(f64, f64)> = text
            .lines()
            .skip(1)
            .map(|line| line.split_once(',').unwrap())
            .map(|(x, eta)| (number(x), number(eta)))
            .collect();
        let crest = rows.iter().position(|(x, _)| *x == 0.0).unwrap();
        let mut worst = 0.0f64;
        for n in 1..=crest {
            let (left, right) = (rows[crest - n], rows[crest + n]);
            assert!((left.1 - right.1).abs() < 1e-8);
            let x = 0.5 * (right.0 - left.0);
            worst = worst.max((found.elevation(x * 0.25, 0.0) / 0.25 - left.1).abs());
        }
        assert_eq!(rows.len(), 370);
        // What its quadrature of the abscissae leaves: 2e-6 depths.
        assert!(worst < 3e-6, "{worst}");
    }

    #[test]
    fn celerities_of_the_independent_calculation() {
        for (part, exact, boussinesq, third) in [
            (0.20, 1.094_345, 1.095_445, 1.094_375),
            (0.24, 1.111_927, 1.113_553, 1.111_993),
            (0.27, 1.124_842, 1.126_943, 1.124_950),
            (0.32, 1.145_847, 1.148_913, 1.146_070),
            (0.40, 1.178_075, 1.183_216, 1.178_668),
        ] {
            assert!((froude(part, Exact) - exact).abs() < 1e-6, "{}", froude(part, Exact));
            assert!((froude(part, Boussinesq) - boussinesq).abs() < 1e-6);
            assert!((froude(part, ThirdOrder) - third).abs() < 1e-6);
        }
    }

    #[test]
    fn exact_wave_is_a_potential_flow_that_follows_its_surface() {
        for part in [0.05, 0.32, 0.6, HIGHEST_EXACT] {
            let found = wave(part, Exact);
            assert!((found.elevation(0.0, 0.0) / WATER.depth - part).abs() < 1e-8, "{part}");
            assert_potential_flow(&found, 0.25, 0.1, 0.0);
            for x in [0.03, 0.1, 0.4] {
                let residual = surface_residual(&found, 0.25, x, 0.0);
                assert!(residual < 1e-5, "{residual} at x = {x}, H/D = {part}");
                // Bernoulli in the frame that moves with the wave.
                let elevation = found.elevation(x, 0.0);
                let u =
                    found.velocity(x, 0.25 + elevation, 0.0) - Vector2::new(found.celerity, 0.0);
                let head = 0.5 * (u.norm_squared() - found.celerity.powi(2)) + 9.81 * elevation;
                assert!(head.abs() < 1e-6, "{head} at x = {x}, H/D = {part}");
            }
        }
    }

    #[test]
    fn third_order_velocity_is_right_to_third_order() {
        // Its distance from the exact velocity falls with the fourth power of the height.
        let error = |part: f64| {
            let (found, exact) = (wave(part, ThirdOrder), wave(part, Exact));
            let scaled = 0.25 / (0.75 * part).sqrt();
            let mut worst = 0.0f64;
            for x in [0.0, 0.4, 1.0, 1.7] {
                for y in [0.0, 0.12, 0.25] {
                    let (a, b) = (found.flow(x * scaled, y), exact.flow(x * scaled, y));
                    worst = worst.max((a - b).norm());
                }
            }
            worst
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!(order > 3.6, "order {order}");
    }

    #[test]
    fn boussinesq_velocity_conserves_mass_and_approaches_the_exact_one() {
        let found = wave(0.3, Boussinesq);
        for x in [0.05, 0.3] {
            assert!(surface_residual(&found, 0.25, x, 0.0) < 1e-6);
        }
        let error = |part: f64| {
            let (found, exact) = (wave(part, Boussinesq), wave(part, Exact));
            let scaled = 0.25 / (0.75 * part).sqrt();
            (found.flow(0.6 * scaled, 0.1) - exact.flow(0.6 * scaled, 0.1)).norm()
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!(order > 1.7, "order {order}");
    }

    #[test]
    fn reach_and_refusals() {
        for theory in [Boussinesq, ThirdOrder, Exact] {
            let found = wave(0.3, theory);
            let x = found.reach(1e-3);
            assert!((found.elevation(x, 0.0) / found.elevation(0.0, 0.0) - 1e-3).abs() < 1e-9);
        }
        for theory in [Boussinesq, ThirdOrder, Exact] {
            let error = SolitaryWave::new(WATER, 0.22, theory, 0.0).unwrap_err();
            assert!(matches!(error, WaveError::Breaking { length: None, .. }), "{error}");
        }
        assert!(SolitaryWave::new(WATER, 0.18, Exact, 0.0).is_err());
    }
}
