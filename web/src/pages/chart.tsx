// The chart of courses: uPlot, in the colours of the page.
import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import type { Drawn } from "../history";
import { useSignal } from "../signals";
import { texts } from "../texts";
import { colour, colours } from "../theme";
import { clipped } from "../values";

export const seriesColours = 8;
const mostDrawn = 4000;

/** Between two ticks in seconds, text of a tick, then that which joins it where day, .. changes: uPlot's form. */
const timeTexts: uPlot.Axis.Values = [
  [86_400, "{YYYY}-{MM}-{DD}", null, null, null, null, null, null, 0],
  [3600, "{HH}:{mm}", "\n{YYYY}-{MM}-{DD}", null, "\n{MM}-{DD}", null, null, null, 1],
  [60, "{HH}:{mm}", "\n{YYYY}-{MM}-{DD}", null, "\n{MM}-{DD}", null, null, null, 1],
  [1, "{HH}:{mm}:{ss}", "\n{YYYY}-{MM}-{DD}", null, "\n{MM}-{DD}", null, null, null, 1],
  [0.001, "{ss}.{fff}", "\n{YYYY}-{MM}-{DD} {HH}:{mm}", null, "\n{MM}-{DD} {HH}:{mm}", null, "\n{HH}:{mm}", null, 1],
];

export interface ChartView {
  /** Seconds that are shown when it goes on; the end is now. */
  span: number;
  /** Set while it rests: from when to when, in seconds. */
  fixed: { from: number; to: number } | undefined;
  byScan: boolean;
  /** It rests where somebody has moved it to, not where it was. */
  moved?: boolean;
}

export function Chart(properties: {
  courses: Drawn;
  view: ChartView;
  /** Changes when series come or go. */
  key: string;
  now: () => number;
  onZoom?: (from: number, to: number) => void;
  onReset?: () => void;
  onCursor?: (values: (number | undefined)[] | undefined) => void;
  /** For screen readers; without: as the page of trends has it. */
  label?: string;
  /** Of the axis of numbers; without: what is drawn. */
  range?: readonly [number, number] | undefined;
}): JSX.Element {
  const { courses } = properties;
  const frame = useRef<HTMLDivElement>(null);
  const latest = useRef(properties);
  latest.current = properties;
  const painted = useSignal(colours);

  useEffect(() => {
    const element = frame.current;
    if (element === null) return undefined;
    const axis = { stroke: colour("text-quiet"), grid: { stroke: colour("line"), width: 1 }, ticks: { stroke: colour("line"), width: 1 }, font: "12px system-ui, sans-serif" };
    const isBool = (i: number): boolean => courses.series[i]?.shape?.form === "bool";
    const anyNumber = courses.series.some((_, i) => !isBool(i));
    const anyBool = courses.series.some((_, i) => isBool(i));
    let zooming = false;
    const chart = new uPlot(
      {
        width: element.clientWidth,
        height: element.clientHeight,
        legend: { show: false },
        cursor: { show: properties.onCursor !== undefined, drag: { x: properties.onZoom !== undefined, y: false, setScale: false }, focus: { prox: 30 } },
        // As the log and the CSV say it.
        tzDate: (seconds) => uPlot.tzDate(new Date(seconds * 1000), "Etc/UTC"),
        scales: {
          x: { time: !properties.view.byScan },
          y: properties.range === undefined ? { auto: true } : { auto: false, range: [...properties.range] },
          bool: { auto: false, range: [-0.15, 1.15] },
        },
        axes: [
          properties.view.byScan ? axis : { ...axis, values: timeTexts },
          { ...axis, scale: "y", size: 64, show: anyNumber },
          { ...axis, scale: "bool", size: 64, side: anyNumber ? 1 : 3, show: anyBool, grid: { show: false }, splits: () => [0, 1], values: () => ["FALSE", "TRUE"] },
        ],
        series: [
          {},
          ...courses.series.map((one, i) => ({
            label: clipped(one.path, 60),
            scale: isBool(i) ? "bool" : "y",
            stroke: colour(`series-${(i % seriesColours) + 1}`),
            width: 2,
            points: { show: false },
            paths: uPlot.paths.stepped?.({ align: 1 }),
          })),
        ],
        hooks: {
          setSelect: [
            (plot: uPlot) => {
              if (zooming || plot.select.width < 4) return;
              zooming = true;
              const { from, to } = rangeOf(plot);
              plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
              zooming = false;
              latest.current.onZoom?.(from, to);
            },
          ],
          setCursor: [
            (plot: uPlot) => {
              const index = plot.cursor.idx;
              latest.current.onCursor?.(index === null || index === undefined ? undefined : plot.data.slice(1).map((column) => column[index] ?? undefined));
            },
          ],
        },
      },
      [[], ...courses.series.map(() => [])],
      element,
    );
    /** Of the selection, as times. */
    const rangeOf = (plot: uPlot): { from: number; to: number } => {
      const width = plot.bbox.width / devicePixelRatio;
      const { from, to } = shownRange();
      const part = (left: number): number => from + ((to - from) * left) / width;
      return { from: part(plot.select.left), to: part(plot.select.left + plot.select.width) };
    };
    const shownRange = (): { from: number; to: number } => {
      const { view, now } = latest.current;
      if (view.fixed !== undefined) return view.fixed;
      const to = now();
      return { from: to - view.span, to };
    };
    let request = 0;
    let drawn = 0;
    const draw = (at: number): void => {
      request = requestAnimationFrame(draw);
      if (at - drawn < 90) return;
      drawn = at;
      const range = shownRange();
      const columns = courses.columns(range.from, range.to, latest.current.now(), latest.current.view.byScan, mostDrawn);
      const x = columns[0];
      chart.setData(columns as unknown as uPlot.AlignedData, false);
      if (latest.current.view.byScan) {
        if (x !== undefined && x.length > 1) chart.setScale("x", { min: x[0] ?? 0, max: x[x.length - 1] ?? 1 });
      } else {
        chart.setScale("x", { min: range.from, max: range.to });
      }
    };
    request = requestAnimationFrame(draw);
    const observer = new ResizeObserver(() => chart.setSize({ width: element.clientWidth, height: element.clientHeight }));
    observer.observe(element);
    return () => {
      cancelAnimationFrame(request);
      observer.disconnect();
      chart.destroy();
    };
  }, [painted, properties.view.byScan]);
  return <div class="chart" ref={frame} role="img" aria-label={properties.label ?? texts.trends.chart} onDblClick={properties.onReset} />;
}
