// An element with the courses of variables, from when the page was opened.
import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { LayoutValue } from "../../client/connection";
import { Courses } from "../course";
import type { LiveValues } from "../live";
import { Chart, seriesColours } from "../pages/chart";
import { texts } from "../texts";
import { clipped, type Raw } from "../values";
import { lastPart, type HmiElement } from "./document";

export function Plot(properties: { element: HmiElement; values: LiveValues }): JSX.Element {
  const { element, values } = properties;
  const paths = (element.variables ?? []).filter((path) => path !== "");
  const key = paths.join("\n");
  const [courses, setCourses] = useState<Courses>();
  const [forms, setForms] = useState("");
  useEffect(() => {
    const made = new Courses();
    const known = new Map<string, { shape: LayoutValue; raw: Raw }>();
    for (const path of paths) {
      made.add(path);
      const { shape, raw } = values.hold(path).peek();
      if (shape !== undefined && raw !== undefined) known.set(path, { shape, raw });
    }
    if (known.size !== 0) made.beginWith(values.now(), known);
    setCourses(made);
    setForms(made.series.map((one) => one.shape?.form ?? "").join());
    const end = values.onFrame((frame, layout) => {
      made.take(frame, layout);
      setForms(made.series.map((one) => one.shape?.form ?? "").join());
    });
    const endGaps = values.onGap((time) => made.gap(time));
    return () => {
      end();
      endGaps();
      for (const path of paths) values.release(path);
    };
  }, [values, key]);
  const range = element.low !== undefined && element.high !== undefined ? ([element.low, element.high] as const) : undefined;
  return (
    <>
      <span class="hmi-legend">
        {element.label === undefined ? null : <span class="hmi-label">{clipped(element.label, 80)}</span>}
        {paths.map((path, i) => (
          <span key={path}>
            <svg class={`key series-${(i % seriesColours) + 1}`} viewBox="0 0 16 8" aria-hidden="true">
              <line x1="0" x2="16" y1="4" y2="4" />
            </svg>
            {clipped(lastPart(path), 40)}
          </span>
        ))}
      </span>
      {courses === undefined || paths.length === 0 ? null : (
        <Chart
          key={`${key}\n${forms}`}
          courses={courses}
          view={{ span: element.seconds ?? 60, fixed: undefined, byScan: false }}
          now={() => values.now()}
          label={texts.hmi.plot(paths.map(lastPart).join(", "))}
          range={range}
        />
      )}
    </>
  );
}
