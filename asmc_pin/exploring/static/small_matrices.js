// Dense algebra of a few rows, matrices row by row in float64.
"use strict";
const AsmcMatrices = (() => {
  const identity = (n) => Float64Array.from({ length: n * n }, (_, k) => (k % (n + 1) === 0 ? 1 : 0));

  // The lower factor of a positive definite matrix; null where it is not one.
  const cholesky = (A, n, L = new Float64Array(n * n)) => {
    for (let i = 0; i < n; i++) {
      for (let j = 0; j <= i; j++) {
        let sum = A[i * n + j];
        for (let k = 0; k < j; k++) sum -= L[i * n + k] * L[j * n + k];
        if (i === j) {
          if (!(sum > 0)) return null;
          L[i * n + i] = Math.sqrt(sum);
        } else L[i * n + j] = sum / L[j * n + j];
      }
    }
    return L;
  };

  // L⁻¹ X and L⁻ᵀ X of the X of so many columns, in place.
  const solveLower = (L, n, X, columns) => {
    for (let c = 0; c < columns; c++) {
      for (let i = 0; i < n; i++) {
        let sum = X[i * columns + c];
        for (let k = 0; k < i; k++) sum -= L[i * n + k] * X[k * columns + c];
        X[i * columns + c] = sum / L[i * n + i];
      }
    }
    return X;
  };
  const solveUpper = (L, n, X, columns) => {
    for (let c = 0; c < columns; c++) {
      for (let i = n - 1; i >= 0; i--) {
        let sum = X[i * columns + c];
        for (let k = i + 1; k < n; k++) sum -= L[k * n + i] * X[k * columns + c];
        X[i * columns + c] = sum / L[i * n + i];
      }
    }
    return X;
  };

  // Xᵀ X.
  const gram = (X, n, out = new Float64Array(n * n)) => {
    for (let i = 0; i < n; i++) {
      for (let j = i; j < n; j++) {
        let sum = 0;
        for (let k = 0; k < n; k++) sum += X[k * n + i] * X[k * n + j];
        out[i * n + j] = out[j * n + i] = sum;
      }
    }
    return out;
  };

  // Eigenvalues of a symmetric matrix, ascending, with their vectors if asked for: Jacobi's rotations, row by row, until
  // nothing is left beside the diagonal. The matrix is destroyed.
  const eigen = (A, n, wanted = false) => {
    const V = wanted ? identity(n) : null;
    for (let sweep = 0; sweep < 60; sweep++) {
      let off = 0;
      for (let p = 0; p < n; p++) {
        for (let q = p + 1; q < n; q++) {
          const apq = A[p * n + q];
          if (Math.abs(apq) <= 1e-300 || Math.abs(apq) < 1e-17 * Math.sqrt(Math.abs(A[p * n + p] * A[q * n + q]))) continue;
          off += 1;
          const theta = (A[q * n + q] - A[p * n + p]) / (2 * apq);
          const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
          const c = 1 / Math.sqrt(t * t + 1), s = t * c;
          A[p * n + p] -= t * apq;
          A[q * n + q] += t * apq;
          A[p * n + q] = A[q * n + p] = 0;
          for (let k = 0; k < n; k++) {
            if (k !== p && k !== q) {
              const x = A[p * n + k], y = A[q * n + k];
              A[p * n + k] = A[k * n + p] = c * x - s * y;
              A[q * n + k] = A[k * n + q] = s * x + c * y;
            }
            if (V) {
              const x = V[k * n + p], y = V[k * n + q];
              V[k * n + p] = c * x - s * y;
              V[k * n + q] = s * x + c * y;
            }
          }
        }
      }
      if (!off) break;
    }
    const order = Array.from({ length: n }, (_, k) => k).sort((i, j) => A[i * n + i] - A[j * n + j]);
    const values = order.map((k) => A[k * n + k]);
    return { values, vector: (k) => Array.from({ length: n }, (_, i) => V[i * n + order[k]]) };
  };

  return { cholesky, solveLower, solveUpper, gram, eigen };
})();
