//! Lengths, reflection, determinants.

use super::composite::Math;
use super::{Binary, Scalars, Unary};

impl<S: Scalars> Math<'_, S> {
    /// Σ aᵢ·bᵢ from the left.
    pub(super) fn dot(&mut self, a: &[S::V], b: &[S::V]) -> S::V {
        let mut sum = self.op(Binary::Mul, a[0], b[0]);
        for (&x, &y) in a.iter().zip(b).skip(1) {
            let product = self.op(Binary::Mul, x, y);
            sum = self.op(Binary::Add, sum, product);
        }
        sum
    }

    pub(super) fn length(&mut self, a: &[S::V]) -> S::V {
        if let [x] = *a {
            return self.un(Unary::Abs, x);
        }
        let square = self.dot(a, a);
        self.un(Unary::Sqrt, square)
    }

    pub(super) fn minus(&mut self, a: &[S::V], b: &[S::V]) -> Vec<S::V> {
        a.iter().zip(b).map(|(&x, &y)| self.op(Binary::Sub, x, y)).collect()
    }

    pub(super) fn scaled(&mut self, a: &[S::V], f: S::V) -> Vec<S::V> {
        a.iter().map(|&x| self.op(Binary::Mul, x, f)).collect()
    }

    pub(super) fn reflect(&mut self, i: &[S::V], n: &[S::V]) -> Vec<S::V> {
        let (d, two) = (self.dot(n, i), self.float(2.0));
        let twice = self.op(Binary::Mul, two, d);
        let along = self.scaled(n, twice);
        self.minus(i, &along)
    }

    pub(super) fn refract(&mut self, i: &[S::V], n: &[S::V], eta: S::V) -> Vec<S::V> {
        let (d, one, zero) = (self.dot(n, i), self.float(1.0), self.float(0.0));
        let square = self.op(Binary::Mul, d, d);
        let sine = self.op(Binary::Sub, one, square);
        let eta2 = self.op(Binary::Mul, eta, eta);
        let bent = self.op(Binary::Mul, eta2, sine);
        let k = self.op(Binary::Sub, one, bent);
        let total = self.op(Binary::Lt, k, zero);
        let (scaled, root) = (self.op(Binary::Mul, eta, d), self.un(Unary::Sqrt, k));
        let f = self.op(Binary::Add, scaled, root);
        let (tangent, normal) = (self.scaled(i, eta), self.scaled(n, f));
        let out = self.minus(&tangent, &normal);
        out.into_iter().map(|x| self.s.select(self.k, total, zero, x)).collect()
    }

    /// a·d − b·c.
    pub(super) fn minor(&mut self, a: S::V, b: S::V, c: S::V, d: S::V) -> S::V {
        let (x, y) = (self.op(Binary::Mul, a, d), self.op(Binary::Mul, b, c));
        self.op(Binary::Sub, x, y)
    }

    /// By expansion along the first column.
    pub(super) fn determinant(&mut self, m: &[S::V], n: usize) -> S::V {
        if n == 2 {
            return self.minor(m[0], m[2], m[1], m[3]);
        }
        let mut sum = None;
        for r in 0..n {
            let rest: Vec<_> = (n..n * n).filter(|i| i % n != r).map(|i| m[i]).collect();
            let cofactor = self.determinant(&rest, n - 1);
            let term = self.op(Binary::Mul, m[r], cofactor);
            sum = Some(match sum {
                None => term,
                Some(sum) => self.op(if r % 2 == 0 { Binary::Add } else { Binary::Sub }, sum, term),
            });
        }
        sum.expect("a matrix has rows")
    }
}
