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

// canvases below each other, with a title and what was asked
export function png(canvases, title, comment, { page, text, muted }) {
  const ratio = devicePixelRatio || 1, head = 52 * ratio;
  const width = Math.max(...canvases.map((c) => c.width)) + 24 * ratio;
  const height = canvases.reduce((sum, c) => sum + c.height, 0) + head + 12 * ratio;
  const made = document.createElement("canvas");
  made.width = width;
  made.height = height;
  const g = made.getContext("2d");
  g.fillStyle = page;
  g.fillRect(0, 0, width, height);
  g.fillStyle = text;
  g.font = `600 ${15 * ratio}px system-ui, sans-serif`;
  g.fillText(title, 14 * ratio, 22 * ratio, width - 28 * ratio);
  g.fillStyle = muted;
  g.font = `${11 * ratio}px system-ui, sans-serif`;
  g.fillText(comment, 14 * ratio, 41 * ratio, width - 28 * ratio);
  let y = head;
  for (const canvas of canvases) {
    g.drawImage(canvas, 12 * ratio, y);
    y += canvas.height;
  }
  return new Promise((done) => made.toBlob(done, "image/png"));
}
