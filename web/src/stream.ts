// A WebSocket that is opened again when it is lost, by the server, by the network or by a line that stands still.
import { checkLink, checkProgram, connected, onLinkLost } from "./plc";

/** The server takes so many messages a second from one stream. */
const askMs = 120;
const firstWaitMs = 500;
const longestWaitMs = 8000;

export interface StreamEnds<Data> {
  open: () => WebSocket;
  /** It is open, or ask() was called: what to say to the server. */
  ready: () => void;
  message: (data: Data) => void;
  lost?: () => void;
}

export class Stream<Data extends string | ArrayBuffer> {
  private socket: WebSocket | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private wait = firstWaitMs;
  private ended = false;
  private wasLost = false;
  private readonly forgetLink: () => void;

  constructor(private readonly ends: StreamEnds<Data>) {
    // The socket of a connection that is lost would stay open until TCP gives up.
    this.forgetLink = onLinkLost(() => this.drop());
  }

  get begun(): boolean {
    return this.socket !== undefined;
  }

  /** Calls `ready` soon, once for several calls; opens the socket before. */
  ask(): void {
    this.after(askMs);
  }

  send(message: object): void {
    this.socket?.send(JSON.stringify(message));
  }

  close(): void {
    this.ended = true;
    this.forgetLink();
    clearTimeout(this.timer);
    this.socket?.close();
  }

  private after(ms: number): void {
    if (this.ended) return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.run(), ms);
  }

  private run(): void {
    if (this.socket === undefined) this.open();
    else if (this.socket.readyState === WebSocket.OPEN) this.ends.ready();
  }

  private open(): void {
    const socket = this.ends.open();
    this.socket = socket;
    socket.onopen = () => {
      connected.value = true;
      this.wait = firstWaitMs;
      if (!this.wasLost) return this.ends.ready();
      // WHY before: numbers and names that are asked for may be those of another program, which has other drawings.
      void checkProgram()
        .catch(() => {})
        .then(() => {
          if (this.socket === socket && !this.ended) this.ends.ready();
        });
    };
    socket.onmessage = (event: MessageEvent<Data>) => this.ends.message(event.data);
    socket.onclose = () => {
      this.lost();
      // Says whether it is the session or the connection that has ended.
      if (!this.ended) checkLink();
    };
  }

  private drop(): void {
    const socket = this.socket;
    if (socket === undefined) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this.lost();
  }

  private lost(): void {
    this.socket = undefined;
    this.wasLost = true;
    if (this.ended) return;
    this.ends.lost?.();
    this.after(this.wait);
    this.wait = Math.min(this.wait * 2, longestWaitMs);
  }
}
