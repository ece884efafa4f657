// Several effects at once, out of the change that each alone makes: a factor for each, from one small system of normal equations.
//
// r the residual of the model, d_i the change of a set, G_ij = d_i · d_j over the readings used.
// Added together: the factors s that leave least of r − Σ s_i d_i, so G s = Dᵀr; never more than the best of them alone.
// Left out together: what the others take over is counted once in each d_i, so G s = diag(G); never less than any of them alone.
// Both are those of the fit where each effect has one parameter and readings weigh the same.

// Less than this share of its norm next to the others: confounded with them, left at nothing.
const SURVIVAL = 1e-6;

// The factor of every change, by the same index; `rows`: numbers of the readings used.
export function factors(residual, changes, deltas, chosen, rows) {
  const all = new Float64Array(changes.length);
  const dot = (a, b) => rows.reduce((sum, row) => sum + a[row] * b[row], 0);
  for (const without of [true, false]) {
    const some = chosen.filter((i) => changes[i].without === without);
    const gram = some.map((i) => some.map((j) => dot(deltas[i], deltas[j])));
    const right = some.map((i, k) => (without ? gram[k][k] : dot(deltas[i], residual)));
    solve(gram, right).forEach((factor, k) => (all[some[k]] = factor));
  }
  return all;
}

// Gauß–Jordan with the largest pivot left: the matrix is symmetric and not negative.
function solve(gram, right) {
  const size = right.length;
  const norms = gram.map((row, i) => row[i]);
  const open = new Set(norms.keys());
  const solution = right.map(() => 0);
  const used = [];
  while (open.size) {
    const share = (i) => gram[i][i] / norms[i];
    const at = [...open].reduce((best, i) => (share(i) > share(best) ? i : best));
    open.delete(at);
    if (!(share(at) > SURVIVAL)) continue;
    used.push(at);
    const pivot = gram[at][at];
    for (let j = 0; j < size; j++) gram[at][j] /= pivot;
    right[at] /= pivot;
    for (let i = 0; i < size; i++) {
      if (i === at) continue;
      const by = gram[i][at];
      for (let j = 0; j < size; j++) gram[i][j] -= by * gram[at][j];
      right[i] -= by * right[at];
    }
  }
  used.forEach((i) => (solution[i] = right[i]));
  return solution;
}
