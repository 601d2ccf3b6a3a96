// The power flow of what is shown of a diagram: live by a WebSocket, of the past by calls.
import type { FlowPoint } from "../../client/calls";
import { ask, connected, plc, problemOf, type Problem } from "../plc";

/** Which drawing on which instance. */
export interface Looked {
  pou: string;
  instance: string;
  task: string;
}

/** What FlowPoint.state is the sum of. */
export const state = { ran: 1, bool: 2, known: 4, on: 8, both: 16, forced: 32 } as const;

export interface FlowFrame {
  scan: number;
  utcMs: number;
  points: readonly FlowPoint[];
}

/** The server takes so many messages a second from one stream. */
const lookMs = 120;
/** Points in one request, as the server limits them. */
const mostPoints = 20_000;
export const limited = (points: readonly number[]): number[] => points.slice(0, mostPoints);

/** The newest scans of one instance, for as long as it is not closed. */
export class LiveFlow {
  private socket: WebSocket | undefined;
  private subscription = -1;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private wait = 500;
  private ended = false;
  private wanted: { looked: Looked; points: number[] } | undefined;

  constructor(
    private readonly onFrame: (frame: FlowFrame) => void,
    private readonly onAnswer: (answer: { instance: string; task: string } | undefined, problem: Problem | undefined) => void,
  ) {}

  look(looked: Looked, points: readonly number[]): void {
    this.wanted = { looked, points: limited(points) };
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.say(), lookMs);
  }

  close(): void {
    this.ended = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  private say(): void {
    if (this.socket === undefined) return this.open();
    if (this.socket.readyState !== WebSocket.OPEN || this.wanted === undefined) return;
    this.subscription = -1;
    this.socket.send(JSON.stringify({ ...this.wanted.looked, points: this.wanted.points }));
  }

  private open(): void {
    const socket = plc.diagramsStream({ period_ms: 50 });
    this.socket = socket;
    socket.onopen = () => {
      connected.value = true;
      this.wait = 500;
      this.say();
    };
    socket.onmessage = (event: MessageEvent<string>) => this.take(event.data);
    socket.onclose = () => {
      this.socket = undefined;
      if (this.ended) return;
      // Says whether it is the session or the connection that has ended.
      void ask(() => plc.session()).catch(() => {});
      this.timer = setTimeout(() => this.say(), this.wait);
      this.wait = Math.min(this.wait * 2, 8000);
    };
  }

  private take(text: string): void {
    const said = JSON.parse(text) as {
      subscription?: number;
      scan?: number;
      utc_ms?: number;
      points?: FlowPoint[];
      instance?: string;
      task?: string;
      code?: string;
      text?: string;
      help?: string;
    };
    if (said.subscription === undefined) {
      this.onAnswer(undefined, { text: said.text ?? text, code: said.code ?? "", help: said.help ?? "" });
    } else if (said.points === undefined) {
      this.subscription = said.subscription;
      this.onAnswer({ instance: said.instance ?? "", task: said.task ?? "" }, undefined);
    } else if (said.subscription === this.subscription) {
      this.onFrame({ scan: said.scan ?? 0, utcMs: said.utc_ms ?? 0, points: said.points });
    }
  }
}

export interface PastFrame extends FlowFrame {
  first: number;
  last: number;
  nowNs: number;
  task: string;
}

/** Any scan of one recording: one request at a time, the latest wish wins. */
export class PastFlow {
  private busy = false;
  private wish: (() => Promise<void>) | undefined;

  constructor(
    readonly recording: number,
    private readonly onFrame: (frame: PastFrame) => void,
    private readonly onProblem: (problem: Problem) => void,
  ) {}

  show(looked: Looked, points: readonly number[], at: { scan?: number; now_ns?: number }): void {
    const request = { recording: this.recording, ...looked, points: limited(points), ...at };
    this.wish = async () => {
      const answer = await ask(() => plc.diagramsFlow(request));
      // Something else is wished for by now.
      if (this.wish !== undefined) return;
      this.onFrame({
        scan: answer.scan,
        utcMs: answer.utc_ms,
        points: answer.points,
        first: answer.first,
        last: answer.last,
        nowNs: answer.now_ns,
        task: answer.task,
      });
    };
    void this.run();
  }

  private async run(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    while (this.wish !== undefined) {
      const wish = this.wish;
      this.wish = undefined;
      try {
        await wish();
      } catch (error) {
        this.onProblem(problemOf(error));
      }
    }
    this.busy = false;
  }
}
