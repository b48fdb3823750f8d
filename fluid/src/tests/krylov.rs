//! The linear solver against systems with known solutions and a direct solve.

use crate::krylov::{Krylov, Report, Stop, System};
use crate::neighbours::BLOCK;
use crate::preconditioner::Preconditioner;
use crate::sparse::{Entry, SparseMatrix};
use crate::tests::scatter;
use nalgebra::{DMatrix, DVector};

/// Columns and rows of cells of a tank; unknowns are numbered column by column, as particles are.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) columns: i64,
    pub(super) rows: i64,
}

/// A size at which a direct solution is quick.
const SMALL: Grid = Grid { columns: 20, rows: 15 };
/// Two slabs of the preconditioner.
const LARGE: Grid = Grid { columns: 450, rows: 20 };

impl Grid {
    pub(super) fn len(self) -> usize {
        (self.columns * self.rows) as usize
    }

    /// Poisson's equation, p = 0 above the top row and no flux through bed and sides, with weights
    /// that vary by 80 % from pair to pair and from one side of a pair to the other: no symmetry.
    /// Each row is divided by its diagonal.
    pub(super) fn poisson(self) -> SparseMatrix {
        let mut matrix = SparseMatrix::default();
        matrix.blocks.resize_with(self.len().div_ceil(BLOCK), Default::default);
        matrix.blocks.iter_mut().for_each(|block| block.clear());
        for row in 0..self.len() {
            let (i, j) = (row as i64 / self.rows, row as i64 % self.rows);
            let mut weights = Vec::new();
            let mut diagonal = 0.0;
            for (di, dj) in [(-1, 0), (0, -1), (0, 1), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1)] {
                let (ni, nj) = (i + di, j + dj);
                if ni < 0 || ni >= self.columns || nj < 0 {
                    continue;
                }
                let size = if di * dj == 0 { 1.0 } else { 0.25 };
                let weight = size * (1.0 + 0.8 * scatter(row as i64, 3 * di + dj));
                diagonal += weight;
                if nj < self.rows {
                    weights.push(((ni * self.rows + nj) as u32, weight));
                }
            }
            let block = &mut matrix.blocks[row / BLOCK];
            let entries = weights.into_iter().map(|(column, weight)| (column, -weight / diagonal));
            block.add_row(entries, diagonal);
        }
        matrix
    }

    /// A smooth vector and two others, none an eigenvector.
    fn vectors(self) -> Vec<Entry<3>> {
        (0..self.len())
            .map(|row| {
                let x = (row as i64 / self.rows) as f64 / self.columns as f64;
                let y = (row as i64 % self.rows) as f64 / self.rows as f64;
                [(9.0 * x).sin() * (1.0 - y * y), x * y + 0.3, scatter(row as i64, 1)]
            })
            .collect()
    }
}

const STRICT: Stop = Stop { relative: 1e-11, absolute: 0.0, iterations: 500 };

fn one<const R: usize>(vectors: &[Entry<R>], k: usize) -> Vec<Entry<1>> {
    vectors.iter().map(|entry| [entry[k]]).collect()
}

pub(super) fn times<const R: usize>(matrix: &SparseMatrix, x: &[Entry<R>]) -> Vec<Entry<R>> {
    let mut y = vec![[0.0; R]; x.len()];
    let _: [Entry<R>; 0] = matrix.multiply(0..x.len(), x, &mut y, &mut Vec::new(), |_, _, _| {});
    y
}

/// All equations of `matrix`, factorized.
fn whole<'a>(matrix: &'a SparseMatrix, preconditioner: &'a mut Preconditioner) -> System<'a> {
    let rows = preconditioner.factorize(matrix, 0..matrix.rows(), 0);
    assert_eq!(rows, 0..matrix.rows());
    System { matrix, preconditioner, rows }
}

/// Factorizes and solves from zero.
fn solve<const R: usize>(
    matrix: &SparseMatrix,
    b: &[Entry<R>],
    stop: Stop,
) -> (Vec<Entry<R>>, Report) {
    let mut preconditioner = Preconditioner::default();
    let mut x = vec![[0.0; R]; b.len()];
    let report = Krylov::default().solve(whole(matrix, &mut preconditioner), b, &mut x, stop);
    (x, report)
}

