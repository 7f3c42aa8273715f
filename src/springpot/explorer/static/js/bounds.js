// Which displacements and velocities the pictures of the motion show.

export function setBounds(view) {
  const { x: places } = view.theory?.places ?? {}, { x: { edges } = {}, v: { edges: speeds } = {} } = view.densities ?? {};
  const from = edges?.length > 2 ? edges : places ?? [view.sizes.low, view.sizes.high];
  [view.low, view.high] = [from[0], from[from.length - 1]];
  view.fastest = speeds?.length > 2 ? 1.1 * Math.max(-speeds[0], speeds[speeds.length - 1]) : view.sizes.fastest;
}

// rare large motions, and growing ones, make room for themselves
export function stretch(view, x, v) {
  const slack = 0.15 * (view.high - view.low), rigid = view.walls.filter(({ soft }) => !soft);
  const floor = rigid.find(({ lower }) => lower)?.position ?? -Infinity, roof = rigid.find(({ lower }) => !lower)?.position ?? Infinity;
  for (const value of x) {
    if (value > view.high && value <= roof) view.high = Math.min(value + slack, roof);
    if (value < view.low - 1e-3 * slack && value >= floor) view.low = Math.max(value - slack, floor);
  }
  for (const value of v) if (Math.abs(value) > view.fastest) view.fastest = 1.15 * Math.abs(value);
}

// with every wall that is not far away
export function boundsOf(view) {
  const wide = view.high - view.low, near = view.walls.filter(({ position }) => position > view.low - 1.2 * wide && position < view.high + 1.2 * wide);
  const soft = 0.03 * wide;
  return [Math.min(view.low, ...near.filter(({ lower }) => lower).map((wall) => wall.position - (wall.soft ? soft : 0))),
    Math.max(view.high, ...near.filter(({ lower }) => !lower).map((wall) => wall.position + (wall.soft ? soft : 0)))];
}

// the walls that are too far away to be drawn, in words
export function outOfView(walls, [low, high], written) {
  const far = walls.filter(({ position }) => position < low || position > high);
  const said = far.map(({ name, position }) => (position < low ? `← ${name} at ${written(position)}` : `${name} at ${written(position)} →`));
  return said.length ? `Out of view: ${said.join(" · ")}` : "";
}
