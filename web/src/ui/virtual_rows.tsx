// Rows of which only those in view are in the document, so that there may be hundreds of thousands. One row is active;
// keys move it. The container has the focus, and tells screen readers which row it is about.
import type { ComponentChildren, JSX } from "preact";
import { useEffect, useId, useLayoutEffect, useRef, useState } from "preact/hooks";

/** Rows kept beyond both edges of the view. */
const margin = 6;
/** Browsers draw nothing beyond some height. */
const mostHeight = 15_000_000;

export interface RowAttributes {
  id: string;
  class: string;
  style: { top: string; height: string };
  onClick: () => void;
}

export function VirtualRows(properties: {
  label: string;
  role: "tree" | "listbox";
  count: number;
  rowHeight: number;
  active: number;
  onActive: (row: number) => void;
  /** True: the key is done with. */
  onKey?: (event: KeyboardEvent) => boolean;
  row: (index: number, attributes: RowAttributes) => ComponentChildren;
  class?: string;
}): JSX.Element {
  const { count, rowHeight, active } = properties;
  const frame = useRef<HTMLDivElement>(null);
  const id = useId();
  const [view, setView] = useState({ top: 0, height: 400 });
  const height = Math.min(count * rowHeight, mostHeight);

  useLayoutEffect(() => {
    const element = frame.current;
    if (element === null) return undefined;
    const measure = (): void => setView({ top: element.scrollTop, height: element.clientHeight });
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    measure();
    return () => observer.disconnect();
  }, []);

  const shownActive = useRef(active);
  useEffect(() => {
    const element = frame.current;
    if (element === null || active === shownActive.current) return;
    shownActive.current = active;
    const top = active * rowHeight;
    if (top < element.scrollTop) element.scrollTop = top;
    if (top + rowHeight > element.scrollTop + element.clientHeight) element.scrollTop = top + rowHeight - element.clientHeight;
  }, [active, rowHeight]);

  const move = (to: number): void => {
    if (count !== 0) properties.onActive(Math.max(0, Math.min(count - 1, to)));
  };
  const page = Math.max(1, Math.floor(view.height / rowHeight) - 1);
  const onKeyDown = (event: KeyboardEvent): void => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const steps: Record<string, number> = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -count, End: count };
    const step = steps[event.key];
    if (step !== undefined) {
      move(active + step);
    } else if (properties.onKey?.(event) !== true) {
      return;
    }
    event.preventDefault();
  };

  const first = Math.max(0, Math.floor(view.top / rowHeight) - margin);
  const last = Math.min(count, Math.ceil((view.top + view.height) / rowHeight) + margin);
  const rows: ComponentChildren[] = [];
  for (let i = first; i < last; ++i) {
    rows.push(
      properties.row(i, {
        id: `${id}-${i}`,
        class: i === active ? "row active" : "row",
        style: { top: `${i * rowHeight}px`, height: `${rowHeight}px` },
        onClick: () => {
          properties.onActive(i);
        },
      }),
    );
  }
  return (
    <div
      ref={frame}
      class={`rows ${properties.class ?? ""}`}
      role={properties.role}
      aria-label={properties.label}
      aria-activedescendant={active >= first && active < last ? `${id}-${active}` : undefined}
      tabIndex={0}
      onKeyDown={onKeyDown}
      onScroll={(event) => setView({ top: event.currentTarget.scrollTop, height: event.currentTarget.clientHeight })}
    >
      <div class="rows-in" role="presentation" style={{ height: `${height}px` }}>
        {rows}
      </div>
    </div>
  );
}
