//! The residual network: its coarse level against a direct solve, its correction factor against the
//! stability bounds, and weights files that are none.

use crate::network::lattice::{self, Around, Coarse, LEAST_DIAGONAL, Places};
use crate::network::residual::{Level, Residual};
use crate::network::{Network, NetworkError, Weights};
use crate::pressure::solver::SolverKind;
use crate::sparse::{Row, SparseMatrix};
use crate::tests::krylov::{Grid, times};
use crate::tests::scatter;
use nalgebra::{Complex, DMatrix, DVector, Matrix3, Point2};

const SPACING: f64 = 0.02;
const GRID: Grid = Grid { columns: 30, rows: 17 };

/// A small tank: its equation, its particles, jittered by a tenth of a spacing, in their cells.
struct Tank {
    matrix: SparseMatrix,
    places: Places,
    coarse: Coarse,
}

impl Tank {
    fn new() -> Self {
        let matrix = GRID.poisson();
        let positions: Vec<_> = (0..GRID.len() as i64)
            .map(|i| {
                let (column, row) = (i / GRID.rows, i % GRID.rows);
                let at = |cell: i64, salt| (cell as f64 + 0.5 + 0.1 * scatter(i, salt)) * SPACING;
                Point2::new(at(column, 5), at(row, 6))
            })
            .collect();
        let (mut places, mut coarse) = (Places::default(), Coarse::default());
        places.find(&positions, SPACING, lattice::shape(&positions, SPACING));
        coarse.factorize(&places, &matrix);
        Self { matrix, places, coarse }
    }

    /// What the network leaves of the error `v`: v − G A v.
    fn left(&mut self, v: &[f64]) -> Vec<f64> {
        let entries: Vec<_> = v.iter().map(|v| [*v]).collect();
        let r: Vec<f32> = times(&self.matrix, &entries).iter().map(|r| r[0] as f32).collect();
        let change = self.correction(&r);
        v.iter().zip(change).map(|(v, change)| v - f64::from(change)).collect()
    }

    fn correction(&mut self, r: &[f32]) -> Vec<f32> {
        let Weights::Residual(weights) = Network::shipped().unwrap().0 else { unreachable!() };
        let mut gates = Vec::new();
        weights.all_gates(&self.matrix, &self.places, |_| 0, &mut gates);
        let level = Level { places: &self.places, coarse: &self.coarse, gates: &gates };
        let residual = |i: usize, _: Row<'_>, _: &[_]| [f64::from(r[i]), 0.0];
        let mut change = vec![[0.0]; r.len()];
        Residual::default().correct(level, &self.matrix, &mut change, residual);
        change.iter().map(|change| change[0] as f32).collect()
    }
}

#[test]
fn the_coarse_level_is_the_galerkin_product_of_the_fine_one() {
    let tank = Tank::new();
    let (n, nodes) = (GRID.len(), tank.places.shape.nodes());
    let mut fine = DMatrix::<f64>::zeros(n, n);
    for column in 0..n {
        let mut unit = vec![[0.0]; n];
        unit[column] = [1.0];
        let product = times(&tank.matrix, &unit);
        fine.column_mut(column).iter_mut().zip(product).for_each(|(a, b)| *a = b[0]);
    }
    // The Laplacian itself, before its rows were divided.
    for (i, mut row) in fine.row_iter_mut().enumerate() {
        row *= f64::from(tank.matrix.divisor(i));
    }
    let mut interpolation = DMatrix::<f64>::zeros(n, nodes);
    for i in 0..n {
        let place = tank.places.place[i];
        for (node, weight) in place.nodes(tank.places.shape).into_iter().zip(place.weights()) {
            interpolation[(i, node)] += f64::from(weight);
        }
    }
    let exact = interpolation.transpose() * &fine * &interpolation;
    let values: Vec<f32> = (0..n).map(|i| scatter(i as i64, 7) as f32).collect();
    let (mut found, mut around) = (vec![0.0f32; nodes], Around::default());
    // As by two slabs of rows.
    for (first, values) in [(0, &values[..n / 3]), (n / 3, &values[n / 3..])] {
        tank.places.restrict(first, values, &mut around);
        around.add_to(&mut found);
    }
    let fine_values = DVector::from_iterator(n, values.iter().map(|v| f64::from(*v)));
    let restricted = interpolation.transpose() * fine_values;
    for (found, exact) in found.iter().zip(&restricted) {
        assert!((f64::from(*found) - exact).abs() < 1e-5, "{found} and {exact}");
    }
    tank.coarse.solve(&mut found);
    let solution = DVector::from_iterator(nodes, found.iter().map(|v| f64::from(*v)));
    // Nodes that few particles are near have a larger diagonal; those that none is near are zero.
    let diagonal = exact.diagonal();
    let least =
        LEAST_DIAGONAL * diagonal.sum() / diagonal.iter().filter(|d| **d > 0.0).count() as f64;
    let (mut off, mut raised) = (0.0, 0);
    for node in 0..nodes {
        let more = (least - diagonal[node]).max(0.0);
        if diagonal[node] > 0.0 {
            let left = (exact.row(node) * &solution)[0] + more * solution[node];
            off += (left - restricted[node]).powi(2);
            raised += usize::from(more > 0.0);
        } else {
            assert_eq!(solution[node], 0.0);
        }
    }
    assert!(raised > 0 && raised < nodes / 2, "{raised} of {nodes}");
    let off = off.sqrt() / restricted.norm();
    assert!(off < 1e-4, "{off}");
}

