//! The largest eigenvalues of a symmetric operator and their vectors.
//!
//! A block of start vectors and what the operator makes of it, again and again, span a space (Krylov's) in which
//! the operator is diagonalised (Rayleigh–Ritz); every new block is made orthogonal to all before, and the space
//! is cut back to its best part when it has grown too large (thick restart). An eigenvalue's copies are found
//! together as far as a block is wide.
//!
//! Not faer's own partial eigensolver: it iterates one vector, which finds a further copy of an eigenvalue by its
//! rounding errors only, and ends in a panic for small matrices.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};

use crate::rng::{Rng, Stage};

/// Vectors that are iterated together.
const BLOCK: usize = 16;

/// Largest residual of an eigenpair as a share of its eigenvalue (of the operator). Eigenvalues are off by its
/// square.
const TOLERANCE: f64 = 1e-7;

/// More restarts than any surface was seen to take; what has converged by then is the result.
const MOST_RESTARTS: usize = 20;

/// Rows that a thread takes at once. A fixed number: sums must not depend on the number of threads.
const ROWS: usize = 2048;

/// The stream of random numbers that the start vectors are drawn from.
const STREAM: u32 = u32::MAX;

/// A symmetric operator on a part of all vectors.
pub(super) trait Operator {
    /// Numbers of a vector.
    fn size(&self) -> usize;

    /// Replaces vectors, one a column, by what the operator makes of them.
    fn apply(&self, vectors: &mut Mat<f64>);

    /// Takes out of vectors what the operator does not see.
    fn project(&self, vectors: &mut Mat<f64>);
}

/// Eigenvalues, descending, and eigenvectors (or coefficients of such), one a column.
pub(super) struct Ritz {
    pub(super) values: Vec<f64>,
    pub(super) vectors: Mat<f64>,
}

/// The `count` largest eigenvalues and their vectors; fewer if not all have converged. `None` if a small dense
/// matrix cannot be diagonalised.
///
/// `count` must be well below the operator's size.
pub(super) fn largest(operator: &impl Operator, count: usize, seed: u32) -> Option<Ritz> {
    let mut space = Krylov::new(operator, count, seed);
    let mut restarts = 0;
    loop {
        let found = space.grow(count)?;
        let good = space.converged(&found).min(count);
        if good == count || restarts == MOST_RESTARTS {
            return Some(Ritz {
                vectors: space.vectors(&found, good),
                values: found.values[..good].to_vec(),
            });
        }
        space.restart(&found, count);
        restarts += 1;
    }
}

/// A growing orthonormal basis and the operator in it.
struct Krylov<'a, O> {
    operator: &'a O,
    /// #V by capacity; the last block of the filled columns was not yet put through the operator.
    basis: Mat<f64>,
    /// The operator in the basis.
    projected: Mat<f64>,
    /// Columns that were put through the operator.
    done: usize,
    /// What the operator makes of the last block done, in the block that follows it.
    rest: Mat<f64>,
}

impl<'a, O: Operator> Krylov<'a, O> {
    fn new(operator: &'a O, count: usize, seed: u32) -> Self {
        let n = operator.size();
        let capacity = (5 * count / 2)
            .max(count + 8 * BLOCK)
            .next_multiple_of(BLOCK)
            + BLOCK;
        let mut rng = Rng::new(seed, Stage::Transfer, STREAM);
        let mut start = Mat::from_fn(n, BLOCK, |_, _| rng.uniform() - 0.5);
        operator.project(&mut start);
        let start = start.qr().compute_thin_Q();
        let mut basis = Mat::zeros(n, capacity);
        basis.as_mut().subcols_mut(0, BLOCK).copy_from(&start);
        Self {
            operator,
            basis,
            projected: Mat::zeros(capacity, capacity),
            done: 0,
            rest: Mat::zeros(BLOCK, BLOCK),
        }
    }

    /// Adds blocks until `count` pairs are found or the space is full.
    fn grow(&mut self, count: usize) -> Option<Ritz> {
        let mut look = (count + count / 2).max(self.done + BLOCK);
        loop {
            let full = self.done + 2 * BLOCK > self.basis.ncols();
            if full || self.done >= look {
                let found = ritz(
                    self.projected
                        .as_ref()
                        .submatrix(0, 0, self.done, self.done),
                )?;
                if full || self.converged(&found) >= count {
                    return Some(found);
                }
                look = self.done + (self.done / 10).max(BLOCK);
            }
            self.add_block();
        }
    }

