// What the condition on M̄ and the sampled loop say at one M(q).
"use strict";
const AsmcCondition = (() => {
  const { cholesky, solveLower, solveUpper, gram, eigen } = AsmcMatrices;

  const diagonal = (values, n) => {
    const X = new Float64Array(n * n);
    for (let i = 0; i < n; i++) X[i * n + i] = values[i];
    return X;
  };

  // I − M⁻¹M̄ from M's factor.
  const leftOver = (L, mbar, n) => {
    const X = solveUpper(L, n, solveLower(L, n, diagonal(mbar, n), n), n);
    for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) X[i * n + j] = (i === j ? 1 : 0) - X[i * n + j];
    return X;
  };

  // M̄^½ M⁻¹ M̄^½, which has the eigenvalues of M⁻¹M̄.
  const balanced = (L, mbar, n) => gram(solveLower(L, n, diagonal(mbar.map(Math.sqrt), n), n), n);

  // The norm alone, for maps and searches; NaN where M is not positive definite.
  const norm = (condition, M, mbar, n) => {
    const L = cholesky(M, n);
    if (!L) return NaN;
    if (condition === "lemma1") return Math.sqrt(Math.max(eigen(gram(leftOver(L, mbar, n), n), n).values[n - 1], 0));
    const { values } = eigen(balanced(L, mbar, n), n);
    return Math.max(Math.abs(1 - values[0]), Math.abs(1 - values[n - 1]));
  };

  // Norm, the direction of the estimation error that grows most (unit length), how much each m̄ moves the norm
  // (by a share of itself), the factor of M̄ at which the condition breaks here, and the eigenvalues of M and of M⁻¹M̄.
  const at = (condition, M, mbar, n) => {
    const L = cholesky(M, n);
    if (!L) return null;
    const inertias = eigen(M.slice(), n).values;
    const root = mbar.map(Math.sqrt), modes = eigen(balanced(L, mbar, n), n, true), ratios = modes.values;
    let value, direction, slopes, breaks;
    if (condition === "lemma1") {
      const X = leftOver(L, mbar, n), found = eigen(gram(X, n), n, true);
      direction = found.vector(n - 1);
      value = Math.sqrt(Math.max(found.values[n - 1], 0));
      const image = Array.from({ length: n }, (_, i) => direction.reduce((sum, v, j) => sum + X[i * n + j] * v, 0) / (value || 1));
      const pulled = solveUpper(L, n, solveLower(L, n, image, 1), 1);
      slopes = pulled.map((y, i) => -y * mbar[i] * direction[i]);
      const S = Float64Array.from(M, (x, k) => x * (1 / mbar[Math.floor(k / n)] + 1 / mbar[k % n]));
      breaks = Math.max(eigen(S, n).values[0], 0);
    } else {
      const most = Math.abs(1 - ratios[0]) > Math.abs(1 - ratios[n - 1]) ? 0 : n - 1, w = modes.vector(most);
      value = Math.abs(1 - ratios[most]);
      const z = solveUpper(L, n, solveLower(L, n, w.map((x, i) => root[i] * x), 1), 1);
      slopes = z.map((x, i) => (ratios[most] > 1 ? 1 : -1) * mbar[i] * x * x);
      const x = w.map((y, i) => y / root[i]), length = Math.hypot(...x);
      direction = x.map((y) => y / length);
      breaks = 2 / ratios[n - 1];
    }
    return { norm: value, direction, slopes, breaks, inertias, ratios };
  };

  // The frozen sampled loop of PPC with one k_s and one β, velocity estimate, no filter, no delay, without gravity: what
  // docs/stability.md calls the closed form of the plain loop. `ratios` are the eigenvalues of M⁻¹M̄.
  const loop = (ratios, { ks, beta, period }) => {
    const least = ratios[0], most = ratios[ratios.length - 1];
    const fast = (4 / most - 2) / period;          // β + k_s stays below it
    const slow = period * (1 / least - 0.5);       // β k_s times it stays below β + k_s
    const beside = (k) => Math.max(0, Math.min(fast - k, slow * k > 1 ? k / (slow * k - 1) : Infinity));
    const together = Math.max(0, Math.min(fast / (beta + ks), slow > 0 ? (beta + ks) / (beta * ks * slow) : Infinity));
    return { radius: Math.max(...ratios.map((a) => radius(a, ks, beta, period))), beta: beside(ks), ks: beside(beta), together };
  };

  // Spectral radius of one mode. Its polynomial in z = 1 + w has roots near 0: these are found without cancellation.
  const radius = (a, ks, beta, L) => {
    const kappa = (beta + ks) * L, pi = beta * ks * L * L;
    // w³ + a w² + κa (w² + w) + (πa/2)(w² + 3w + 2), from the z polynomial of docs/stability.md.
    const b = a + kappa * a + pi * a / 2, c = kappa * a + 1.5 * pi * a, d = pi * a;
    const f = (w) => ((w + b) * w + c) * w + d, slope = (w) => (3 * w + 2 * b) * w + c;
    // A real root by bisection: f(0) = d > 0, and f is negative far to the left. Then the quadratic that is left.
    let low = -(1 + b + c + d), high = 0;
    for (let k = 0; k < 200 && high - low > 1e-17 * -low; k++) {
      const middle = 0.5 * (low + high);
      if (middle === low || middle === high) break;
      if (f(middle) < 0) low = middle;
      else high = middle;
    }
    let w = 0.5 * (low + high);
    const step = f(w) / slope(w);
    if (Number.isFinite(step) && Math.abs(step) < 1e-6 * Math.abs(w)) w -= step;
    const p = b + w, q = -d / w;  // of w² + p w + q
    const under = p * p / 4 - q;
    if (under < 0) return Math.max(Math.abs(1 + w), Math.sqrt((1 - p / 2) ** 2 - under));
    const far = -p / 2 - (p >= 0 ? 1 : -1) * Math.sqrt(under);
    return Math.max(Math.abs(1 + w), Math.abs(1 + far), Math.abs(1 + (far === 0 ? 0 : q / far)));
  };

  return { norm, at, loop };
})();
