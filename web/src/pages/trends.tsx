// Courses of variables, as they come from the stream of values.
import type { JSX } from "preact";
import { useEffect, useId, useMemo, useState } from "preact/hooks";
import type { Courses } from "../course";
import { isKept, PastCourses } from "../history";
import { keeper, periods } from "../course_keeper";
import { LiveValues, useLive } from "../live";
import { plc, problemOf, usePolled, type Problem } from "../plc";
import { link, route } from "../route";
import { useSignal } from "../signals";
import { texts } from "../texts";
import { download } from "../ui/download";
import { Choice, Empty, ProblemBox, Section } from "../ui/parts";
import { PathInput } from "../ui/path_input";
import { clipped, isDrawable, valueText } from "../values";
import { Chart, seriesColours, type ChartView } from "./chart";

const t = texts.trends;
const windows = [10, 60, 300, 900, 3600, 8 * 3600, 86_400, 7 * 86_400, 30 * 86_400] as const;
/** What the browser itself keeps, and the longest that is shown. */
const longestLive = 3600;
const longest = 366 * 86_400;
const axes = ["time", "scans"] as const;

function AddVariable(properties: { onAdd: (path: string) => void }): JSX.Element {
  const [text, setText] = useState("");
  const id = useId();
  return (
    <form
      class="field inline grow"
      onSubmit={(event) => {
        event.preventDefault();
        if (text.trim() === "") return;
        properties.onAdd(text.trim());
        setText("");
      }}
    >
      <label for={id}>{t.add}</label>
      <span class="joined">
        <PathInput id={id} value={text} placeholder={t.addHelp} onInput={setText} />
        <button type="submit">{t.addSubmit}</button>
      </span>
    </form>
  );
}

function SeriesRow(properties: {
  path: string;
  place: number;
  values: LiveValues;
  courses: Courses;
  atCursor: number | undefined;
  ends: { least: number; most: number } | undefined;
  onRemove: () => void;
}): JSX.Element {
  const { path, courses } = properties;
  const live = useLive(properties.values, path);
  const series = courses.series[properties.place];
  const drawable = live.shape === undefined || isDrawable(live.shape);
  const text = live.problem !== "" ? live.problem : drawable ? valueText(live.raw, live.shape) : t.none;
  const rounded = (value: number | undefined): string => (value === undefined || !Number.isFinite(value) ? texts.nothing : String(Number(value.toPrecision(7))));
  let least = properties.ends?.least;
  let most = properties.ends?.most;
  for (let i = 0; properties.ends === undefined && series !== undefined && i < courses.length; ++i) {
    const value = series.samples[i] ?? NaN;
    if (least === undefined || value < least) least = value;
    if (most === undefined || value > most) most = value;
  }
  return (
    <tr>
      <td data-title={t.signal}>
        <svg class={`key series-${(properties.place % seriesColours) + 1}`} viewBox="0 0 16 8" aria-hidden="true">
          <line x1="0" x2="16" y1="4" y2="4" />
        </svg>
        <span class="path">{clipped(path, 120)}</span>
      </td>
      <td class="number" data-title={t.value}>
        {clipped(text, 100)}
      </td>
      <td class="number" data-title={t.at}>
        {rounded(properties.atCursor)}
      </td>
      <td class="number" data-title={t.least}>
        {rounded(least)}
      </td>
      <td class="number" data-title={t.most}>
        {rounded(most)}
      </td>
      <td class="end">
        <button type="button" class="quiet small" aria-label={t.remove(path)} onClick={properties.onRemove}>
          ✕
        </button>
      </td>
    </tr>
  );
}

/** Longer ones only where there is a historian. */
function offeredWindows(span: number, hasPast: boolean): readonly number[] {
  const offered: number[] = windows.filter((one) => hasPast || one <= longestLive);
  return offered.includes(span) ? offered : [...offered, span];
}