    /// Puts the last block through the operator; what is new in the result is the next block.
    fn add_block(&mut self) {
        let filled = self.done + BLOCK;
        let mut block = self.basis.as_ref().subcols(self.done, BLOCK).to_owned();
        self.operator.apply(&mut block);
        let basis = self.basis.as_ref().subcols(0, filled);
        let mut inside = transposed_product(basis, block.as_ref());
        subtract_product(block.as_mut(), basis, inside.as_ref());
        let qr = block.qr();
        let first = qr.thin_R().to_owned();
        // Twice: of what little is left, the rounding errors may lie in the space.
        block = qr.compute_thin_Q();
        self.operator.project(&mut block);
        let again = transposed_product(basis, block.as_ref());
        subtract_product(block.as_mut(), basis, again.as_ref());
        inside += &again * &first;
        let qr = block.qr();
        self.rest = qr.thin_R() * &first;
        let next = qr.compute_thin_Q();
        for (k, column) in (self.done..filled).enumerate() {
            for row in 0..filled {
                self.projected[(row, column)] = inside[(row, k)];
                self.projected[(column, row)] = inside[(row, k)];
            }
        }
        self.done = filled;
        (self.basis.as_mut().subcols_mut(filled, BLOCK)).copy_from(&next);
    }

    /// How many of the largest eigenvalues have converged, without a gap.
    fn converged(&self, found: &Ritz) -> usize {
        let last = self.done - BLOCK;
        let residual = |i: usize| {
            let tail = found.vectors.as_ref().col(i).subrows(last, BLOCK);
            (&self.rest * tail).norm_l2()
        };
        (found.values.iter().enumerate())
            .take_while(|(i, value)| residual(*i) <= TOLERANCE * **value)
            .count()
    }

    /// The first `count` eigenvectors.
    fn vectors(&self, found: &Ritz, count: usize) -> Mat<f64> {
        let mut vectors = Mat::zeros(self.basis.nrows(), count);
        subtract_product(
            vectors.as_mut(),
            self.basis.as_ref().subcols(0, self.done),
            found.vectors.as_ref().subcols(0, count),
        );
        vectors
    }

    /// Keeps the best half of what is beyond `count`, and goes on with the last block.
    fn restart(&mut self, found: &Ritz, count: usize) {
        let keep = usize::midpoint(count, self.done);
        let vectors = self.vectors(found, keep);
        let next = self.basis.as_ref().subcols(self.done, BLOCK).to_owned();
        (self.basis.as_mut().subcols_mut(0, keep)).copy_from(&vectors);
        (self.basis.as_mut().subcols_mut(keep, BLOCK)).copy_from(&next);
        self.projected.fill(0.0);
        for (i, value) in found.values[..keep].iter().enumerate() {
            self.projected[(i, i)] = *value;
        }
        self.done = keep;
    }
}

/// All eigenpairs of a symmetric matrix, descending.
pub(super) fn ritz(matrix: MatRef<'_, f64>) -> Option<Ritz> {
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (eigen.S(), eigen.U());
    Some(Ritz {
        values: values.column_vector().iter().rev().copied().collect(),
        vectors: vectors.reverse_cols().to_owned(),
    })
}

/// aᵀ b, summed over blocks of rows in their order.
fn transposed_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    if a.nrows() <= ROWS {
        let mut product = Mat::zeros(a.ncols(), b.ncols());
        matmul(
            product.as_mut(),
            Accum::Replace,
            a.transpose(),
            b,
            1.0,
            Par::Seq,
        );
        return product;
    }
    let middle = half(a.nrows());
    let [(a_above, a_below), (b_above, b_below)] = [a, b].map(|m| m.split_at_row(middle));
    let (above, below) = rayon::join(
        || transposed_product(a_above, b_above),
        || transposed_product(a_below, b_below),
    );
    above + below
}

/// to −= a b, by blocks of rows.
fn subtract_product(to: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    if a.nrows() <= ROWS {
        matmul(to, Accum::Add, a, b, -1.0, Par::Seq);
        return;
    }
    let middle = half(a.nrows());
    let (a_above, a_below) = a.split_at_row(middle);
    let (above, below) = to.split_at_row_mut(middle);
    rayon::join(
        || subtract_product(above, a_above, b),
        || subtract_product(below, a_below, b),
    );
}

/// Where rows are parted: in whole blocks, about in the middle.
fn half(rows: usize) -> usize {
    rows.div_ceil(ROWS) / 2 * ROWS
}
