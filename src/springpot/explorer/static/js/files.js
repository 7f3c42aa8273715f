// A file of this computer, sent to the server in parts: measured data, or a system.

export const LARGEST = 1_400_000, LARGEST_BINARY = 1_000_000; // bytes
const PARTS = /[^]{1,7000}(?![\udc00-\udfff])/g; // no sign is cut in two
const NO_TEXT = /[\0-\x08\x0b\x0e-\x1f]/; // what no text has
const BINARY = /^(MATLAB [57]\.|\x89HDF|\s*-1[ \t]*\r?\n\s*\d+b)/i; // kinds of files that are read as they are
const HANDFUL = 40, PAUSE = 500; // parts, and ms between them: the server takes some 100 messages a second
const pause = (time) => new Promise((done) => { setTimeout(done, time); });

// null if they are no text in UTF-8
function textOf(bytes) {
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return null;
  }
}

function inBase64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 6000) text += btoa(String.fromCharCode(...bytes.subarray(i, i + 6000))); // in threes
  return text;
}

// returns why it was not sent; wanted: whether it still is
export async function send(file, kind, connection, advice, { wanted = () => true, unit = "" } = {}) {
  const name = [...file.name].slice(0, 100).join("");
  if (file.size > LARGEST) return `${name} is larger than 1.4 MB${advice.large}`;
  const content = await file.arrayBuffer().catch(() => null);
  if (content === null) return `${name} cannot be read.`;
  // other encodings and binary files are read where files are read without the page
  const bytes = new Uint8Array(content), begin = new TextDecoder("latin1").decode(bytes.subarray(0, 200)), own = textOf(bytes);
  const binary = kind !== "system" && (own === null || BINARY.test(begin)), text = binary ? inBase64(bytes) : own;
  if (binary && file.size > LARGEST_BINARY) return `${name} is larger than 1 MB, and not in UTF-8${advice.large}`;
  if (text === null) return `${name} is not text in UTF-8.`;
  if (!binary && NO_TEXT.test(text)) return `${name} is not text, for it has control characters${advice.binary}`;
  const parts = text.match(PARTS) ?? [""];
  for (let part = 0; part < parts.length && wanted(); part += 1) {
    if (part && part % HANDFUL === 0) await pause(PAUSE);
    connection.part(kind, { name, part, of: parts.length, text: parts[part], binary, unit });
  }
  return "";
}

// what was assumed of a file is said on the page that it opens
const NOTE = "springpot-read";
export function keepNote(said) { try { sessionStorage.setItem(NOTE, said); } catch { /* it is not said then */ } }
export function takeNote() {
  try {
    const said = sessionStorage.getItem(NOTE) ?? "";
    sessionStorage.removeItem(NOTE);
    return said && `${said}.`;
  } catch {
    return "";
  }
}
