// Elements that show a value as a drawing.
import type { JSX } from "preact";
import type { Live } from "../live";
import { texts } from "../texts";
import { clipped } from "../values";
import { nameOf, type HmiElement } from "./document";
import { isOn, liveNumber, numberText, partOf, scaleOf, withUnit } from "./format";

const t = texts.hmi;

/** Name and value, for all elements that are read. */
export function Caption(properties: { element: HmiElement; children?: JSX.Element | string | undefined }): JSX.Element {
  const name = clipped(nameOf(properties.element), 80);
  return (
    <span class="hmi-caption">
      {name === "" ? null : (
        <span class="hmi-label" title={name}>
          {name}
        </span>
      )}
      {properties.children}
    </span>
  );
}

export function stateWord(element: HmiElement, live: Live): string {
  if (live.problem !== "") return live.problem;
  if (live.raw === undefined) return "…";
  return isOn(element, live) ? (element.on ?? t.on) : (element.off ?? t.off);
}

function meter(element: HmiElement, live: Live): JSX.IntrinsicElements["div"] {
  const { low, high } = scaleOf(element);
  const value = liveNumber(live);
  const text = live.problem !== "" ? live.problem : withUnit(numberText(live, element.format), element.unit);
  return {
    role: "meter",
    "aria-label": clipped(nameOf(element), 80),
    "aria-valuemin": low,
    "aria-valuemax": high,
    "aria-valuenow": Number.isFinite(value) ? Math.max(low, Math.min(high, value)) : low,
    "aria-valuetext": clipped(text, 120),
  };
}

/** A state; why there is none goes on in its title, where it has no place. */
export function Word(properties: { live: Live; text: string; hidden?: boolean }): JSX.Element {
  return (
    <span class="hmi-word" title={titleOf(properties.live)} aria-hidden={properties.hidden}>
      {clipped(properties.text, 60)}
    </span>
  );
}

function titleOf(live: Live): string | undefined {
  return live.problem === "" ? undefined : live.problem;
}

/** A value as this text, or why there is none. */
export function Value(properties: { live: Live; text: string }): JSX.Element {
  const { live, text } = properties;
  return (
    <span class={live.problem === "" ? "hmi-value number" : "hmi-word"} title={titleOf(live)}>
      {live.problem === "" ? text : clipped(live.problem, 120)}
    </span>
  );
}

function ValueOf(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  return <Value live={live} text={withUnit(numberText(live, element.format), element.unit)} />;
}

export function Lamp(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  const on = isOn(element, live);
  const word = stateWord(element, live);
  return (
    <>
      <Caption element={element} />
      <span class="hmi-line">
        <svg class={`hmi-lamp ${on ? `on ${element.colour ?? "green"}` : ""}`} viewBox="0 0 24 24" role="img" aria-label={t.state(clipped(nameOf(element), 80), word)}>
          <circle cx="12" cy="12" r="9" />
        </svg>
        <Word live={live} text={word} hidden={true} />
      </span>
    </>
  );
}

export function Valve(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  const word = stateWord(element, live);
  return (
    <>
      <svg class={isOn(element, live) ? "hmi-shape on" : "hmi-shape"} viewBox="0 0 48 32" role="img" aria-label={t.state(clipped(nameOf(element), 80), word)}>
        <path d="M4 5 L24 16 L4 27 Z M44 5 L24 16 L44 27 Z" />
      </svg>
      <Caption element={element}>
        <Word live={live} text={word} hidden={true} />
      </Caption>
    </>
  );
}

export function Motor(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  const word = stateWord(element, live);
  return (
    <>
      <svg class={isOn(element, live) ? "hmi-shape on turns" : "hmi-shape"} viewBox="0 0 32 32" role="img" aria-label={t.state(clipped(nameOf(element), 80), word)}>
        <circle cx="16" cy="16" r="13" />
        <path class="hmi-rotor" d="M16 16 L16 5 A5.5 5.5 0 0 1 16 16 M16 16 L25.5 21.5 A5.5 5.5 0 0 1 16 16 M16 16 L6.5 21.5 A5.5 5.5 0 0 1 16 16" />
      </svg>
      <Caption element={element}>
        <Word live={live} text={word} hidden={true} />
      </Caption>
    </>
  );
}

