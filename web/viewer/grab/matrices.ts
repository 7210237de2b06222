// Small dense symmetric matrices, by rows.
type Numbers = Float64Array;

/** The product of a matrix with a column. */
export function times(matrix: Numbers, column: Numbers): Numbers {
  const n = column.length;
  const found = new Float64Array(n);
  for (let i = 0; i < n; i += 1) {
    let sum = 0;
    for (let j = 0; j < n; j += 1) sum += matrix[i * n + j]! * column[j]!;
    found[i] = sum;
  }
  return found;
}

/** The solution of the equations of some rows and columns of a definite (n, n) matrix. */
export function choleskySolve(
  matrix: Numbers,
  n: number,
  own: readonly number[],
  right: Numbers,
): Numbers {
  const m = own.length;
  const lower = new Float64Array(m * m);
  const x = right.slice();
  for (let i = 0; i < m; i += 1) {
    for (let j = 0; j <= i; j += 1) {
      let sum = matrix[own[i]! * n + own[j]!]!;
      for (let k = 0; k < j; k += 1) sum -= lower[i * m + k]! * lower[j * m + k]!;
      lower[i * m + j] = i === j ? Math.sqrt(Math.max(sum, 1e-300)) : sum / lower[j * m + j]!;
    }
    for (let k = 0; k < i; k += 1) x[i]! -= lower[i * m + k]! * x[k]!;
    x[i]! /= lower[i * m + i]!;
  }
  for (let i = m - 1; i >= 0; i -= 1) {
    for (let k = i + 1; k < m; k += 1) x[i]! -= lower[k * m + i]! * x[k]!;
    x[i]! /= lower[i * m + i]!;
  }
  return x;
}