/// Largest over the right-hand sides of |a − b| / |b|, 2-norms.
fn distance<const R: usize>(a: &[Entry<R>], b: &[Entry<R>]) -> f64 {
    (0..R)
        .map(|k| {
            let (mut off, mut size) = (0.0, 0.0);
            for (a, b) in a.iter().zip(b) {
                off += (a[k] - b[k]).powi(2);
                size += b[k].powi(2);
            }
            (off / size).sqrt()
        })
        .fold(0.0, f64::max)
}

#[test]
fn agrees_with_a_direct_solution() {
    let matrix = SMALL.poisson();
    let n = SMALL.len();
    // Columns of the matrix, by its products with unit vectors.
    let mut dense = DMatrix::<f64>::zeros(n, n);
    for column in 0..n {
        let mut unit = vec![[0.0]; n];
        unit[column] = [1.0];
        for (row, value) in times(&matrix, &unit).iter().enumerate() {
            dense[(row, column)] = value[0];
        }
    }
    assert!((&dense - dense.transpose()).amax() > 0.05, "meant to be unsymmetric");
    // One, but for the rounding of the rows to single precision.
    assert!(dense.diagonal().iter().all(|d| (d - 1.0).abs() < 1e-6));
    let b = one(&SMALL.vectors(), 2);
    let right = DVector::from_iterator(n, b.iter().map(|b| b[0]));
    let direct = dense.lu().solve(&right).unwrap();
    let direct: Vec<_> = direct.iter().map(|x| [*x]).collect();
    let (x, report) = solve(&matrix, &b, STRICT);
    assert!(report.converged, "{report:?}");
    // Condition number of some hundred times the tolerance 1e-11.
    let off = distance(&x, &direct);
    assert!(off < 1e-8, "{off}");
}

#[test]
fn the_true_residual_meets_the_tolerance() {
    let matrix = LARGE.poisson();
    let b = LARGE.vectors();
    for relative in [1e-4, 1e-8, 1e-12] {
        let (x, report) = solve(&matrix, &b, Stop { relative, ..STRICT });
        let residual = distance(&times(&matrix, &x), &b);
        assert!(report.converged, "{report:?}");
        // What is reported is the true residual, computed a second time: rounding alone differs.
        assert!(residual <= relative * (1.0 + 1e-3), "{residual}, asked for {relative}");
        assert!((report.residual / residual - 1.0).abs() < 1e-3, "{report:?}, {residual}");
    }
}

#[test]
fn a_known_solution_of_a_large_system_is_found() {
    let matrix = LARGE.poisson();
    let exact = LARGE.vectors();
    let (x, report) = solve(&matrix, &times(&matrix, &exact), STRICT);
    assert!(report.converged, "{report:?}");
    // The condition number, about (2 × 20 rows / π)² × 2, times the tolerance.
    let off = distance(&x, &exact);
    assert!(off < 1e-8, "{off}");
}

#[test]
fn right_hand_sides_together_are_as_one_by_one() {
    let matrix = LARGE.poisson();
    let b = LARGE.vectors();
    let (together, report) = solve(&matrix, &b, STRICT);
    assert!(report.converged);
    let mut slowest = 0;
    for k in 0..3 {
        let (alone, report) = solve(&matrix, &one(&b, k), STRICT);
        let off = distance(&one(&together, k), &alone);
        assert!(off < 1e-8, "right-hand side {k}: {off}");
        slowest = slowest.max(report.iterations);
    }
    // The slowest decides; a restart after the quicker ones have met theirs may cost a few.
    assert!(report.iterations <= slowest + slowest / 4, "{} and {slowest}", report.iterations);
}

#[test]
fn a_zero_right_hand_side_beside_others_does_no_harm() {
    let matrix = SMALL.poisson();
    let mut b = SMALL.vectors();
    b.iter_mut().for_each(|b| b[1] = 0.0);
    let (x, report) = solve(&matrix, &b, STRICT);
    assert!(report.converged, "{report:?}");
    assert!(x.iter().all(|x| x[1] == 0.0 && x[0].is_finite() && x[2].is_finite()));
    let (first, _) = solve(&matrix, &one(&b, 0), STRICT);
    assert!(distance(&one(&x, 0), &first) < 1e-8);
}

