//! Symmetric equations whose unknowns couple with those of the neighbouring node only.

/// A square block.
pub(crate) type Block<const D: usize> = [[f64; D]; D];

/// A symmetric block-tridiagonal matrix and, once factored, its factors.
#[derive(Debug, Clone)]
pub(crate) struct Tridiagonal<const D: usize> {
    /// Blocks on the diagonal.
    pub diagonal: Vec<Block<D>>,
    /// Blocks that couple a node (row) with the next (column).
    pub coupling: Vec<Block<D>>,
}

impl<const D: usize> Tridiagonal<D> {
    /// A matrix of zeros for so many nodes.
    pub fn new(nodes: usize) -> Self {
        Self {
            diagonal: vec![[[0.0; D]; D]; nodes],
            coupling: vec![[[0.0; D]; D]; nodes - 1],
        }
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        self.diagonal.fill([[0.0; D]; D]);
        self.coupling.fill([[0.0; D]; D]);
    }

    /// Replaces the equation of an unknown by the statement that it does not change.
    pub fn hold(&mut self, node: usize, unknown: usize) {
        for k in 0..D {
            self.diagonal[node][unknown][k] = 0.0;
            self.diagonal[node][k][unknown] = 0.0;
            if let Some(next) = self.coupling.get_mut(node) {
                next[unknown][k] = 0.0;
            }
            if node > 0 {
                self.coupling[node - 1][k][unknown] = 0.0;
            }
        }
        self.diagonal[node][unknown][unknown] = 1.0;
    }

    /// The node where the eliminations from both ends meet.
    ///
    /// Each elimination is a chain of operations that wait for one another; two chains run beside each other on one processor.
    fn middle(&self) -> usize {
        self.diagonal.len() / 2
    }

    /// Pairs of a node below the middle and one above it, from the ends to the middle.
    fn inwards(&self) -> impl DoubleEndedIterator<Item = (usize, Option<usize>)> + use<D> {
        let (middle, last) = (self.middle(), self.diagonal.len() - 1);
        (0..middle).map(move |low| (low, Some(last - low).filter(|high| *high > middle)))
    }

    /// Factors the matrix in place: `S = A - C' S^-1 C` from node to node, from both ends to the middle, each `S = L D L'`; the
    /// couplings become `S^-1 C`, or `S^-1 C'` above the middle. Returns the number of negative pivots; pivots of zero count as
    /// negative and are replaced.
    pub fn factor(&mut self) -> usize {
        let mut negative = 0;
        for (low, high) in self.inwards() {
            negative += self.eliminate(low, low + 1, self.coupling[low]);
            if let Some(high) = high {
                negative += self.eliminate(high, high - 1, transposed(&self.coupling[high - 1]));
            }
        }
        let middle = self.middle();
        negative + factor_block(&mut self.diagonal[middle])
    }

    /// Eliminates a node, which couples with a neighbour by this block, with the rows of the node.
    #[inline(always)]
    fn eliminate(&mut self, node: usize, neighbour: usize, coupling: Block<D>) -> usize {
        let negative = factor_block(&mut self.diagonal[node]);
        let solved = solve_columns(&self.diagonal[node], coupling);
        let other = &mut self.diagonal[neighbour];
        for (left, right) in coupling.iter().zip(&solved) {
            for i in 0..D {
                for j in 0..D {
                    other[i][j] -= left[i] * right[j];
                }
            }
        }
        self.coupling[node.min(neighbour)] = solved;
        negative
    }

    /// Solves in place for some right-hand sides at once: each step of one waits for the last, but not for those of the others.
    pub fn solve<const N: usize>(&self, mut sides: [&mut [[f64; D]]; N]) {
        for (low, high) in self.inwards() {
            for values in &mut sides {
                self.pass_on(values, low, low + 1);
                if let Some(high) = high {
                    self.pass_on(values, high, high - 1);
                }
            }
        }
        let middle = self.middle();
        for values in &mut sides {
            solve_block(&self.diagonal[middle], &mut values[middle]);
        }
        for (low, high) in self.inwards().rev() {
            for values in &mut sides {
                self.take_back(values, low, low + 1);
                if let Some(high) = high {
                    self.take_back(values, high, high - 1);
                }
            }
        }
    }

