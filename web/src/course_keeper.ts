// The courses that are drawn: they go on while other pages are shown, until somebody logs out.
import { signal } from "@preact/signals-core";
import { Courses } from "./course";
import { isTexts, keep, kept } from "./kept";
import { LiveValues } from "./live";
import { session } from "./plc";

export const mostCourses = 16;
export const periods = [20, 50, 100, 500, 1000] as const;
export type Period = (typeof periods)[number];

class CourseKeeper {
  readonly courses = new Courses();
  readonly paths = signal<readonly string[]>(kept("trends", [], isTexts).slice(0, mostCourses));
  readonly period = signal<Period>(100);
  /** Of all courses: changes when a chart has to be made anew. */
  readonly forms = signal("");
  /** None while nobody has asked for courses. */
  readonly values = signal<LiveValues | undefined>(undefined);

  /** The clock of the machine, in seconds since 1970. */
  now(): number {
    return this.values.peek()?.now() ?? Date.now() / 1000;
  }

  start(): void {
    if (this.values.peek() === undefined) this.open();
  }

  stop(): void {
    this.values.peek()?.close();
    this.values.value = undefined;
    for (const one of [...this.courses.series]) this.courses.remove(one.path);
    this.courses.clear();
  }

  setPeriod(period: Period): void {
    this.period.value = period;
    this.values.peek()?.close();
    this.open();
  }

  add(path: string): void {
    const before = this.paths.peek();
    if (before.includes(path) || before.length >= mostCourses) return;
    this.courses.add(path);
    this.values.peek()?.hold(path);
    this.set([...before, path]);
  }

  remove(path: string): void {
    this.courses.remove(path);
    this.values.peek()?.release(path);
    this.set(this.paths.peek().filter((one) => one !== path));
  }

  private set(paths: readonly string[]): void {
    this.paths.value = paths;
    keep("trends", paths);
  }

  private open(): void {
    const values = new LiveValues(this.period.peek());
    for (const path of this.paths.peek()) {
      this.courses.add(path);
      values.hold(path);
    }
    values.onFrame((frame, layout) => {
      this.courses.take(frame, layout);
      this.forms.value = this.courses.series.map((one) => one.shape?.form ?? "").join();
    });
    values.onGap((time) => this.courses.gap(time));
    this.values.value = values;
  }
}

export const keeper = new CourseKeeper();
session.subscribe((who) => {
  if (who === null) keeper.stop();
});
