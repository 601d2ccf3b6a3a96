// The power flow of what is shown of a diagram: live by a WebSocket, of the past by calls.
import type { FlowPoint } from "../../client/calls";
import { ask, plc, problemOf, type Problem } from "../plc";
import { Stream } from "../stream";

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

/** Points in one request, as the server limits them. */
const mostPoints = 20_000;
export const limited = (points: readonly number[]): number[] => points.slice(0, mostPoints);

/** The newest scans of one instance, for as long as it is not closed. */
export class LiveFlow {
  private subscription = -1;
  private wanted: { looked: Looked; points: number[] } | undefined;
  private readonly stream: Stream<string>;

  constructor(
    private readonly onFrame: (frame: FlowFrame) => void,
    private readonly onAnswer: (answer: { instance: string; task: string } | undefined, problem: Problem | undefined) => void,
  ) {
    this.stream = new Stream({
      open: () => plc.diagramsStream({ period_ms: 50 }),
      ready: () => this.say(),
      message: (text) => this.take(text),
    });
  }

  look(looked: Looked, points: readonly number[]): void {
    this.wanted = { looked, points: limited(points) };
    this.stream.ask();
  }

  close(): void {
    this.stream.close();
  }

  private say(): void {
    if (this.wanted === undefined) return;
    this.subscription = -1;
    this.stream.send({ ...this.wanted.looked, points: this.wanted.points });
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
