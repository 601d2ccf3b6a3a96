// Values of variables as texts and back: numbers in any base, times and dates as IEC 61131-3 writes them.
import type { LayoutValue, Value } from "../client/connection";

/** As frames carry them. */
export type Raw = boolean | number | bigint | string;
/** What is known of a value's form. */
export type Shape = Pick<LayoutValue, "type" | "form" | "members">;

const widths: Record<string, number> = { i8: 8, u8: 8, i16: 16, u16: 16, i32: 32, u32: 32, i64: 64, u64: 64 };
const durations: Record<string, string> = { TIME: "T#", LTIME: "LT#" };
const dates: Record<string, [prefix: string, parts: "date" | "time" | "both"]> = {
  DATE: ["D#", "date"],
  LDATE: ["LD#", "date"],
  TOD: ["TOD#", "time"],
  TIME_OF_DAY: ["TOD#", "time"],
  LTOD: ["LTOD#", "time"],
  LTIME_OF_DAY: ["LTOD#", "time"],
  DT: ["DT#", "both"],
  DATE_AND_TIME: ["DT#", "both"],
  LDT: ["LDT#", "both"],
  LDATE_AND_TIME: ["LDT#", "both"],
};

/** Longest text that is shown of a value or name: what a project is made of must not hang a page. */
const mostShown = 400;
export function clipped(text: string, most = mostShown): string {
  return text.length <= most ? text : `${text.slice(0, most)}…`;
}

/** "T#1m30s500ms", from nanoseconds. */
export function durationText(ns: bigint, prefix = "T#"): string {
  if (ns === 0n) return `${prefix}0s`;
  let rest = ns < 0n ? -ns : ns;
  let text = ns < 0n ? `${prefix}-` : prefix;
  const units: [string, bigint][] = [
    ["d", 86_400_000_000_000n],
    ["h", 3_600_000_000_000n],
    ["m", 60_000_000_000n],
    ["s", 1_000_000_000n],
    ["ms", 1_000_000n],
    ["us", 1000n],
    ["ns", 1n],
  ];
  for (const [unit, size] of units) {
    if (rest >= size) text += `${rest / size}${unit}`;
    rest %= size;
  }
  return text;
}

function dateText(ns: bigint, [prefix, parts]: [string, "date" | "time" | "both"]): string {
  const day = 86_400_000_000_000n;
  const inDay = ((ns % day) + day) % day;
  const at = new Date(Number((ns - inDay) / 1_000_000n) + Number(inDay / 1_000_000n));
  if (Number.isNaN(at.getTime())) return `${prefix}${ns}`;
  const iso = at.toISOString();
  const fraction = (inDay % 1_000_000_000n).toString().padStart(9, "0").replace(/0+$/, "");
  const time = `${iso.slice(11, 19)}${fraction === "" ? "" : `.${fraction}`}`;
  if (parts === "time") return prefix + time;
  return prefix + (parts === "date" ? iso.slice(0, 10) : `${iso.slice(0, 10)}-${time}`);
}

export function isInteger(shape: Shape): boolean {
  return shape.form in widths && !(shape.type in durations) && !(shape.type in dates) && shape.members === undefined;
}
export function isDuration(shape: Shape): boolean {
  return shape.type in durations;
}
export function isReal(shape: Shape): boolean {
  return shape.form === "f32" || shape.form === "f64";
}
/** Whether a course of it can be drawn. */
export function isDrawable(shape: Shape): boolean {
  return shape.form !== "text";
}

/** A number for drawing: durations in seconds. */
export function numberOf(raw: Raw, shape: Shape): number {
  if (typeof raw === "string") return NaN;
  return shape.type in durations ? Number(raw) / 1e9 : Number(raw);
}

const plainNumber = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i;

/** A number as people write it: with a comma or a point, and lines between digits. */
function plainText(text: string): string {
  return text.trim().replace(",", ".").replace(/_/g, "");
}

/** Whether a text is a whole number that a number of JavaScript would round. */
export function isTooLarge(text: string): boolean {
  const number = plainText(text);
  return /^[-+]?\d+$/.test(number) && !Number.isSafeInteger(Number(number));
}

/** The number that a text is; null: it is none. */
export function plainNumberOf(text: string): number | null {
  const number = plainText(text);
  return plainNumber.test(number) && Number.isFinite(Number(number)) ? Number(number) : null;
}

const unitsOfSecond: Record<string, number> = { s: 1, ms: 1e3, us: 1e6, ns: 1e9 };
const secondsOfUnit: Record<string, number> = { d: 86_400, h: 3600, m: 60 };