#[test]
fn nothing_to_correct_is_not_corrected() {
    let change = Tank::new().correction(&vec![0.0; GRID.len()]);
    assert!(change.iter().all(|change| *change == 0.0));
}

#[test]
fn twice_the_residual_is_corrected_twice_as_much() {
    let mut tank = Tank::new();
    let r: Vec<f32> = (0..GRID.len()).map(|i| scatter(i as i64, 8) as f32).collect();
    let twice: Vec<f32> = r.iter().map(|r| 2.0 * r).collect();
    let (once, twice) = (tank.correction(&r), tank.correction(&twice));
    // Powers of two leave the rounding alone.
    assert!(once.iter().zip(&twice).all(|(once, twice)| 2.0 * once == *twice));
}

/// The growth of a mode a step where a network leaves the part `e` of what it starts from: the pressure
/// and its mean change, of which `new` is the last one's part. With p the pressure, c its change and d the
/// pressure that would take away the divergence that is there: p' = e (p + c) + (1 − e) d,
/// c' = c + new (p' − p − c), d' = d − p'.
fn growth(e: Complex<f64>, new: f64) -> f64 {
    let one = Complex::new(1.0, 0.0);
    let next = Matrix3::new(
        e,
        e,
        one - e,
        (e - one) * new,
        one + (e - one) * new,
        (one - e) * new,
        -e,
        -e,
        e,
    );
    next.schur().eigenvalues().unwrap().iter().map(|root| root.norm()).fold(0.0, f64::max)
}

#[test]
fn every_mode_is_corrected_within_the_bounds_of_stability() {
    let mut tank = Tank::new();
    let n = GRID.len();
    let mut left = DMatrix::<f64>::zeros(n, n);
    for column in 0..n {
        let mut unit = vec![0.0; n];
        unit[column] = 1.0;
        left.column_mut(column).copy_from_slice(&tank.left(&unit));
    }
    let new = 1.0 / SolverKind::Network.steps_of_change();
    let factors = left.complex_eigenvalues();
    let most = factors.iter().map(|e| growth(*e, new)).fold(0.0, f64::max);
    assert!(most < 0.95, "{most}");
}

/// The bounds that [`SolverKind::steps_of_change`] names.
#[test]
fn a_network_that_leaves_too_much_or_overshoots_grows() {
    for (steps, lowest, highest) in [(1.0, -1.0 / 7.0, 0.5), (5.0, -0.3, 0.84)] {
        for (e, within) in [(lowest, 1.0), (highest, -1.0)] {
            let growth = |e: f64| growth(Complex::new(e, 0.0), 1.0 / steps);
            let (inside, outside) = (growth(e + 0.01 * within), growth(e - 0.01 * within));
            assert!(inside < 1.0 && outside > 1.0, "{e}: {inside}, {outside}");
        }
    }
}

#[test]
fn damaged_weights_are_told_apart() {
    let bytes = include_bytes!("../../weights/residual.safetensors").to_vec();
    assert!(Network::from_bytes(&bytes).is_ok());
    let found = |bytes: &[u8]| Network::from_bytes(bytes).unwrap_err();
    let truncated = found(&bytes[..bytes.len() - 4]);
    assert!(matches!(truncated, NetworkError::Unreadable(_)), "{truncated}");
    let mut nan = bytes.clone();
    let end = nan.len();
    nan[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(matches!(found(&nan), NetworkError::NotFinite { .. }), "{}", found(&nan));
    // The header is text: the same number of bytes, another meaning.
    let replaced = |from: &str, to: &str| {
        let text = bytes.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
        let mut other = bytes.clone();
        other[text..text + from.len()].copy_from_slice(to.as_bytes());
        found(&other)
    };
    let kind = replaced("\"residual\"", "\"residuum\"");
    assert!(matches!(kind, NetworkError::Kind { .. }), "{kind}");
    let shape = replaced("[16,6]", "[6,16]");
    assert!(matches!(shape, NetworkError::Shape { .. }), "{shape}");
    let missing = replaced("encoder.bias", "encoder.bits");
    assert!(matches!(missing, NetworkError::Missing { .. }), "{missing}");
}
