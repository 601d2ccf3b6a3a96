// Courses of the past, from the historian: asked for as they come into view, in about as many points as the chart has.
import type { HistoryPoint } from "../client/calls";
import type { Courses, Series } from "./course";
import { ask, PicardError, plc } from "./plc";

/** What a chart draws. */
export type Drawn = Pick<Courses, "series" | "columns">;

const points = 1000;
/** The chart moves so far, as a part of what it shows, before it asks again. */
const slack = 0.002;
const patienceMs = 150;
/** So short times are shown scan by scan, where they are still in memory. */
const scanned = 10;

interface Course {
  path: string;
  points: readonly HistoryPoint[];
  step: number;
}

/** Programs name variables in any letter case. */
function nameOf(path: string): string {
  return path.toLowerCase();
}

/** Whether the historian keeps the variable. */
export function isKept(path: string, kept: readonly string[]): boolean {
  const name = nameOf(path);
  return kept.some((tag) => nameOf(tag) === name);
}

export class PastCourses implements Drawn {
  readonly series: Series[] = [];
  private readonly kept: ReadonlySet<string>;
  private courses: readonly Course[] = [];
  private shown: Float64Array[] = [];
  private asked = { from: 0, to: 0 };
  private timer: ReturnType<typeof setTimeout> | undefined;
  private ended = false;
  /** What is shown are scans, not samples. */
  byScan = false;

  constructor(
    live: readonly Series[],
    kept: readonly string[],
    private readonly onChange: (problem: unknown) => void,
  ) {
    this.kept = new Set(kept.map(nameOf));
    for (const one of live) this.series.push({ path: one.path, shape: one.shape, samples: new Float64Array(0), latest: NaN });
    this.shown = [new Float64Array(0), ...this.series.map(() => new Float64Array(0))];
  }

  end(): void {
    this.ended = true;
    clearTimeout(this.timer);
  }

  columns(from: number, to: number): Float64Array[] {
    const room = (to - from) * slack;
    if (Math.abs(from - this.asked.from) > room || Math.abs(to - this.asked.to) > room) {
      this.asked = { from, to };
      clearTimeout(this.timer);
      this.timer = setTimeout(() => void this.fetch(from, to), patienceMs);
    }
    return this.shown;
  }

  /** Least and greatest of a variable in what is shown. */
  ends(path: string): { least: number; most: number } | undefined {
    const course = this.courses.find((one) => one.path === path);
    if (course === undefined || course.points.length === 0) return undefined;
    return { least: Math.min(...course.points.map((one) => one.least)), most: Math.max(...course.points.map((one) => one.greatest)) };
  }

  /** Every scan, or nothing where they are not known any more. */
  private async scans(from: number, to: number): Promise<Course[] | undefined> {
    const tags = this.series.map(({ path }) => path);
    const answer = await ask(() => plc.historyScans({ tags, from, to })).catch((error: unknown) => {
      // One of them is no number, or not here any more: the others have samples all the same.
      if (error instanceof PicardError) return undefined;
      throw error;
    });
    if (answer?.whole !== true) return undefined;
    return tags.map((path, i) => ({
      path,
      step: 0,
      points: answer.scans.flatMap(({ time, values }) => {
        const value = Array.isArray(values) ? values[i] : null;
        return typeof value === "number" ? [{ time, least: value, mean: value, greatest: value }] : [];
      }),
    }));
  }

  private async fetch(from: number, to: number): Promise<void> {
    try {
      const exact = to - from <= scanned ? await this.scans(from, to) : undefined;
      const courses = exact ?? await Promise.all(
        this.series
          .filter((one) => this.kept.has(nameOf(one.path)))
          .map(async ({ path }) => ({ path, ...(await ask(() => plc.historyQuery({ tag: path, from, to, points }))) })),
      );
      if (this.ended || this.asked.from !== from || this.asked.to !== to) return;
      this.byScan = exact !== undefined;
      this.courses = courses;
      this.shown = this.aligned();
      this.onChange(undefined);
    } catch (error) {
      if (!this.ended) this.onChange(error);
    }
  }

  /** All times, and for each course its values: of a stretch of time the least, then the greatest. */
  private aligned(): Float64Array[] {
    const values = this.courses.map((course) => {
      const at = new Map<number, number>();
      for (const point of course.points) {
        at.set(point.time, course.step === 0 ? point.mean : point.least);
        if (course.step !== 0) at.set(point.time + course.step / 2, point.greatest);
      }
      return at;
    });
    const times = [...new Set(values.flatMap((at) => [...at.keys()]))].sort((a, b) => a - b);
    return [
      Float64Array.from(times),
      ...this.series.map(({ path }) => {
        const at = values[this.courses.findIndex((course) => course.path === path)];
        return Float64Array.from(times, (time) => at?.get(time) ?? NaN);
      }),
    ];
  }

  csv(): string {
    const quoted = (text: string): string => `"${(/^[=+\-@\t\r]/.test(text) ? `'${text}` : text).replace(/"/g, '""')}"`;
    const lines = [["time", "variable", "least", "mean", "greatest"].map(quoted).join(",")];
    for (const course of this.courses) {
      for (const point of course.points)
        lines.push([new Date(point.time * 1000).toISOString(), quoted(course.path), point.least, point.mean, point.greatest].join(","));
    }
    return `${lines.join("\r\n")}\r\n`;
  }
}
