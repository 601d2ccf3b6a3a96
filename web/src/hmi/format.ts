// Values of elements as texts and parts of a scale.
import type { Live } from "../live";
import { clipped, isInteger, numberOf, valueText } from "../values";
import type { HmiElement } from "./document";

const bases: Record<string, number> = { "16#": 16, "2#": 2, "8#": 8 };

/** The value alone, without its unit. */
export function numberText(live: Live, format: string | undefined): string {
  const { raw, shape } = live;
  if (raw === undefined || shape === undefined) return "…";
  const base = bases[format ?? ""];
  if (base !== undefined) return valueText(raw, shape, base);
  if (format !== undefined && format !== "" && typeof raw !== "string" && typeof raw !== "boolean" && shape.members === undefined) {
    const digits = Math.max(0, format.length - 2);
    // WHY not by a number: those of 64 bits have more digits than it.
    if (isInteger(shape)) return digits === 0 ? raw.toString() : `${raw}.${"0".repeat(digits)}`;
    const number = numberOf(raw, shape);
    if (Number.isFinite(number)) return number.toFixed(digits);
  }
  return clipped(valueText(raw, shape), 200);
}

export function withUnit(text: string, unit: string | undefined): string {
  return unit === undefined || unit === "" ? text : `${text} ${unit}`;
}

export function scaleOf(element: HmiElement): { low: number; high: number } {
  return { low: element.low ?? 0, high: element.high ?? 100 };
}

/** The number of a value; NaN while there is none. */
export function liveNumber(live: Live): number {
  return live.raw === undefined || live.shape === undefined ? NaN : numberOf(live.raw, live.shape);
}

/** Where a value is on its scale: 0 to 1. */
export function partOf(element: HmiElement, value: number): number {
  const { low, high } = scaleOf(element);
  if (!Number.isFinite(value)) return 0;
  return Math.max(0, Math.min(1, (value - low) / (high - low)));
}

/** TRUE, or a number other than zero; of a valve: above zero. */
export function isOn(element: HmiElement, live: Live): boolean {
  if (typeof live.raw === "boolean") return live.raw;
  const number = liveNumber(live);
  return element.kind === "valve" ? number > 0 : Number.isFinite(number) && number !== 0;
}
