// The courses of several values over time: rings of samples, which all have the same times.
import type { LayoutValue, ValueFrame } from "../client/connection";
import { isDrawable, numberOf, type Raw } from "./values";

/** An hour at ten samples a second. */
export const mostSamples = 36_000;

export interface Series {
  path: string;
  shape: LayoutValue | undefined;
  samples: Float64Array;
  latest: number;
}

export class Courses {
  readonly series: Series[] = [];
  /** Seconds since 1970, and scans of the fastest task. */
  readonly times = new Float64Array(mostSamples);
  readonly scans = new Float64Array(mostSamples);
  private next = 0;
  private used = 0;

  get length(): number {
    return this.used;
  }

  /** Time of the oldest sample; Infinity without one. */
  get oldest(): number {
    return this.used === 0 ? Infinity : (this.times[(this.next + mostSamples - this.used) % mostSamples] ?? Infinity);
  }

  add(path: string): void {
    if (this.series.some((one) => one.path === path)) return;
    this.series.push({ path, shape: undefined, samples: new Float64Array(mostSamples).fill(NaN), latest: NaN });
  }

  remove(path: string): void {
    const at = this.series.findIndex((one) => one.path === path);
    if (at >= 0) this.series.splice(at, 1);
  }

  clear(): void {
    this.used = 0;
  }

  /** Begins with values that are known already: frames have what changes. */
  beginWith(time: number, known: ReadonlyMap<string, { shape: LayoutValue; raw: Raw }>): void {
    for (const one of this.series) {
      const value = known.get(one.path);
      if (value === undefined || !isDrawable(value.shape)) continue;
      one.shape = value.shape;
      one.latest = numberOf(value.raw, value.shape);
    }
    this.sample(time, 0);
  }

  take(frame: ValueFrame, layout: readonly LayoutValue[]): void {
    for (const one of this.series) {
      const place = layout.findIndex((value) => value.path === one.path);
      const shape = layout[place];
      if (shape === undefined || !isDrawable(shape)) continue;
      one.shape = shape;
      const raw: Raw | undefined = frame.changed.get(place);
      if (raw !== undefined) one.latest = numberOf(raw, shape);
    }
    this.sample(Number(frame.timeNs) / 1e9, Number(frame.scans));
  }

  /** Nothing is known from `time` on, until the next frame: the connection is lost. */
  gap(time: number): void {
    if (this.used === 0) return;
    for (const one of this.series) one.latest = NaN;
    this.sample(time, this.scans[(this.next + mostSamples - 1) % mostSamples] ?? 0);
  }

  private sample(time: number, scan: number): void {
    const last = this.used === 0 ? -Infinity : (this.times[(this.next + mostSamples - 1) % mostSamples] ?? -Infinity);
    // The clock of the machine was set back: what is drawn has to rise.
    if (time <= last) {
      if (last - time > 1) this.used = 0;
      else return;
    }
    this.times[this.next] = time;
    this.scans[this.next] = scan;
    for (const one of this.series) one.samples[this.next] = one.latest;
    this.next = (this.next + 1) % mostSamples;
    this.used = Math.min(this.used + 1, mostSamples);
  }

  /** Columns from `from` to `to`, oldest first: axis, then each series. At most about `most` samples: of more, the ones with least and most. `now`: the latest values hold so far. Null: not known. */
  columns(from: number, to: number, now: number, byScan: boolean, most: number): ArrayLike<number | null>[] {
    const begin = (this.next + mostSamples - this.used) % mostSamples;
    const at = (i: number): number => (begin + i) % mostSamples;
    const find = (time: number): number => {
      let low = 0;
      let high = this.used;
      while (low < high) {
        const middle = (low + high) >> 1;
        if ((this.times[at(middle)] ?? 0) < time) low = middle + 1;
        else high = middle;
      }
      return low;
    };
    const first = Math.max(0, find(from) - 1);
    const last = Math.min(this.used, find(to) + 1);
    const chosen = this.chosen(first, last, at, most);
    const goesOn = !byScan && last === this.used && this.used !== 0 && now > (this.times[at(this.used - 1)] ?? Infinity);
    const column = (samples: Float64Array, end: number): ArrayLike<number | null> => {
      const part = new Float64Array(chosen.length + (goesOn ? 1 : 0));
      chosen.forEach((i, k) => (part[k] = samples[at(i)] ?? NaN));
      if (goesOn) part[chosen.length] = end;
      return part.some(Number.isNaN) ? Array.from(part, (value) => (Number.isNaN(value) ? null : value)) : part;
    };
    return [column(byScan ? this.scans : this.times, now), ...this.series.map((one) => column(one.samples, one.latest))];
  }

  private chosen(first: number, last: number, at: (i: number) => number, most: number): number[] {
    const count = Math.max(0, last - first);
    if (count <= most || this.series.length === 0) return Array.from({ length: count }, (_, i) => first + i);
    const chosen = new Set<number>();
    const buckets = Math.max(1, Math.floor(most / (2 * this.series.length)));
    for (let b = 0; b < buckets; ++b) {
      const from = first + Math.floor((b * count) / buckets);
      const to = first + Math.floor(((b + 1) * count) / buckets);
      for (const one of this.series) {
        let least = from;
        let greatest = from;
        for (let i = from; i < to; ++i) {
          const value = one.samples[at(i)] ?? NaN;
          if (Number.isNaN(value)) {
            chosen.add(i);
            continue;
          }
          if (!(value >= (one.samples[at(least)] ?? NaN))) least = i;
          if (!(value <= (one.samples[at(greatest)] ?? NaN))) greatest = i;
        }
        chosen.add(least).add(greatest);
      }
    }
    chosen.add(last - 1);
    return [...chosen].sort((a, b) => a - b);
  }

  /** All samples, a line for each, with the names as the first. */
  csv(): string {
    const quoted = (text: string): string => {
      // WHY the apostrophe: a name must not become a formula of the program that reads the table.
      const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
      return `"${safe.replace(/"/g, '""')}"`;
    };
    const lines = [["time", "scan", ...this.series.map((one) => one.path)].map(quoted).join(",")];
    const begin = (this.next + mostSamples - this.used) % mostSamples;
    for (let i = 0; i < this.used; ++i) {
      const at = (begin + i) % mostSamples;
      const time = new Date((this.times[at] ?? 0) * 1000).toISOString();
      const values = this.series.map((one) => {
        const value = one.samples[at] ?? NaN;
        return Number.isNaN(value) ? "" : String(value);
      });
      lines.push([time, String(this.scans[at] ?? 0), ...values].join(","));
    }
    return `${lines.join("\r\n")}\r\n`;
  }
}
