// Lengths as people read them: three digits, with the unit of the model and as a share of D.

export function digits(value: number, count = 3): string {
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return value.toExponential(1);
  return String(Number(value.toPrecision(count)));
}

export function length(value: number, unit: string): string {
  return unit ? `${digits(value)} ${unit}` : digits(value);
}

export function share(value: number, diameter: number): string {
  return diameter > 0 ? `${digits((100 * value) / diameter, 2)} % of D` : '';
}

/** `0.12 cm (0.43 % of D)`; without a unit only the share, which says more than a bare number. */
export function lengthAndShare(value: number, unit: string, diameter: number): string {
  const ofD = share(value, diameter);
  if (!unit) return ofD || digits(value);
  return ofD ? `${length(value, unit)} (${ofD})` : length(value, unit);
}