/** The seconds of T#1m30s, also without T#; null: it is no duration. */
export function secondsOf(text: string): number | null {
  const found = /^(?:(?:LTIME|TIME|LT|T)#)?([-+]?)((?:\d+(?:\.\d+)?(?:ms|us|ns|d|h|m|s))+)$/i.exec(plainText(text));
  if (found === null) return null;
  let seconds = 0;
  let last = Infinity;
  for (const [, digits, name] of (found[2] ?? "").matchAll(/([\d.]+)([a-z]+)/gi)) {
    const unit = (name ?? "").toLowerCase();
    const size = secondsOfUnit[unit] ?? 1 / (unitsOfSecond[unit] ?? 1);
    // As IEC 61131-3 writes them: each unit once, the larger ones first.
    if (size >= last) return null;
    last = size;
    seconds += unit in secondsOfUnit ? Number(digits) * size : Number(digits) / (unitsOfSecond[unit] ?? 1);
  }
  return Number.isFinite(seconds) ? Number((found[1] === "-" ? -seconds : seconds).toFixed(9)) : null;
}

function nanoseconds(seconds: number): bigint {
  const ns = Math.round(seconds * 1e9);
  return Number.isFinite(ns) ? BigInt(ns) : 0n;
}

/** What a number of a scale would be in a frame: the inverse of numberOf. */
export function rawOf(number: number, shape: Shape): Raw {
  if (isDuration(shape)) return nanoseconds(number);
  return isReal(shape) || !Number.isFinite(number) ? number : BigInt(Math.round(number));
}

/** Shortest text of a REAL: frames carry it as a double. */
function realText(value: number, single: boolean): string {
  if (!single || !Number.isFinite(value)) return String(value);
  for (let digits = 1; digits <= 9; ++digits) {
    const text = value.toPrecision(digits);
    if (Math.fround(Number(text)) === value) return String(Number(text));
  }
  return String(value);
}

export function valueText(raw: Raw | undefined, shape: Shape | undefined, base = 10): string {
  if (raw === undefined || shape === undefined) return "…";
  if (typeof raw === "string") return raw;
  if (typeof raw === "boolean") return raw ? "TRUE" : "FALSE";
  if (shape.members !== undefined) {
    const member = shape.members.find((one) => BigInt(one.value) === BigInt(raw));
    if (member !== undefined) return member.name;
  }
  if (isReal(shape)) return realText(Number(raw), shape.form === "f32");
  const prefix = durations[shape.type];
  if (prefix !== undefined) return durationText(BigInt(raw), prefix);
  const date = dates[shape.type];
  if (date !== undefined) return dateText(BigInt(raw), date);
  if (base === 10) return raw.toString();
  return basedText(BigInt(raw), widths[shape.form] ?? 64, base);
}

/** "16#00FF": all digits of the width, negative numbers as their bits. */
function basedText(value: bigint, width: number, base: number): string {
  const bits = BigInt.asUintN(width, value).toString(base).toUpperCase();
  const digits = base === 16 ? width / 4 : base === 8 ? Math.ceil(width / 3) : width;
  return `${base}#${bits.padStart(digits, "0")}`;
}

/** What people enter, as a value for a call; null: no value of this form. */
export function parsedValue(text: string, shape: Shape): Value {
  if (shape.form === "bool") {
    const word = text.trim().toUpperCase();
    if (word === "TRUE" || word === "1") return true;
    return word === "FALSE" || word === "0" ? false : null;
  }
  if (shape.form === "text") return text;
  const trimmed = text.trim();
  if (isReal(shape)) {
    const number = plainText(trimmed);
    if (plainNumber.test(number)) return Number(number);
    return /^(NaN|[-+]?Infinity)$/.test(number) ? number.replace("+", "") : null;
  }
  const prefix = durations[shape.type];
  if (prefix !== undefined) {
    // A plain number is seconds, as it is drawn and shown.
    const number = plainText(trimmed);
    return plainNumber.test(number) ? durationText(nanoseconds(Number(number)), prefix) : trimmed.replace(",", ".");
  }
  if (!isInteger(shape)) return trimmed;
  const value = parsedInteger(trimmed, shape);
  if (value === null) return null;
  return widths[shape.form] === 64 ? value.toString() : Number(value);
}

function parsedInteger(text: string, shape: Shape): bigint | null {
  const found = /^([-+]?)(?:(16#|0x)([0-9a-f_]+)|(2#|0b)([01_]+)|(8#|0o)([0-7_]+)|(\d[\d_]*))$/i.exec(text);
  if (found === null) return null;
  const digits = (found[3] ?? found[5] ?? found[7] ?? found[8] ?? "").replace(/_/g, "");
  if (digits === "") return null;
  const prefix = found[3] !== undefined ? "0x" : found[5] !== undefined ? "0b" : found[7] !== undefined ? "0o" : "";
  let value = BigInt(prefix + digits);
  const width = widths[shape.form] ?? 64;
  // The bits of a signed number.
  if (prefix !== "" && found[1] === "" && shape.form.startsWith("i") && value < 1n << BigInt(width)) {
    value = BigInt.asIntN(width, value);
  }
  return found[1] === "-" ? -value : value;
}

/** "1.2 ms", from nanoseconds. */
export function timeText(ns: number): string {
  if (ns < 1000) return `${ns.toFixed(0)} ns`;
  if (ns < 1e6) return `${(ns / 1e3).toPrecision(3)} µs`;
  if (ns < 1e9) return `${(ns / 1e6).toPrecision(3)} ms`;
  return `${(ns / 1e9).toPrecision(3)} s`;
}

/** "1.2 GB". */
export function bytesText(bytes: number): string {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let unit = 0;
  let value = bytes;
  for (; value >= 1000 && unit < units.length - 1; ++unit) value /= 1000;
  return `${unit === 0 ? value : value.toPrecision(3)} ${units[unit] ?? ""}`;
}

/** "2 d 3 h", "4 min 12 s". */
export function ageText(ms: number): string {
  const s = Math.floor(ms / 1000);
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min ${s % 60} s`;
  if (s < 86_400) return `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min`;
  return `${Math.floor(s / 86_400)} d ${Math.floor((s % 86_400) / 3600)} h`;
}
