// The connection to an engineering server, for pages that it serves: the session is a cookie. calls.ts is made from the
// same rows as the server.

/** The server refused a call. `code` has a page of its own: plc explain CODE. */
export class PicardError extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    readonly text: string,
    readonly field?: string,
    readonly help?: string,
    readonly retryAfterMs?: number,
  ) {
    super(`${code}: ${field === undefined ? "" : field + ": "}${text}`);
  }
}

/** A value of a variable as JSON: numbers of 64 bits, times, dates and enumerations are texts. */
export type Value = boolean | number | string | null | Value[] | { [field: string]: Value };

/** What took too long is told as what did not reach the server. */
function noAnswer(error: unknown): never {
  throw error instanceof DOMException && error.name === "TimeoutError" ? new TypeError("no answer") : error;
}

export class Connection {
  /**
   * `base`: of another server, for scripts; pages leave it empty. `token`: for the header Authorization. `patienceMs`: how
   * long a call may take that sends no file; it then throws a TypeError, as where nobody answers. 0: for ever.
   */
  constructor(
    private readonly base = "",
    public token?: string,
    private readonly patienceMs = 0,
  ) {}

  protected async send(method: "GET" | "POST", path: string, fields: object, file?: Blob): Promise<Response> {
    const headers: Record<string, string> = {};
    if (this.token !== undefined) headers["Authorization"] = `Bearer ${this.token}`;
    const init: RequestInit = { method, headers, credentials: "same-origin", cache: "no-store" };
    let target = this.base + path;
    if (method === "POST" && file === undefined) {
      headers["Content-Type"] = "application/json";
      init.body = JSON.stringify(fields);
    } else {
      if (file !== undefined) {
        headers["Content-Type"] = "application/octet-stream";
        init.body = file;
      }
      const query = new URLSearchParams();
      for (const [name, value] of Object.entries(fields)) {
        if (value !== undefined) query.append(name, String(value));
      }
      const text = query.toString();
      if (text !== "") target += `?${text}`;
    }
    if (file === undefined && this.patienceMs > 0) init.signal = AbortSignal.timeout(this.patienceMs);
    const response = await fetch(target, init).catch(noAnswer);
    if (response.ok) return response;
    let answer: { code?: string; text?: string; field?: string; help?: string; retry_after_ms?: number } = {};
    try {
      answer = (await response.json()) as typeof answer;
    } catch {
      // Something between answered.
    }
    throw new PicardError(
      response.status,
      answer.code ?? "",
      answer.text ?? `status ${response.status}`,
      answer.field,
      answer.help,
      answer.retry_after_ms,
    );
  }

  protected async call<T>(method: "GET" | "POST", path: string, fields: object, file?: Blob): Promise<T> {
    return (await (await this.send(method, path, fields, file)).json().catch(noAnswer)) as T;
  }

  protected async file(path: string): Promise<Blob> {
    return (await this.send("GET", path, {})).blob();
  }

  protected socket(path: string): WebSocket {
    const from = new URL(this.base === "" ? location.href : this.base);
    const scheme = from.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${from.host}${path}`);
    socket.binaryType = "arraybuffer";
    return socket;
  }
}

/** A value in the layout of a stream. */
export interface LayoutValue {
  path: string;
  type: string;
  form: "bool" | "i8" | "u8" | "i16" | "u16" | "i32" | "u32" | "i64" | "u64" | "f32" | "f64" | "text";
  members?: { name: string; value: number }[];
}

export interface ValueFrame {
  whole: boolean;
  scans: bigint;
  timeNs: bigint;
  /** By place in the layout. */
  changed: Map<number, boolean | number | bigint | string>;
}

const head = 24;
const utf8 = new TextDecoder();

/** The subscription that a frame is of. */
export function subscriptionOf(frame: ArrayBuffer): number {
  return new DataView(frame).getUint16(2, true);
}

/** Decodes a frame of /api/values/stream. */
export function decodeFrame(frame: ArrayBuffer, layout: readonly LayoutValue[]): ValueFrame {
  const view = new DataView(frame);
  const count = view.getUint32(4, true);
  if (view.getUint8(0) !== 1 || count !== layout.length) throw new Error("a frame of another layout");
  const changed: ValueFrame["changed"] = new Map();
  let at = head + ((count + 7) >> 3);
  for (let i = 0; i < count; ++i) {
    if (((view.getUint8(head + (i >> 3)) >> (i & 7)) & 1) === 0) continue;
    switch (layout[i]!.form) {
      case "bool":
        changed.set(i, view.getUint8(at++) !== 0);
        break;
      case "i8":
        changed.set(i, view.getInt8(at++));
        break;
      case "u8":
        changed.set(i, view.getUint8(at++));
        break;
      case "i16":
        changed.set(i, view.getInt16(at, true));
        at += 2;
        break;
      case "u16":
        changed.set(i, view.getUint16(at, true));
        at += 2;
        break;
      case "i32":
        changed.set(i, view.getInt32(at, true));
        at += 4;
        break;
      case "u32":
        changed.set(i, view.getUint32(at, true));
        at += 4;
        break;
      case "i64":
        changed.set(i, view.getBigInt64(at, true));
        at += 8;
        break;
      case "u64":
        changed.set(i, view.getBigUint64(at, true));
        at += 8;
        break;
      case "f32":
        changed.set(i, view.getFloat32(at, true));
        at += 4;
        break;
      case "f64":
        changed.set(i, view.getFloat64(at, true));
        at += 8;
        break;
      case "text": {
        const length = view.getUint16(at, true);
        changed.set(i, utf8.decode(new Uint8Array(frame, at + 2, length)));
        at += 2 + length;
        break;
      }
    }
  }
  return { whole: view.getUint8(1) === 1, scans: view.getBigUint64(8, true), timeNs: view.getBigInt64(16, true), changed };
}