    /// Takes what a node contributes to the right-hand side of a neighbour from it.
    #[inline(always)]
    fn pass_on(&self, values: &mut [[f64; D]], node: usize, neighbour: usize) {
        let before = values[node];
        for (row, value) in self.coupling[node.min(neighbour)].iter().zip(before) {
            for k in 0..D {
                values[neighbour][k] -= row[k] * value;
            }
        }
    }

    /// Solves for a node after its neighbour.
    #[inline(always)]
    fn take_back(&self, values: &mut [[f64; D]], node: usize, neighbour: usize) {
        let mut x = values[node];
        solve_block(&self.diagonal[node], &mut x);
        let next = values[neighbour];
        for (value, row) in x.iter_mut().zip(&self.coupling[node.min(neighbour)]) {
            let mut sum = 0.0;
            for k in 0..D {
                sum += row[k] * next[k];
            }
            *value -= sum;
        }
        values[node] = x;
    }
}

fn transposed<const D: usize>(block: &Block<D>) -> Block<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]))
}

/// `L D L'` in place: `L` below the diagonal, the inverse of `D` on it.
fn factor_block<const D: usize>(a: &mut Block<D>) -> usize {
    let mut negative = 0;
    for k in 0..D {
        let pivot = a[k][k];
        if pivot <= 0.0 {
            negative += 1;
        }
        let inverse = if pivot == 0.0 { 0.0 } else { 1.0 / pivot };
        for i in k + 1..D {
            let factor = a[i][k] * inverse;
            for j in k + 1..=i {
                a[i][j] -= factor * a[j][k];
            }
        }
        for i in k + 1..D {
            a[i][k] *= inverse;
        }
        a[k][k] = inverse;
    }
    negative
}

fn solve_block<const D: usize>(l: &Block<D>, x: &mut [f64; D]) {
    for i in 0..D {
        for j in 0..i {
            x[i] -= l[i][j] * x[j];
        }
    }
    for i in 0..D {
        x[i] *= l[i][i];
    }
    for i in (0..D).rev() {
        for j in i + 1..D {
            x[i] -= l[j][i] * x[j];
        }
    }
}

/// All columns at once: the rows of the right-hand side are combined.
fn solve_columns<const D: usize>(l: &Block<D>, mut x: Block<D>) -> Block<D> {
    for i in 0..D {
        for j in 0..i {
            let (factor, row) = (l[i][j], x[j]);
            for k in 0..D {
                x[i][k] -= factor * row[k];
            }
        }
    }
    for i in 0..D {
        for k in 0..D {
            x[i][k] *= l[i][i];
        }
    }
    for i in (0..D).rev() {
        for j in i + 1..D {
            let (factor, row) = (l[j][i], x[j]);
            for k in 0..D {
                x[i][k] -= factor * row[k];
            }
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_satisfies_the_equations() {
        let nodes = 4;
        let mut matrix = Tridiagonal::<3>::new(nodes);
        for node in 0..nodes {
            for i in 0..3 {
                for j in 0..3 {
                    let near = 1.0 / (1.0 + (i + j + node) as f64);
                    matrix.diagonal[node][i][j] = near + if i == j { 4.0 } else { 0.0 };
                    if node + 1 < nodes {
                        matrix.coupling[node][i][j] = 0.3 * (i as f64 - 0.7 * j as f64);
                    }
                }
            }
        }
        let whole = matrix.clone();
        assert_eq!(matrix.factor(), 0);
        let right: Vec<[f64; 3]> = (0..nodes).map(|k| [1.0, k as f64, -2.0]).collect();
        let mut x = right.clone();
        matrix.solve([&mut x]);
        for node in 0..nodes {
            for i in 0..3 {
                let mut sum = 0.0;
                for j in 0..3 {
                    sum += whole.diagonal[node][i][j] * x[node][j];
                    if node > 0 {
                        sum += whole.coupling[node - 1][j][i] * x[node - 1][j];
                    }
                    if node + 1 < nodes {
                        sum += whole.coupling[node][i][j] * x[node + 1][j];
                    }
                }
                assert!((sum - right[node][i]).abs() < 1e-12, "{node} {i}");
            }
        }
    }
}