export function Pipe(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  const upright = element.height > element.width;
  const flows = element.variable !== undefined && isOn(element, live);
  const length = Math.max(element.width, element.height) * 10;
  const line = upright ? `M5 0 V${length}` : `M0 5 H${length}`;
  return (
    <svg class={`hmi-pipe ${flows ? `runs ${element.colour ?? "blue"}` : ""}`} viewBox={upright ? `0 0 10 ${length}` : `0 0 ${length} 10`} preserveAspectRatio="none" aria-hidden="true">
      <path class="hmi-pipe-wall" d={line} />
      <path class="hmi-pipe-flow" d={line} />
    </svg>
  );
}

export function Tank(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  const height = 96 * partOf(element, liveNumber(live));
  return (
    <div class="hmi-scaled" {...meter(element, live)}>
      <svg class={`hmi-fill ${element.colour ?? "blue"}`} viewBox="0 0 80 100" preserveAspectRatio="none" aria-hidden="true">
        <rect class="hmi-frame" x="2" y="2" width="76" height="96" rx="6" />
        <rect class="hmi-level" x="4" y={98 - height} width="72" height={height} />
      </svg>
      <Caption element={element}>
        <ValueOf element={element} live={live} />
      </Caption>
    </div>
  );
}

export function Bar(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  const part = 100 * partOf(element, liveNumber(live));
  const lies = element.width > element.height;
  return (
    <div class={lies ? "hmi-scaled lies" : "hmi-scaled"} {...meter(element, live)}>
      <svg class={`hmi-fill ${element.colour ?? "green"}`} viewBox="0 0 100 100" preserveAspectRatio="none" aria-hidden="true">
        <rect class="hmi-frame" x="0" y="0" width="100" height="100" />
        {lies ? <rect class="hmi-level" x="0" y="0" width={part} height="100" /> : <rect class="hmi-level" x="0" y={100 - part} width="100" height={part} />}
      </svg>
      <Caption element={element}>
        <ValueOf element={element} live={live} />
      </Caption>
    </div>
  );
}

/** A point of the dial: part 0 is left below, 1 right below. */
function onDial(part: number, radius: number): string {
  const angle = ((-210 + 240 * part) * Math.PI) / 180;
  return `${(50 + radius * Math.cos(angle)).toFixed(2)} ${(50 + radius * Math.sin(angle)).toFixed(2)}`;
}

export function Gauge(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  const { low, high } = scaleOf(element);
  const part = partOf(element, liveNumber(live));
  const arc = (to: number): string => `M${onDial(0, 40)} A40 40 0 ${to > 0.75 ? 1 : 0} 1 ${onDial(to, 40)}`;
  return (
    <div class="hmi-scaled" {...meter(element, live)}>
      <svg class="hmi-dial" viewBox="0 0 100 80" aria-hidden="true">
        <path class="hmi-arc" d={arc(1)} />
        {part > 0 ? <path class="hmi-arc-on" d={arc(part)} /> : null}
        {[0, 0.25, 0.5, 0.75, 1].map((tick) => (
          <path key={tick} class="hmi-tick" d={`M${onDial(tick, 31)} L${onDial(tick, 35)}`} />
        ))}
        <path class="hmi-needle" d={`M50 50 L${onDial(part, 33)}`} />
        <circle class="hmi-hub" cx="50" cy="50" r="4" />
        <text x="15" y="79" text-anchor="middle">
          {low}
        </text>
        <text x="85" y="79" text-anchor="middle">
          {high}
        </text>
      </svg>
      <Caption element={element}>
        <ValueOf element={element} live={live} />
      </Caption>
    </div>
  );
}

export function Text(properties: { element: HmiElement; live: Live }): JSX.Element {
  const { element, live } = properties;
  return (
    <span class={element.variable === undefined || element.variable === "" ? "hmi-text heading" : "hmi-text"}>
      <span>{clipped(element.text ?? "", 500)}</span>
      {element.variable === undefined || element.variable === "" ? null : <ValueOf element={element} live={live} />}
    </span>
  );
}

export function NumberShown(properties: { element: HmiElement; live: Live }): JSX.Element {
  return (
    <>
      <Caption element={properties.element} />
      <ValueOf element={properties.element} live={properties.live} />
    </>
  );
}

export function Picture(properties: { element: HmiElement }): JSX.Element {
  const { file, label } = properties.element;
  if (file === undefined || file === "") return <span class="hmi-label">{t.kinds["picture"]}</span>;
  return <img src={`/api/pages/picture?${new URLSearchParams({ file }).toString()}`} alt={label ?? ""} draggable={false} />;
}
