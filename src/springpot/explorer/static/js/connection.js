// The WebSocket: sends questions, no faster than can be answered, and unpacks what comes back.

const KINDS = { 1: "motion", 2: "densities", 3: "grown" };
const LEAST_GAP = 40; // ms between two questions while a slider moves
const RETRY = [500, 1000, 2000, 4000, 8000];

export function unpack(buffer) {
  const head = new Uint32Array(buffer, 0, 3);
  const count = head[2], sizes = new Uint32Array(buffer, 12, count), arrays = [];
  let offset = 12 + 4 * count;
  for (const size of sizes) {
    arrays.push(new Float32Array(buffer, offset, size));
    offset += 4 * size;
  }
  return { kind: KINDS[head[0]], generation: head[1], arrays };
}

export class Connection extends EventTarget {
  constructor(state) {
    super();
    this.state = state;
    this.generation = 0;
    this.frames = 0; // binary ones received, for whoever measures
    this.timer = null;
    this.lastAsked = 0;
    this.failures = 0;
    this.play = { playing: true, speed: 4 };
  }

  open() {
    this.say("connection", { open: false, text: "connecting" });
    const socket = new WebSocket(`ws://${location.host}/live`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.failures = 0;
      this.say("connection", { open: true, text: "connected" });
      this.setPlay(this.play);
      this.ask(true);
    };
    socket.onmessage = (event) => this.receive(event.data);
    socket.onclose = (event) => {
      const shownOut = event.code === 1008 || event.code === 1013;
      this.say("connection", { open: false, text: "not connected", reason: event.reason });
      if (shownOut) return;
      const wait = RETRY[Math.min(this.failures, RETRY.length - 1)];
      this.failures += 1;
      setTimeout(() => this.open(), wait);
    };
  }

  receive(data) {
    const message = typeof data === "string" ? JSON.parse(data) : unpack(data);
    if (typeof data !== "string") this.frames += 1;
    // answers to a question of before are of no use
    if (message.generation !== this.generation && !["status", "refused"].includes(message.kind)) return;
    this.say(message.kind, message);
  }

  say(kind, detail) { this.dispatchEvent(new CustomEvent(kind, { detail })); }

  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  // at most one question every LEAST_GAP; the last one is always sent
  ask(now = false) {
    clearTimeout(this.timer);
    const wait = now ? 0 : Math.max(0, this.lastAsked + LEAST_GAP - performance.now());
    this.timer = setTimeout(() => {
      this.lastAsked = performance.now();
      this.generation += 1;
      this.say("asked", this.state.problem(this.generation));
      this.send(this.state.problem(this.generation));
    }, wait);
  }

  setPlay(play) {
    this.play = play;
    this.send({ kind: "play", ...play });
  }

  step() { this.send({ kind: "step" }); }

  nextPath() { this.send({ kind: "next-path" }); }
}
