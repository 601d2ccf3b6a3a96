// Time: live, or a scan of a recording.
import type { JSX } from "preact";
import { texts } from "../texts";
import { Field } from "../ui/parts";

const t = texts.diagrams;

export interface Shown {
  scan: number;
  utcMs: number;
  task: string;
  /** Undefined: live. */
  past: { first: number; last: number } | undefined;
}

export function utcText(ms: number): string {
  return ms === 0 ? texts.nothing : `${new Date(ms).toISOString().replace("T", " ").replace("Z", "")} UTC`;
}

export function TimeBar(properties: {
  shown: Shown | undefined;
  busy: boolean;
  onPause: () => void;
  onLive: () => void;
  onScan: (scan: number) => void;
}): JSX.Element {
  const { shown } = properties;
  const past = shown?.past;
  return (
    <div class="tools time-bar">
      <span class="buttons">
        <button type="button" aria-pressed={past !== undefined} disabled={properties.busy} onClick={past === undefined ? properties.onPause : properties.onLive}>
          {past === undefined ? t.pause : t.live}
        </button>
        <button type="button" aria-label={t.back} title={t.back} disabled={past === undefined || shown === undefined || shown.scan <= past.first}
          onClick={() => shown !== undefined && properties.onScan(shown.scan - 1)}>
          ◂
        </button>
        <button type="button" aria-label={t.forward} title={t.forward} disabled={past === undefined || shown === undefined || shown.scan >= past.last}
          onClick={() => shown !== undefined && properties.onScan(shown.scan + 1)}>
          ▸
        </button>
      </span>
      {past === undefined || shown === undefined ? null : (
        <Field label={t.slider} class="inline grow">
          {(id) => (
            <input id={id} type="range" min={past.first} max={past.last} value={shown.scan} onInput={(event) => properties.onScan(event.currentTarget.valueAsNumber)} />
          )}
        </Field>
      )}
      <span class="number scan-shown" role={past === undefined ? undefined : "status"}>
        {shown === undefined ? texts.nothing : t.scan(shown.scan, shown.task)} <small>{shown === undefined ? "" : utcText(shown.utcMs)}</small>
      </span>
    </div>
  );
}
