//! The triangular factor of a small matrix.

/// Lower triangular factor `L` of a symmetric, positive definite matrix `L L'`, of which only the lower triangle is read.
/// Where round-off has made the matrix indefinite, the least positive number stands on the diagonal.
pub(crate) fn cholesky<const SIZE: usize>(matrix: &[[f64; SIZE]; SIZE]) -> [[f64; SIZE]; SIZE] {
    let mut factor = [[0.0; SIZE]; SIZE];
    for i in 0..SIZE {
        for j in 0..=i {
            let products = factor[i].iter().zip(&factor[j]).take(j).map(|(a, b)| a * b);
            let rest = products.fold(matrix[i][j], |rest, product: f64| rest - product);
            factor[i][j] = if i == j {
                rest.max(f64::MIN_POSITIVE).sqrt()
            } else {
                rest / factor[j][j]
            };
        }
    }
    factor
}

/// The solution of `L L' x = right` with such a factor.
pub(crate) fn solved<const SIZE: usize>(
    factor: &[[f64; SIZE]; SIZE],
    right: &[f64; SIZE],
) -> [f64; SIZE] {
    let mut x = *right;
    for i in 0..SIZE {
        let known = (0..i).fold(x[i], |rest, j| rest - factor[i][j] * x[j]);
        x[i] = known / factor[i][i];
    }
    for i in (0..SIZE).rev() {
        let known = (i + 1..SIZE).fold(x[i], |rest, j| rest - factor[j][i] * x[j]);
        x[i] = known / factor[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_times_its_transpose_is_the_matrix() {
        let matrix = [[4.0, 2.0, -2.0], [2.0, 10.0, 5.0], [-2.0, 5.0, 9.0]];
        let factor = cholesky(&matrix);
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| factor[i][k] * factor[j][k]).sum();
                assert!((product - matrix[i][j]).abs() < 1e-14);
                assert!(j <= i || factor[i][j] == 0.0);
            }
        }
    }

    #[test]
    fn the_matrix_times_the_solution_is_the_right_side() {
        let matrix = [[4.0, 2.0, -2.0], [2.0, 10.0, 5.0], [-2.0, 5.0, 9.0]];
        let right = [1.0, -2.0, 3.0];
        let x = solved(&cholesky(&matrix), &right);
        for (row, right) in matrix.iter().zip(right) {
            let product: f64 = row.iter().zip(x).map(|(a, b)| a * b).sum();
            assert!((product - right).abs() < 1e-13);
        }
    }
}
