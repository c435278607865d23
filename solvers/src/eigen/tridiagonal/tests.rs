use super::super::dense::{multiply, symmetric_eigen, symmetric_eigenvalues, symmetrize};
use super::*;
use faer::Mat;
use fracas_operators::laws::probe;

/// Orders around a register, a quadruple of columns, a panel and the limit of the second thread.
const ORDERS: [usize; 12] = [1, 2, 3, 4, 5, 9, 31, 32, 33, 65, 150, 437];

fn random(n: usize, seed: u64) -> Mat<f64> {
    let values: Vec<f64> = probe(n * n, seed);
    let mut a = Mat::from_fn(n, n, |i, j| values[j * n + i]);
    symmetrize(&mut a);
    a
}

fn reduce(a: &Mat<f64>) -> (Vec<f64>, Vec<f64>) {
    let n = a.nrows();
    // the upper triangle must never be read
    let entry = |i: usize, j: usize| if i < j { f64::NAN } else { a[(i, j)] };
    let mut entries: Vec<f64> = (0..n * n).map(|k| entry(k % n, k / n)).collect();
    tridiagonal(&mut entries, n)
}

/// `max |λ − μ|` over `n ‖A‖`, A a symmetric matrix of order n and λ, μ its eigenvalues by both reductions.
fn difference(a: &Mat<f64>) -> f64 {
    let (expected, _) = symmetric_eigen(a.as_ref()).unwrap();
    let found = symmetric_eigenvalues(a.as_ref()).unwrap();
    assert_eq!(found.len(), expected.len());
    assert!(found.is_sorted());
    let norm = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let gaps = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
    gaps.fold(0.0, f64::max) / (norm * expected.len() as f64)
}

#[test]
fn eigenvalues_agree_with_a_reduction_that_keeps_the_vectors() {
    for n in ORDERS {
        assert!(difference(&random(n, n as u64)) < 2e-16, "order {n}");
    }
}

#[test]
fn ranks_clusters_and_extreme_scales_lose_nothing() {
    let factor = random(90, 3);
    let thin = factor.as_ref().subcols(0, 7);
    let low_rank = multiply(thin, thin.transpose());
    assert!(difference(&low_rank) < 2e-16);
    let values = symmetric_eigenvalues(low_rank.as_ref()).unwrap();
    assert!(values[..83].iter().all(|v| v.abs() < 1e-13 * values[89]));

    let identity = Mat::<f64>::identity(70, 70);
    assert_eq!(symmetric_eigenvalues(identity.as_ref()).unwrap(), [1.0; 70]);
    assert_eq!(
        symmetric_eigenvalues(Mat::<f64>::zeros(5, 5).as_ref()).unwrap(),
        [0.0; 5]
    );
    for scale in [1e-200, 1e200] {
        let a = random(40, 8);
        let scaled = Mat::from_fn(40, 40, |i, j| scale * a[(i, j)]);
        let (plain, found) = (
            symmetric_eigenvalues(a.as_ref()).unwrap(),
            symmetric_eigenvalues(scaled.as_ref()).unwrap(),
        );
        for (a, b) in plain.iter().zip(found) {
            assert!((scale * a - b).abs() < 1e-13 * scale * plain[39], "{scale}");
        }
    }
}

#[test]
fn invariants_of_the_matrix_are_those_of_the_tridiagonal_one() {
    for n in ORDERS {
        let a = random(n, 100 + n as u64);
        let (diagonal, below) = reduce(&a);
        assert_eq!((diagonal.len(), below.len()), (n, n - 1));
        let trace: f64 = (0..n).map(|i| a[(i, i)]).sum();
        assert!((diagonal.iter().sum::<f64>() - trace).abs() < 1e-13 * n as f64);
        let square = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        let frobenius = square(&diagonal) + 2.0 * square(&below);
        assert!((frobenius - a.squared_norm_l2()).abs() < 1e-12 * frobenius);
    }
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let a = random(437, 5);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| reduce(&a))
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn a_matrix_with_nan_or_infinity_is_refused() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut a = random(6, 1);
        a[(4, 2)] = bad;
        assert!(symmetric_eigenvalues(a.as_ref()).is_err(), "{bad}");
    }
}
