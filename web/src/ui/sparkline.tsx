// The latest course of a value as a small picture.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { Live } from "../live";
import { texts } from "../texts";
import { numberOf } from "../values";

const points = 120;

/** The latest values, a point for each change or tenth of a second. */
export function Sparkline(properties: { live: Live }): JSX.Element | null {
  const { live } = properties;
  const course = useRef<number[]>([]);
  const latest = useRef(live);
  latest.current = live;
  const [, redraw] = useState(0);
  useEffect(() => {
    const timer = setInterval(() => {
      const { raw, shape } = latest.current;
      if (raw === undefined || shape === undefined) return;
      course.current = [...course.current, numberOf(raw, shape)].slice(-points);
      redraw((n) => n + 1);
    }, 200);
    return () => clearInterval(timer);
  }, []);
  const all = course.current.filter(Number.isFinite);
  if (all.length < 2) return <div class="sparkline" />;
  const least = Math.min(...all);
  const most = Math.max(...all);
  const height = (value: number): number => (most === least ? 20 : 38 - ((value - least) / (most - least)) * 36);
  const line = all.map((value, i) => `${i === 0 ? "M" : "L"}${((i / (points - 1)) * 200).toFixed(1)} ${height(value).toFixed(1)}`).join("");
  const words = `${texts.variables.course}: ${Number(least.toPrecision(6))} … ${Number(most.toPrecision(6))}`;
  return (
    <figure class="sparkline">
      <svg viewBox="0 0 200 40" preserveAspectRatio="none" role="img" aria-label={words}>
        <path d={line} />
      </svg>
      <figcaption class="quiet-text number">{words}</figcaption>
    </figure>
  );
}
