// One scroll over the whole drawing of a POU, of which only what is in view is in the document.
import type { JSX } from "preact";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { texts } from "../texts";
import { Tiles, type View } from "./tiles";

const t = texts.diagrams;
/** Browsers draw nothing beyond some height. */
const mostPixels = 15_000_000;

/** What is selected in a drawing. */
export interface Selected {
  /** "contact", "coil", "block" ..; "name" in a text. */
  kind: string;
  /** Variable or instance, or empty. */
  name: string;
  /** Of a block. */
  type: string;
}

function selectedBy(element: Element): Selected {
  const [kind = ""] = (element.getAttribute("class") ?? "").split(" ");
  return { kind, name: element.getAttribute("data-name") ?? "", type: element.getAttribute("data-type") ?? "" };
}

/** The nearest element in a direction, for arrow keys. */
function nearest(from: Element, all: Iterable<Element>, dx: number, dy: number): Element | undefined {
  const middle = (one: Element): [number, number] => {
    const box = one.getBoundingClientRect();
    return [box.x + box.width / 2, box.y + box.height / 2];
  };
  const [x, y] = middle(from);
  let best: Element | undefined;
  let least = Infinity;
  for (const one of all) {
    const [ox, oy] = middle(one);
    const along = (ox - x) * dx + (oy - y) * dy;
    const beside = Math.abs((ox - x) * dy) + Math.abs((oy - y) * dx);
    if (one === from || along < 2) continue;
    const far = along + 3 * beside;
    if (far < least) {
      least = far;
      best = one;
    }
  }
  return best;
}

export function Sheet(properties: {
  pou: string;
  width: number;
  height: number;
  zoom: number;
  /** Where to go; another object: to go there again. */
  goal: View | undefined;
  live: boolean;
  onTiles: (tiles: Tiles | undefined) => void;
  onPoints: (points: number[]) => void;
  onSelect: (selected: Selected | undefined) => void;
  onProblem: (error: unknown) => void;
  onZoom: (direction: 1 | -1) => void;
}): JSX.Element {
  const frame = useRef<HTMLDivElement>(null);
  const inner = useRef<HTMLDivElement>(null);
  const tiles = useRef<Tiles | undefined>(undefined);
  const marker = useRef<HTMLDivElement>(null);
  const latest = useRef(properties);
  const { pou, width, height, goal } = properties;
  const zoom = Math.min(properties.zoom, mostPixels / Math.max(width, height, 1));
  const before = useRef(zoom);
  latest.current = properties;

  const show = (): void => {
    const element = frame.current;
    if (element === null) return;
    const spare = 200;
    tiles.current?.show(
      {
        x: Math.max(0, element.scrollLeft / zoom - spare),
        y: Math.max(0, element.scrollTop / zoom - spare),
        width: element.clientWidth / zoom + 2 * spare,
        height: element.clientHeight / zoom + 2 * spare,
      },
      zoom,
    );
  };
  const showNow = useRef(show);
  showNow.current = show;

  useLayoutEffect(() => {
    const place = inner.current;
    if (place === null) return undefined;
    const made = new Tiles(
      place,
      pou,
      width,
      height,
      (points) => latest.current.onPoints(points),
      (error) => latest.current.onProblem(error),
    );
    tiles.current = made;
    latest.current.onTiles(made);
    const observer = new ResizeObserver(() => showNow.current());
    if (frame.current !== null) observer.observe(frame.current);
    return () => {
      observer.disconnect();
      made.close();
      tiles.current = undefined;
      latest.current.onTiles(undefined);
    };
  }, [pou, width, height]);

  useLayoutEffect(() => {
    const element = frame.current;
    if (element !== null && before.current !== zoom) {
      // What was in the middle stays there.
      const middle = (scroll: number, size: number): number => ((scroll + size / 2) / before.current) * zoom - size / 2;
      element.scrollTop = middle(element.scrollTop, element.clientHeight);
      element.scrollLeft = middle(element.scrollLeft, element.clientWidth);
    }
    before.current = zoom;
    show();
  }, [zoom, pou, width, height]);

  useEffect(() => {
    const element = frame.current;
    const mark = marker.current;
    if (element === null || mark === null) return undefined;
    if (goal === undefined) {
      mark.hidden = true;
      return undefined;
    }
    element.scrollTop = (goal.y + goal.height / 2) * zoom - element.clientHeight / 2;
    element.scrollLeft = Math.min((goal.x + goal.width / 2) * zoom - element.clientWidth / 2, (goal.x - 20) * zoom);
    const space = 6;
    mark.style.left = `${goal.x * zoom - space}px`;
    mark.style.top = `${goal.y * zoom - space}px`;
    mark.style.width = `${goal.width * zoom + 2 * space}px`;
    mark.style.height = `${goal.height * zoom + 2 * space}px`;
    mark.hidden = false;
    const timer = setTimeout(() => (mark.hidden = true), 4000);
    return () => clearTimeout(timer);
  }, [goal, pou, width, height]);

  const select = (target: EventTarget | null): void => {
    const found = target instanceof Element ? target.closest("[data-name], [data-e]") : null;
    properties.onSelect(found === null ? undefined : selectedBy(found));
    frame.current?.querySelectorAll(".selected").forEach((one) => one.classList.remove("selected"));
    found?.classList.add("selected");
    if (found instanceof SVGElement) found.focus({ preventScroll: true });
  };
  const selectable = (): NodeListOf<Element> | [] => inner.current?.querySelectorAll("[data-e], tspan[data-name]") ?? [];
  const onKeyDown = (event: KeyboardEvent): void => {
    const arrows: Record<string, [number, number]> = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] };
    const at = document.activeElement;
    const inside = at instanceof SVGElement;
    const arrow = arrows[event.key];
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    if (event.key === "Enter" || event.key === " ") {
      if (inside) select(at);
      else {
        const box = frame.current?.getBoundingClientRect();
        const first = [...selectable()].find((one) => box !== undefined && one.getBoundingClientRect().top >= box.top);
        if (first instanceof SVGElement) first.focus();
      }
    } else if (event.key === "Escape" && inside) {
      frame.current?.focus();
    } else if (event.key === "+" || event.key === "-") {
      properties.onZoom(event.key === "+" ? 1 : -1);
    } else if (arrow !== undefined && inside) {
      const next = nearest(at, selectable(), arrow[0], arrow[1]);
      if (next instanceof SVGElement) next.focus();
    } else {
      return;
    }
    event.preventDefault();
  };

  return (
    <div
      ref={frame}
      class={properties.live ? "sheet" : "sheet still"}
      role="region"
      aria-label={t.sheet(pou)}
      tabIndex={0}
      onScroll={show}
      onClick={(event) => select(event.target)}
      onKeyDown={onKeyDown}
    >
      <div class="sheet-in" style={{ width: `${width * zoom}px`, height: `${height * zoom}px` }}>
        <div ref={inner} />
        <div ref={marker} class="found-here" hidden />
      </div>
    </div>
  );
}