export function TrendsPage(): JSX.Element {
  const paths = useSignal(keeper.paths);
  const period = useSignal(keeper.period);
  const forms = useSignal(keeper.forms);
  const values = useSignal(keeper.values);
  const [view, setView] = useState<ChartView>({ span: 60, fixed: undefined, byScan: false });
  const [cursor, setCursor] = useState<(number | undefined)[]>();
  const { parameters } = useSignal(route);
  const { courses } = keeper;
  const now = (): number => keeper.now();
  const kept = usePolled(() => plc.historyTags(), 0).answer?.tags ?? [];
  const [problem, setProblem] = useState<Problem>();
  const [, setFetched] = useState(0);
  useEffect(() => keeper.start(), []);
  useEffect(() => {
    const path = parameters.get("path");
    if (path === null) return;
    keeper.add(path);
    // So that it does not come back with a reload when it was taken away.
    history.replaceState(null, "", link("trends"));
  }, [parameters]);
  const range = (): { from: number; to: number } => view.fixed ?? { from: now() - view.span, to: now() };
  const zoom = (factor: number): void => {
    const { from, to } = range();
    if (view.fixed === undefined) {
      setView({ ...view, span: Math.max(1, Math.min(kept.length === 0 ? longestLive : longest, view.span * factor)) });
      return;
    }
    const middle = (from + to) / 2;
    const half = Math.max(0.05, ((to - from) * factor) / 2);
    setView({ ...view, fixed: { from: middle - half, to: middle + half }, moved: true });
  };
  const pan = (part: number): void => {
    const { from, to } = range();
    const by = (to - from) * part;
    setView({ ...view, fixed: { from: from + by, to: to + by }, moved: true });
  };
  // What began before the page was opened only the historian knows.
  const isPast = paths.some((path) => isKept(path, kept)) && (view.fixed === undefined ? view.span > longestLive : view.moved === true && view.fixed.from < courses.oldest - 1);
  const byScan = view.byScan && !isPast;
  const past = useMemo(
    () =>
      isPast
        ? new PastCourses(courses.series, kept, (error) => {
            setProblem(error === undefined ? undefined : problemOf(error));
            setFetched((n) => n + 1);
          })
        : undefined,
    [isPast, paths.join("\n"), forms, kept.length],
  );
  useEffect(() => () => past?.end(), [past]);
  return (
    <Section title={t.courses} class="fill">
      <div class="tools">
        <AddVariable onAdd={(path) => keeper.add(path)} />
        <Choice
          label={t.window}
          value={windows.find((one) => one === view.span) ?? view.span}
          options={offeredWindows(view.span, kept.length !== 0)}
          text={(one) => t.windows(Math.round(one))}
          onChange={(span) => setView({ ...view, span, fixed: undefined })}
        />
        <Choice
          label={t.axis}
          value={view.byScan ? "scans" : "time"}
          options={axes}
          text={(one) => (one === "time" ? t.byTime : t.byScan)}
          onChange={(one) => setView({ ...view, byScan: one === "scans" })}
        />
        <Choice label={t.period} value={period} options={periods} text={(one) => `${one} ms`} onChange={(one) => keeper.setPeriod(one)} />
        <span class="buttons">
          <button type="button" aria-pressed={view.fixed !== undefined} onClick={() => setView({ ...view, fixed: view.fixed === undefined ? range() : undefined, moved: view.span > longestLive })}>
            {view.fixed === undefined ? t.pause : t.resume}
          </button>
          <button type="button" aria-label={t.earlier} title={t.earlier} onClick={() => pan(-0.25)}>
            ◂
          </button>
          <button type="button" aria-label={t.later} title={t.later} onClick={() => pan(0.25)}>
            ▸
          </button>
          <button type="button" aria-label={t.zoomIn} title={t.zoomIn} onClick={() => zoom(0.5)}>
            +
          </button>
          <button type="button" aria-label={t.zoomOut} title={t.zoomOut} onClick={() => zoom(2)}>
            −
          </button>
          <button type="button" disabled={courses.length === 0} onClick={() => download("trends.csv", (past ?? courses).csv(), "text/csv")}>
            {t.csv}
          </button>
        </span>
      </div>
      {paths.length === 0 || values === undefined ? (
        <Empty>{t.empty}</Empty>
      ) : (
        <>
          <ProblemBox problem={problem} />
          <Chart
            key={`${paths.join("\n")}\n${forms}\n${String(isPast)}`}
            courses={past ?? courses}
            view={byScan === view.byScan ? view : { ...view, byScan }}
            now={now}
            onZoom={(from, to) => setView({ ...view, fixed: { from, to }, moved: true })}
            onReset={() => setView({ ...view, fixed: undefined })}
            onCursor={setCursor}
          />
          <p class="quiet-text">{past?.byScan === true ? t.scanned : isPast ? t.past : kept.length === 0 ? t.help : `${t.help} ${t.hasPast(kept.length)}`}</p>
          <div class="table-frame">
            <table aria-label={texts.pages.trends}>
              <thead>
                <tr>
                  {[t.signal, t.value, t.at, t.least, t.most].map((title, i) => (
                    <th key={title} scope="col" class={i === 0 ? undefined : "number"}>
                      {title}
                    </th>
                  ))}
                  <td />
                </tr>
              </thead>
              <tbody>
                {paths.map((path, i) => (
                  <SeriesRow key={path} path={path} place={i} values={values} courses={courses} atCursor={cursor?.[i]} ends={past?.ends(path)} onRemove={() => keeper.remove(path)} />
                ))}
              </tbody>
            </table>
          </div>
        </>
      )}
    </Section>
  );
}
