// Live values: one WebSocket for all that a page shows. What is shown is subscribed to, what is not is let go of.
import { batch, signal, type ReadonlySignal, type Signal } from "@preact/signals-core";
import { useEffect, useState } from "preact/hooks";
import { decodeFrame, subscriptionOf, type LayoutValue, type ValueFrame } from "../client/connection";
import { plc } from "./plc";
import { useSignal } from "./signals";
import { Stream } from "./stream";
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
/** Paths in one subscription, as the server limits them. */
const mostPaths = 5000;

/** The clock of the machine, by the newest frame of any stream. */
let newest: { time: number; at: number } | undefined;

/** The clock of the machine, in seconds since 1970; undefined while no frame has come. */
export function machineTime(): number | undefined {
  return newest === undefined ? undefined : newest.time + (performance.now() - newest.at) / 1000;
}

export type FrameListener = (frame: ValueFrame, layout: readonly LayoutValue[]) => void;

export class LiveValues {
  private wanted = new Map<string, Wanted>();
  private layout: LayoutValue[] = [];
  private signals: (Signal<Live> | undefined)[] = [];
  private subscription = -1;
  private listeners = new Set<FrameListener>();

  private gapListeners = new Set<(time: number) => void>();
  private readonly stream: Stream<string | ArrayBuffer>;

  constructor(periodMs: number) {
    this.stream = new Stream({
      open: () => plc.valuesStream({ period_ms: periodMs }),
      ready: () => this.subscribe(),
      message: (data) => (typeof data === "string" ? this.takeAnswer(data) : this.takeFrame(data)),
      lost: () => this.gapListeners.forEach((tell) => tell(this.now())),
    });
  }

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
    return machineTime() ?? Date.now() / 1000;
  }

  onFrame(listener: FrameListener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  /** Tells when values are not known from a time on: until the next frame. */
  onGap(listener: (time: number) => void): () => void {
    this.gapListeners.add(listener);
    return () => this.gapListeners.delete(listener);
  }

  close(): void {
    this.stream.close();
  }

  private later(): void {
    if (this.stream.begun || this.wanted.size !== 0) this.stream.ask();
  }

  private subscribe(): void {
    this.subscription = -1;
    this.stream.send({ subscribe: [...this.wanted.keys()].slice(0, mostPaths) });
  }

  private takeAnswer(text: string): void {
    const answer = JSON.parse(text) as {
      subscription?: number;
      layout?: LayoutValue[];
      problems?: { path: string; text: string }[];
      text?: string;
    };
    if (answer.layout === undefined) {
      const problem = answer.text ?? text;
      batch(() => this.wanted.forEach(({ live }) => (live.value = { shape: undefined, raw: undefined, problem })));
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
    newest = { time: Number(frame.timeNs) / 1e9, at: performance.now() };
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
