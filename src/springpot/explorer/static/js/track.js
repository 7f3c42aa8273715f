// What has been shown of the path: the last part of it for the pictures, all of it for the CSV.

const MOST = 200000; // samples kept for the CSV

export class Track {
  constructor(points) {
    this.points = points; // how many masses
    this.row = null; // of what is followed: what it takes of each displacement
    this.restart();
  }

  restart() {
    this.t = [];
    this.states = Array.from({ length: this.points }, () => ({ x: [], v: [] })); // of each mass
    this.follow(this.row);
    this.hits = []; // {t, speed, wall}: the speed is negative on a wall that is struck from below
    this.voltages = []; // of the circuits, now
    this.path = null;
    this.end = 0;
    this.now = { t: 0, x: 0, v: 0 };
  }

  // x and v of what is followed: one mass's own, or sums
  follow(row) {
    this.row = row;
    const places = row?.flatMap((g, i) => (g ? [i] : [])) ?? [0];
    this.own = places.length === 1 && (row?.[places[0]] ?? 1) === 1;
    const { x, v } = this.states[places[0]];
    [this.x, this.v] = this.own ? [x, v] : [this.along("x", 0), this.along("v", 0)];
    this.setNow();
  }

  along(what, from) {
    const found = this.t.slice(from).fill(0);
    this.row.forEach((g, i) => { if (g) for (let k = 0; k < found.length; k += 1) found[k] += g * this.states[i][what][from + k]; });
    return found;
  }

  setNow() {
    const last = this.t.length - 1;
    this.now = last < 0 ? { t: 0, x: 0, v: 0 } : { t: this.t[last], x: this.x[last], v: this.v[last] };
  }

  take([[begin, spacing, path, end], x, v, times, speeds, walls = [], voltages = []]) {
    if (path !== this.path || (this.t.length && begin < this.now.t - 0.5 * spacing)) this.restart();
    this.path = path;
    this.voltages = voltages;
    this.end = end;
    const count = x.length / this.points, before = this.t.length;
    for (let i = 0; i < count; i += 1) this.t.push(begin + i * spacing);
    this.states.forEach((state, k) => {
      for (let i = k * count; i < (k + 1) * count; i += 1) {
        state.x.push(x[i]);
        state.v.push(v[i]);
      }
    });
    if (!this.own) {
      this.x.push(...this.along("x", before));
      this.v.push(...this.along("v", before));
    }
    for (let i = 0; i < times.length; i += 1) this.hits.push({ t: times[i], speed: speeds[i], wall: walls[i] ?? 0 });
    if (this.t.length > MOST) {
      const all = new Set([this.t, this.x, this.v, ...this.states.flatMap((state) => [state.x, state.v])]);
      for (const list of all) list.splice(0, MOST / 4);
    }
    this.setNow();
    return times.length;
  }

  // index of the first sample at or after a time
  from(time) {
    let low = 0, high = this.t.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.t[middle] < time) low = middle + 1; else high = middle;
    }
    return low;
  }
}
