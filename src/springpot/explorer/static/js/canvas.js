// A canvas that keeps the size of its host, sharp on any screen.

export class Canvas {
  constructor(host, height) {
    this.host = host;
    this.element = host.querySelector("canvas");
    this.context = this.element.getContext("2d");
    this.height = height;
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
  }

  resize() {
    const ratio = devicePixelRatio || 1, width = Math.max(this.host.clientWidth, 120), height = this.height();
    if (this.width === width && this.tall === height && this.ratio === ratio) return;
    Object.assign(this, { width, tall: height, ratio });
    this.element.width = Math.round(width * ratio);
    this.element.height = Math.round(height * ratio);
    this.element.style.width = `${width}px`;
    this.element.style.height = `${height}px`;
    this.changed = true;
  }

  clear() {
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.context.clearRect(0, 0, this.width, this.tall);
    return this.context;
  }
}

// round steps for about so many ticks
export function ticks(low, high, about) {
  const rough = (high - low) / about, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999) ?? rough;
  const found = [];
  for (let i = Math.ceil(low / step); i * step <= high; i += 1) found.push(i === 0 ? 0 : i * step);
  return found;
}
