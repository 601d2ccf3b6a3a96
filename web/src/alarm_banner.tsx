// The newest alarm that nobody has acknowledged, above all pages.
import type { JSX } from "preact";
import { plc, usePolled } from "./plc";
import { link } from "./route";
import { texts } from "./texts";
import { clipped } from "./values";

const t = texts.alarms;

/** "2026-11-27 12:30:00", of a time of the server. */
export function alarmTime(utc: string): string {
  return utc.replace("T", " ").replace(/\.\d+Z$/, "");
}

export function AlarmBanner(): JSX.Element {
  const { answer } = usePolled(() => plc.alarmsList({ most: 0 }), 1000);
  const newest = answer?.newest;
  // WHY always there: a screen reader tells what comes into a region that it knows already.
  return (
    <div role="status" class="strips">
      {answer === undefined || newest === undefined ? null : (
        <p class={`strip alarm-banner ${newest.priority === "low" || newest.priority === "medium" ? "warning" : "bad"}`}>
          <span>
            <strong>{t.priorities[newest.priority] ?? newest.priority}</strong>: {clipped(newest.text, 160)}{" "}
            <span class="number">{alarmTime(newest.since ?? "")}</span>
          </span>
          <span>
            {t.counts(answer.unacked, answer.active)} <a href={link("alarms")}>{t.toPage}</a>
          </span>
        </p>
      )}
    </div>
  );
}
