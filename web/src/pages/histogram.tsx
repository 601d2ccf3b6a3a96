// How often something took how long: bars over a logarithmic time, heights logarithmic, so that a single late scan shows.
import type { JSX } from "preact";
import type { Bar } from "../../client/calls";
import { texts } from "../texts";
import { timeText } from "../values";

const t = texts.overview;
/** Parts of a power of two, as the server makes them. */
const parts = 4;
const width = 240;
const height = 48;

export function Histogram(properties: { title: string; bars: readonly Bar[] }): JSX.Element {
  const { title, bars } = properties;
  if (bars.length === 0) return <p class="quiet-text">{t.noScan}</p>;
  const placeOf = (bar: Bar): number => Math.round(Math.log2(Math.max(1, bar.up_to_ns)) * parts);
  const first = placeOf(bars[0] as Bar);
  const last = placeOf(bars[bars.length - 1] as Bar);
  const step = width / Math.max(8, last - first + 1);
  const most = Math.max(...bars.map((bar) => bar.count));
  const often = bars.find((bar) => bar.count === most) as Bar;
  const all = bars.reduce((sum, bar) => sum + bar.count, 0);
  const label = t.histogram(title, timeText(often.up_to_ns), all.toLocaleString("en"));
  return (
    <figure class="histogram">
      <svg viewBox={`0 0 ${width} ${height}`} preserveAspectRatio="none" role="img" aria-label={label}>
        {bars.map((bar) => {
          const tall = Math.max(1.5, (Math.log1p(bar.count) / Math.log1p(most)) * height);
          return (
            <rect key={bar.up_to_ns} x={(placeOf(bar) - first) * step} y={height - tall} width={Math.max(1, step - 0.6)} height={tall}>
              <title>{t.bar(timeText(bar.up_to_ns), bar.count)}</title>
            </rect>
          );
        })}
      </svg>
      <figcaption>{t.histogramTitle(title, timeText((bars[0] as Bar).up_to_ns), timeText((bars[bars.length - 1] as Bar).up_to_ns))}</figcaption>
    </figure>
  );
}
