// The page while it is edited: elements are moved and sized on the grid, by pointer or keys.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { LiveValues } from "../live";
import { texts } from "../texts";
import { clipped } from "../values";
import { gridOf, placeOf, sizeClass, useCell } from "./canvas";
import { nameOf, placed, type HmiElement, type HmiPage } from "./document";
import { Widget } from "./widget";

const t = texts.hmi.editor;

interface Drag {
  index: number;
  resizes: boolean;
  fromX: number;
  fromY: number;
  element: HmiElement;
}

const arrows: Record<string, readonly [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export function EditCanvas(properties: {
  page: HmiPage;
  values: LiveValues;
  selected: number | undefined;
  /** Another number: the selected element is new, or wrong, and gets the focus. */
  made: number;
  onSelect: (index: number | undefined) => void;
  /** `step`: changes of the same one are one step to undo. */
  onChange: (index: number, element: HmiElement, step?: string) => void;
  onRemove: (index: number) => void;
  onCopy: (index: number) => void;
}): JSX.Element {
  const { page, values, selected, onSelect, onChange } = properties;
  const { frame, cell } = useCell(page, true);
  const grid = useRef<HTMLDivElement>(null);
  const drag = useRef<Drag | undefined>(undefined);
  const [shown, setShown] = useState<{ index: number; element: HmiElement }>();

  useEffect(() => {
    if (properties.made !== 0) grid.current?.querySelector<HTMLElement>(".selected")?.focus();
  }, [properties.made]);

  const moved = (from: Drag, event: PointerEvent): HmiElement => {
    const dx = Math.round((event.clientX - from.fromX) / cell);
    const dy = Math.round((event.clientY - from.fromY) / cell);
    const { element } = from;
    if (!from.resizes) return placed(page, { ...element, x: element.x + dx, y: element.y + dy });
    const width = Math.max(1, Math.min(element.width + dx, page.columns - element.x));
    const height = Math.max(1, Math.min(element.height + dy, page.rows - element.y));
    return { ...element, width, height };
  };
  const begin = (event: PointerEvent, index: number, resizes: boolean): void => {
    const element = page.elements[index];
    if (event.button !== 0 || element === undefined) return;
    event.stopPropagation();
    onSelect(index);
    drag.current = { index, resizes, fromX: event.clientX, fromY: event.clientY, element };
    if (event.currentTarget instanceof HTMLElement) event.currentTarget.setPointerCapture(event.pointerId);
  };
  const move = (event: PointerEvent): void => {
    if (drag.current !== undefined) setShown({ index: drag.current.index, element: moved(drag.current, event) });
  };
  const end = (event: PointerEvent): void => {
    const from = drag.current;
    drag.current = undefined;
    setShown(undefined);
    if (from === undefined) return;
    const next = moved(from, event);
    const { element } = from;
    if (next.x !== element.x || next.y !== element.y || next.width !== element.width || next.height !== element.height) onChange(from.index, next);
  };
  const cancel = (): void => {
    drag.current = undefined;
    setShown(undefined);
  };
  const onKey = (event: KeyboardEvent, index: number): void => {
    const element = page.elements[index];
    if (element === undefined) return;
    const arrow = arrows[event.key];
    if (arrow !== undefined && !event.ctrlKey && !event.metaKey) {
      event.preventDefault();
      onSelect(index);
      const [dx, dy] = arrow;
      if (event.shiftKey) {
        const width = Math.max(1, Math.min(element.width + dx, page.columns - element.x));
        const height = Math.max(1, Math.min(element.height + dy, page.rows - element.y));
        onChange(index, { ...element, width, height }, `size ${index}`);
      } else {
        onChange(index, { ...element, x: element.x + dx, y: element.y + dy }, `move ${index}`);
      }
    } else if (event.key === "Delete" || event.key === "Backspace") {
      event.preventDefault();
      properties.onRemove(index);
      grid.current?.focus();
    } else if (event.key.toLowerCase() === "d" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      properties.onCopy(index);
    } else if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      onSelect(index);
    } else if (event.key === "Escape") {
      onSelect(undefined);
    }
  };

  return (
    <div class="hmi-scroll" ref={frame}>
      <div
        class={`hmi hmi-grid ${sizeClass(cell)}`}
        ref={grid}
        role="group"
        aria-label={t.canvas}
        tabIndex={-1}
        style={{ ...gridOf(page, cell), backgroundSize: `${cell.toFixed(2)}px ${cell.toFixed(2)}px` }}
        onPointerDown={(event) => {
          if (event.target === event.currentTarget) onSelect(undefined);
        }}
      >
        {page.elements.map((one, index) => {
          const element = shown?.index === index ? shown.element : one;
          const isSelected = selected === index;
          return (
            <div
              key={index}
              class={`hmi-element kind-${element.kind} hmi-edited ${isSelected ? "selected" : ""}`}
              data-kind={element.kind}
              data-path={element.variable}
              style={placeOf(element)}
              role="button"
              tabIndex={0}
              aria-pressed={isSelected}
              aria-label={t.element(texts.hmi.kinds[element.kind] ?? element.kind, clipped(nameOf(element), 60), element.x, element.y, element.width, element.height)}
              onPointerDown={(event) => begin(event, index, false)}
              onPointerMove={move}
              onPointerUp={end}
              onPointerCancel={cancel}
              onLostPointerCapture={cancel}
              onKeyDown={(event) => onKey(event, index)}
            >
              <div class="hmi-still" inert aria-hidden="true">
                <Widget element={element} values={values} />
              </div>
              {isSelected ? (
                <span
                  class="hmi-handle"
                  title={t.resize}
                  onPointerDown={(event) => begin(event, index, true)}
                  onPointerMove={move}
                  onPointerUp={(event) => {
                    event.stopPropagation();
                    end(event);
                  }}
                  onPointerCancel={cancel}
                />
              ) : null}
            </div>
          );
        })}
      </div>
    </div>
  );
}
