// Live values: one WebSocket for all that a page shows. What is shown is subscribed to, what is not is let go of.
import { batch, signal, type ReadonlySignal, type Signal } from "@preact/signals-core";
import { useEffect, useState } from "preact/hooks";
import { decodeFrame, subscriptionOf, type LayoutValue, type ValueFrame } from "../client/connection";
import { ask, connected, plc } from "./plc";
import { useSignal } from "./signals";
import type { Raw } from "./values";

export interface Live {
  shape: LayoutValue | undefined;
  raw: Raw | undefined;
  /** Why there is no value, or empty. */
  problem: string;
}

interface Wanted {
  users: number;
  live: Signal<Live>;
}

const nothing: Live = { shape: undefined, raw: undefined, problem: "" };
/** The server takes so many messages a second from one stream. */
const subscribeMs = 120;
/** Paths in one subscription, as the server limits them. */
const mostPaths = 5000;

export type FrameListener = (frame: ValueFrame, layout: readonly LayoutValue[]) => void;

export class LiveValues {
  private wanted = new Map<string, Wanted>();
  private socket: WebSocket | undefined;
  private layout: LayoutValue[] = [];
  private signals: (Signal<Live> | undefined)[] = [];
  private subscription = -1;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private wait = 500;
  private ended = false;
  private listeners = new Set<FrameListener>();
  private newest = { time: Date.now() / 1000, at: performance.now() };

  constructor(private readonly periodMs: number) {}

  /** The value of a path, until `release`. */
  hold(path: string): ReadonlySignal<Live> {
    let entry = this.wanted.get(path);
    if (entry === undefined) {
      entry = { users: 0, live: signal(nothing) };
      this.wanted.set(path, entry);
      this.later();
    }
    ++entry.users;
    return entry.live;
  }

  release(path: string): void {
    const entry = this.wanted.get(path);
    if (entry !== undefined && --entry.users === 0) {
      this.wanted.delete(path);
      this.later();
    }
  }

  /** The clock of the machine, in seconds since 1970. */
  now(): number {
    return this.newest.time + (performance.now() - this.newest.at) / 1000;
  }

  onFrame(listener: FrameListener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  close(): void {
    this.ended = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  private later(): void {
    if (this.ended) return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.subscribe(), subscribeMs);
  }

  private subscribe(): void {
    if (this.socket === undefined) {
      if (this.wanted.size !== 0) this.open();
      return;
    }
    if (this.socket.readyState !== WebSocket.OPEN) return;
    this.subscription = -1;
    this.socket.send(JSON.stringify({ subscribe: [...this.wanted.keys()].slice(0, mostPaths) }));
  }

  private open(): void {
    const socket = plc.valuesStream({ period_ms: this.periodMs });
    this.socket = socket;
    socket.onopen = () => {
      connected.value = true;
      this.wait = 500;
      this.subscribe();
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (typeof event.data === "string") {
        this.takeAnswer(event.data);
      } else {
        this.takeFrame(event.data);
      }
    };
    socket.onclose = () => {
      this.socket = undefined;
      if (this.ended) return;
      // Says whether it is the session or the connection that has ended.
      void ask(() => plc.session()).catch(() => {});
      this.timer = setTimeout(() => this.subscribe(), this.wait);
      this.wait = Math.min(this.wait * 2, 8000);
    };
  }

  private takeAnswer(text: string): void {
    const answer = JSON.parse(text) as {
      subscription?: number;
      layout?: LayoutValue[];
      problems?: { path: string; text: string }[];
      text?: string;
    };
    if (answer.layout === undefined) {
      console.error(answer.text ?? text);
      return;
    }
    this.subscription = answer.subscription ?? -1;
    this.layout = answer.layout;
    this.signals = this.layout.map((value) => this.wanted.get(value.path)?.live);
    for (const problem of answer.problems ?? []) {
      const entry = this.wanted.get(problem.path);
      if (entry !== undefined) entry.live.value = { shape: undefined, raw: undefined, problem: problem.text };
    }
  }

  private takeFrame(bytes: ArrayBuffer): void {
    if (subscriptionOf(bytes) !== this.subscription) return;
    const frame = decodeFrame(bytes, this.layout);
    this.newest = { time: Number(frame.timeNs) / 1e9, at: performance.now() };
    batch(() => {
      frame.changed.forEach((raw, i) => {
        const live = this.signals[i];
        if (live !== undefined) live.value = { shape: this.layout[i], raw, problem: "" };
      });
    });
    this.listeners.forEach((listener) => listener(frame, this.layout));
  }
}

/** A stream as long as the component is there. */
export function useLiveValues(periodMs: number): LiveValues {
  const [values] = useState(() => new LiveValues(periodMs));
  useEffect(() => () => values.close(), [values]);
  return values;
}

const noLive = signal<Live>(nothing);

/** The live value of a path; of none without one. */
export function useLive(values: LiveValues, path: string | undefined): Live {
  const [held, setHeld] = useState<ReadonlySignal<Live>>(noLive);
  useEffect(() => {
    if (path === undefined) {
      setHeld(() => noLive);
      return undefined;
    }
    const live = values.hold(path);
    setHeld(() => live);
    return () => values.release(path);
  }, [values, path]);
  return useSignal(held);
}
