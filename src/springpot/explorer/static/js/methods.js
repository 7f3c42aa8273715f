// The theories: what they are called, and how their lines are told apart without colour as well.

export const METHODS = {
  exact: { label: "exact", dash: [] },
  fokker_planck: { label: "Fokker-Planck", dash: [8, 4] },
  envelope: { label: "envelope", dash: [] },
  closure: { label: "closure", dash: [7, 4] },
  averaging_shifted: { label: "averaging, shifted", dash: [8, 3, 2, 3] },
  averaging: { label: "averaging", dash: [2, 3] },
  averaging_printed: { label: "averaging, as printed", dash: [10, 4] },
};
export const NAMES = Object.keys(METHODS);
