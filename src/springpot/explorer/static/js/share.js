// Copies and downloads.

export async function copy(text, said, note) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // clipboards are refused on some addresses; the old way still works
    const area = document.createElement("textarea");
    area.value = text;
    area.className = "sr";
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  say(said, note);
}

export function say(said, note) {
  note.textContent = said;
  clearTimeout(note.timer);
  note.timer = setTimeout(() => { note.textContent = ""; }, 4000);
}

export function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// columns: [[name, values], ...]; what is missing stays empty
export function csv(comment, columns) {
  const length = Math.max(0, ...columns.map(([, values]) => values.length));
  const lines = [`# ${comment}`, columns.map(([name]) => quoted(name)).join(",")];
  for (let i = 0; i < length; i += 1) lines.push(columns.map(([, values]) => quoted(values[i] ?? "")).join(","));
  return new Blob([lines.join("\n"), "\n"], { type: "text/csv" });
}

const quoted = (value) => (/[",\n]/.test(String(value)) ? `"${String(value).replaceAll('"', '""')}"` : String(value));

// canvases below each other, under a title, what was asked, and what the lines are
export function png(canvases, title, comment, lines, { page, text, muted }) {
  const ratio = devicePixelRatio || 1, pad = 14;
  const width = Math.max(...canvases.map((c) => c.width)) / ratio + 2 * pad;
  const made = document.createElement("canvas"), g = made.getContext("2d");
  const small = "12px system-ui, sans-serif";
  g.font = small;
  const words = wrapped(g, comment, width - 2 * pad), rows = legendRows(g, lines, width - 2 * pad);
  const head = 34 + 17 * (words.length + rows.length) + 8;
  made.width = Math.round(width * ratio);
  made.height = Math.round((head + pad) * ratio) + canvases.reduce((sum, c) => sum + c.height, 0);
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.fillStyle = page;
  g.fillRect(0, 0, made.width, made.height);
  g.fillStyle = text;
  g.font = "600 16px system-ui, sans-serif";
  g.fillText(title, pad, 24);
  g.font = small;
  g.fillStyle = muted;
  let y = 34;
  for (const line of words) g.fillText(line, pad, y += 17);
  for (const row of rows) {
    y += 17;
    for (const { x, label, color, dash, box } of row) {
      g.fillStyle = g.strokeStyle = color;
      g.lineWidth = 2;
      g.setLineDash(dash);
      if (box) g.fillRect(pad + x + 8, y - 10, 14, 11);
      else line(g, pad + x, y - 4, pad + x + 26);
      g.setLineDash([]);
      g.fillStyle = muted;
      g.fillText(label, pad + x + 32, y);
    }
  }
  g.setTransform(1, 0, 0, 1, 0, 0);
  y = head * ratio;
  for (const canvas of canvases) {
    g.drawImage(canvas, pad * ratio, y);
    y += canvas.height;
  }
  // toBlob waits for an idle moment, which a page in motion on a busy computer may not have for long
  const bytes = atob(made.toDataURL("image/png").split(",")[1]);
  return new Blob([Uint8Array.from(bytes, (c) => c.charCodeAt(0))], { type: "image/png" });
}

function wrapped(g, sentence, width) {
  const lines = [""];
  for (const part of sentence.split(/(?<=, )/)) {
    if (lines.at(-1) && g.measureText(lines.at(-1) + part).width > width) lines.push("");
    lines[lines.length - 1] += part;
  }
  return lines;
}

function legendRows(g, lines, width) {
  const rows = [];
  let x = Infinity;
  for (const line of lines) {
    const wide = 32 + g.measureText(line.label).width + 18;
    if (x + wide > width) { rows.push([]); x = 0; }
    rows.at(-1).push({ ...line, x });
    x += wide;
  }
  return rows;
}

function line(g, from, y, to) {
  g.beginPath();
  g.moveTo(from, y);
  g.lineTo(to, y);
  g.stroke();
}
