// A page on its grid; where the screen is too narrow for that, its elements one after the other.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { LiveValues } from "../live";
import type { HmiElement, HmiPage } from "./document";
import { Widget } from "./widget";

/** Pixels of a cell below which nothing can be read or hit. */
export const leastCell = 22;
const leastPage = 560;

/** Pixels above and below a page on the screen, and how much of its width it gives away to be seen as a whole. */
const besides = 200;
const leastPart = 0.7;

/** Measures of a page in an element: pixels of a cell, and whether the elements stand one after the other. */
export function useCell(page: HmiPage, editing: boolean): { frame: (element: HTMLElement | null) => void; cell: number; flows: boolean } {
  const [{ width, height }, setSize] = useState({ width: 0, height: innerHeight });
  const shown = useRef<HTMLElement | null>(null);
  const [{ frame, observer, measure }] = useState(() => {
    const measured = (): void => {
      if (shown.current !== null) setSize({ width: shown.current.clientWidth, height: innerHeight });
    };
    const watch = new ResizeObserver(measured);
    return {
      observer: watch,
      measure: measured,
      frame: (element: HTMLElement | null): void => {
        watch.disconnect();
        shown.current = element;
        if (element !== null) watch.observe(element);
        measured();
      },
    };
  });
  useEffect(() => {
    addEventListener("resize", measure);
    return () => {
      removeEventListener("resize", measure);
      observer.disconnect();
    };
  }, []);
  const flows = !editing && width !== 0 && width < Math.max(leastPage, page.columns * leastCell);
  const whole = width / page.columns;
  const cell = editing ? whole : Math.max(whole * leastPart, Math.min(whole, (height - besides) / page.rows));
  return { frame, cell: Math.max(leastCell, cell), flows };
}

/** Where cells are small, so is what is in them: names and controls have place then. */
export function sizeClass(cell: number): string {
  return cell < 32 ? "small" : "";
}

export function placeOf(element: HmiElement): Record<string, string> {
  return { gridColumn: `${element.x + 1} / span ${element.width}`, gridRow: `${element.y + 1} / span ${element.height}` };
}

export function gridOf(page: HmiPage, cell: number): Record<string, string> {
  return {
    "--cell": `${cell.toFixed(2)}px`,
    gridTemplateColumns: `repeat(${page.columns}, minmax(0, 1fr))`,
    gridTemplateRows: `repeat(${page.rows}, ${cell.toFixed(2)}px)`,
    width: `${(cell * page.columns).toFixed(2)}px`,
  };
}

export function Canvas(properties: { page: HmiPage; values: LiveValues }): JSX.Element {
  const { page, values } = properties;
  const { frame, cell, flows } = useCell(page, false);
  const inOrder = flows ? [...page.elements].sort((one, other) => one.y - other.y || one.x - other.x) : page.elements;
  return (
    <div ref={frame}>
      <div key={String(flows)} class={flows ? "hmi flows" : `hmi ${sizeClass(cell)}`} style={flows ? { "--cell": "40px" } : gridOf(page, cell)}>
        {inOrder.map((element) => (
          <div key={`${page.elements.indexOf(element)} ${element.kind} ${element.variable ?? ""}`} class={`hmi-element kind-${element.kind}`} data-path={element.variable} style={flows ? {} : placeOf(element)}>
            <Widget element={element} values={values} />
          </div>
        ))}
      </div>
    </div>
  );
}
