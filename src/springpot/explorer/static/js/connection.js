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
    this.generation = 0; // of the question that is answered
    this.newest = 0; // of the one that was asked last
    this.waiting = new Map(); // those that were not taken yet
    this.frames = 0; // binary ones received, for whoever measures
    this.timer = null;
    this.lastAsked = 0;
    this.failures = 0;
    this.play = { playing: true, speed: 4 };
  }

  open() {
    this.say("connection", { open: false, text: "connecting" });
    const socket = new WebSocket(`ws://${location.host}/live${location.search}`);
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
    if (this.waiting.has(message.generation) && message.kind === "accepted") this.taken(message.generation);
    if (message.kind === "refused" && message.asked !== null && message.asked !== this.newest) return; // a newer one is on its way
    // answers to a question of before are of no use
    if (message.generation !== this.generation && !["status", "refused", "file", "data", "fit", "shelved"].includes(message.kind)) return;
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
      this.newest += 1;
      const problem = this.state.problem(this.newest);
      // it may not be possible: until the server has taken it, the one before goes on
      this.waiting.set(this.newest, { problem, values: { ...this.state.values } });
      this.send(problem);
    }, wait);
  }

  taken(generation) {
    const { problem, values } = this.waiting.get(generation);
    for (const older of [...this.waiting.keys()].filter((one) => one <= generation)) this.waiting.delete(older);
    this.good = values;
    this.generation = generation;
    this.say("asked", problem);
  }

  file() { this.send({ kind: "file" }); }

  part(kind, part) { this.send({ kind, ...part }); }

  fit(free) { this.send({ kind: "fit", free }); }

  stopFit() { this.send({ kind: "stop-fit" }); }

  setPlay(play) {
    this.play = play;
    this.send({ kind: "play", ...play });
  }

  step() { this.send({ kind: "step" }); }

  nextPath() { this.send({ kind: "next-path" }); }
}
