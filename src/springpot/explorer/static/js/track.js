// What has been shown of the path: the last part of it for the pictures, all of it for the CSV.

const MOST = 200000; // samples kept for the CSV

export class Track {
  constructor() { this.restart(); }

  restart() {
    this.t = []; this.x = []; this.v = [];
    this.hits = []; // {t, speed, wall}: the speed is negative on a wall that is struck from below
    this.voltages = []; // of the circuits, now
    this.path = null;
    this.end = 0;
    this.now = { t: 0, x: 0, v: 0 };
  }

  take([[begin, spacing, path, end], x, v, times, speeds, walls = [], voltages = []]) {
    if (path !== this.path || (this.t.length && begin < this.now.t - 0.5 * spacing)) this.restart();
    this.path = path;
    this.voltages = voltages;
    this.end = end;
    for (let i = 0; i < x.length; i += 1) {
      this.t.push(begin + i * spacing);
      this.x.push(x[i]);
      this.v.push(v[i]);
    }
    for (let i = 0; i < times.length; i += 1) this.hits.push({ t: times[i], speed: speeds[i], wall: walls[i] ?? 0 });
    if (this.t.length > MOST) for (const list of [this.t, this.x, this.v]) list.splice(0, MOST / 4);
    const last = this.t.length - 1;
    this.now = { t: this.t[last], x: this.x[last], v: this.v[last] };
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
