// Elements that write: as the pages offer it, which the server checks again.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { Live } from "../live";
import { warn } from "../notice";
import { texts } from "../texts";
import { clipped, isDuration, isReal, parsedValue, rawOf } from "../values";
import { nameOf, type HmiElement } from "./document";
import { isOn, liveNumber, numberText, scaleOf, withUnit } from "./format";
import { Caption, stateWord, Value, Word } from "./shapes";
import { useHold, useNewestWrite, writeOffered } from "./writing";

const t = texts.hmi;

interface Control {
  element: HmiElement;
  live: Live;
}

export function Switch(properties: Control): JSX.Element {
  const { element, live } = properties;
  const on = isOn(element, live);
  return (
    <>
      <Caption element={element} />
      <button
        type="button"
        role="switch"
        aria-checked={on}
        aria-label={clipped(nameOf(element), 80)}
        class="switch"
        title={live.problem === "" ? undefined : live.problem}
        disabled={live.raw === undefined}
        onClick={() => void writeOffered(element.variable ?? "", !on)}
      >
        {live.problem === "" ? <span class="switch-knob" aria-hidden="true" /> : null}
        <Word live={live} text={stateWord(element, live)} />
      </button>
    </>
  );
}

function Held(properties: Control): JSX.Element {
  const { element, live } = properties;
  const hold = useHold(element.variable ?? "");
  const isKey = (event: KeyboardEvent): boolean => event.key === " " || event.key === "Enter";
  return (
    <button
      type="button"
      class="hmi-button"
      aria-pressed={live.raw === true}
      title={t.holdHelp}
      disabled={live.raw === undefined}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        hold.down();
      }}
      onPointerUp={hold.up}
      onPointerCancel={hold.up}
      onLostPointerCapture={hold.up}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => {
        if (!isKey(event)) return;
        event.preventDefault();
        if (!event.repeat) hold.down();
      }}
      onKeyUp={(event) => {
        if (isKey(event)) hold.up();
      }}
      onBlur={hold.up}
    >
      {clipped(nameOf(element), 80)}
    </button>
  );
}

export function Button(properties: Control): JSX.Element {
  const { element, live } = properties;
  if (element.value === undefined) return <Held {...properties} />;
  const value = element.value;
  return (
    <button type="button" class="hmi-button" disabled={live.raw === undefined} onClick={() => void writeOffered(element.variable ?? "", value)}>
      {clipped(nameOf(element), 80)}
    </button>
  );
}

export function Slider(properties: Control): JSX.Element {
  const { element, live } = properties;
  const { low, high } = scaleOf(element);
  const write = useNewestWrite(element.variable ?? "");
  const [moved, setMoved] = useState<number>();
  const shape = live.shape;
  const isWhole = shape !== undefined && !isReal(shape) && !isDuration(shape);
  const step = element.step ?? (isWhole ? 1 : (high - low) / 100);
  const shown = moved ?? liveNumber(live);
  // What is shown while it moves is let go of once the plant has it, or has refused it.
  const rest = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  useEffect(() => () => clearTimeout(rest.current), []);
  const move = (value: number): void => {
    setMoved(value);
    clearTimeout(rest.current);
    rest.current = setTimeout(() => setMoved(undefined), 1000);
    if (shape !== undefined) write(parsedValue(isWhole ? String(Math.round(value)) : String(value), shape));
  };
  const text = numberText(moved === undefined || shape === undefined ? live : { ...live, raw: rawOf(moved, shape) }, element.format);
  return (
    <>
      <Caption element={element}>
        <Value live={live} text={withUnit(text, element.unit)} />
      </Caption>
      <input
        type="range"
        aria-label={clipped(nameOf(element), 80)}
        aria-valuetext={withUnit(text, element.unit)}
        min={low}
        max={high}
        step={step}
        value={Number.isFinite(shown) ? shown : low}
        disabled={live.raw === undefined}
        onInput={(event) => move(event.currentTarget.valueAsNumber)}
      />
    </>
  );
}

export function NumberEntry(properties: Control): JSX.Element {
  const { element, live } = properties;
  const [entered, setEntered] = useState<string>();
  const shape = live.shape;
  const submit = (event: Event): void => {
    event.preventDefault();
    if (entered === undefined || shape === undefined) return;
    const value = parsedValue(entered, shape);
    const number = Number(value);
    if (value === null) return warn(t.noValue(clipped(entered, 60)));
    // WHY not of durations, which are texts: the server looks at all limits anyway.
    if (!isDuration(shape) && ((element.low !== undefined && !(number >= element.low)) || (element.high !== undefined && !(number <= element.high)))) {
      return warn(t.limits(clipped(nameOf(element), 80), element.low, element.high));
    }
    setEntered(undefined);
    void writeOffered(element.variable ?? "", value);
  };
  return (
    <>
      <Caption element={element} />
      <form class="hmi-entry inline" onSubmit={submit}>
        <input
          aria-label={clipped(nameOf(element), 80)}
          title={t.entryHelp}
          value={entered ?? numberText(live, element.format)}
          disabled={live.raw === undefined}
          autoComplete="off"
          spellcheck={false}
          enterkeyhint="done"
          inputMode={shape !== undefined && isReal(shape) ? "decimal" : "text"}
          onFocus={(event) => event.currentTarget.select()}
          onInput={(event) => setEntered(event.currentTarget.value)}
          onBlur={() => setEntered(undefined)}
          onKeyDown={(event) => {
            if (event.key === "Escape") setEntered(undefined);
          }}
        />
        {element.unit === undefined ? null : <span>{element.unit}</span>}
      </form>
    </>
  );
}