#[test]
fn a_zero_right_hand_side_is_reached_from_any_guess() {
    // As when a body has left the water: no unit acceleration makes a pressure any more, but the
    // solve starts from that of the step before.
    let matrix = LARGE.poisson();
    let mut preconditioner = Preconditioner::default();
    let b = vec![[0.0; 3]; LARGE.len()];
    let mut x = LARGE.vectors();
    let system = whole(&matrix, &mut preconditioner);
    let report = Krylov::default().solve(system, &b, &mut x, STRICT);
    assert!(report.converged, "{report:?}");
    assert!(x.iter().all(|x| *x == [0.0; 3]), "the solution is zero");
}

#[test]
fn a_good_guess_is_kept_and_a_better_one_costs_less() {
    let matrix = LARGE.poisson();
    let exact = LARGE.vectors();
    let b = times(&matrix, &exact);
    let mut preconditioner = Preconditioner::default();
    let mut krylov = Krylov::default();
    let mut x = exact.clone();
    let report = krylov.solve(whole(&matrix, &mut preconditioner), &b, &mut x, STRICT);
    assert_eq!(report.iterations, 0);
    assert!(report.converged && x == exact);
    let from_zero = solve(&matrix, &b, STRICT).1.iterations;
    x.iter_mut().enumerate().for_each(|(i, x)| x[0] += 1e-6 * scatter(i as i64, 2));
    let report = krylov.solve(whole(&matrix, &mut preconditioner), &b, &mut x, STRICT);
    assert!(report.converged && report.iterations < from_zero, "{report:?}, {from_zero}");
}

/// A regression test of effort: an algorithm that got slower shows here. Measured: 19 iterations
/// with the preconditioner, 191 without.
#[test]
fn the_preconditioner_pays() {
    let matrix = LARGE.poisson();
    let b = one(&LARGE.vectors(), 0);
    let stop = Stop { relative: 1e-8, absolute: 0.0, iterations: 2000 };
    let (_, with) = solve(&matrix, &b, stop);
    let mut none = Preconditioner::default();
    let mut x = vec![[0.0]; b.len()];
    let system = System { matrix: &matrix, preconditioner: &mut none, rows: 0..b.len() };
    let without = Krylov::default().solve(system, &b, &mut x, stop);
    assert!(with.converged && without.converged, "{with:?}, {without:?}");
    assert!(with.iterations <= 22, "{with:?}");
    assert!(6 * with.iterations < without.iterations, "{with:?}, {without:?}");
}

#[test]
fn too_few_iterations_are_told() {
    let matrix = LARGE.poisson();
    let (_, report) = solve(&matrix, &LARGE.vectors(), Stop { iterations: 2, ..STRICT });
    assert!(!report.converged);
    assert_eq!(report.iterations, 2);
    assert!(report.residual > STRICT.relative, "{report:?}");
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (x, report) = solve(&LARGE.poisson(), &LARGE.vectors(), STRICT);
            let bits: Vec<_> = x.iter().map(|x| x.map(f64::to_bits)).collect();
            (bits, report)
        })
    };
    assert!(run(1) == run(2), "the number of threads shows in the solution");
}

#[test]
fn a_window_of_rows_is_solved_with_nought_in_all_others() {
    let matrix = LARGE.poisson();
    let mut preconditioner = Preconditioner::default();
    let asked = LARGE.len() - 100..LARGE.len();
    let rows = preconditioner.factorize(&matrix, asked.clone(), 0);
    assert!(rows.start > 0 && rows.start < asked.start && rows.end == asked.end, "{rows:?}");
    let b = LARGE.vectors();
    let mut x = LARGE.vectors();
    let window =
        System { matrix: &matrix, preconditioner: &mut preconditioner, rows: rows.clone() };
    let report = Krylov::default().solve(window, &b, &mut x, STRICT);
    assert!(report.converged, "{report:?}");
    let found = times(&matrix, &x);
    let off = distance(&found[rows.clone()], &b[rows.clone()]);
    assert!(off <= STRICT.relative * (1.0 + 1e-3), "{off}");
    assert!(x[..rows.start].iter().all(|x| *x == [0.0; 3]), "nought before the rows");
}
