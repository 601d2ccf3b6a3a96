// What can be put on a page: dragged with a pointer, or put at the first free place by a key or a click.
import type { JSX } from "preact";
import { useRef, useState } from "preact/hooks";
import { texts } from "../texts";
import type { HmiKind, HmiPage } from "./document";

const t = texts.hmi;
/** Pixels after which a press is a drag. */
const dragBegins = 5;

/** The cell of the page under a point, where its middle is. */
export function cellAt(page: HmiPage, clientX: number, clientY: number, width: number, height: number): { x: number; y: number } | undefined {
  const canvas = document.querySelector(".hmi-grid");
  if (canvas === null) return undefined;
  const box = canvas.getBoundingClientRect();
  if (clientX < box.left || clientX > box.right || clientY < box.top || clientY > box.bottom) return undefined;
  const x = Math.round(((clientX - box.left) / box.width) * page.columns - width / 2);
  const y = Math.round(((clientY - box.top) / box.height) * page.rows - height / 2);
  return { x: Math.max(0, Math.min(x, page.columns - width)), y: Math.max(0, Math.min(y, page.rows - height)) };
}

export function Palette(properties: { kinds: readonly HmiKind[]; page: HmiPage | undefined; onMake: (kind: HmiKind, place?: { x: number; y: number }) => void }): JSX.Element {
  const { page } = properties;
  const press = useRef<{ x: number; y: number; drags: boolean } | undefined>(undefined);
  const [ghost, setGhost] = useState<{ kind: HmiKind; x: number; y: number }>();
  return (
    <>
      <ul class="hmi-kinds">
        {properties.kinds.map((kind) => (
          <li key={kind.name}>
            <button
              type="button"
              class="hmi-kind"
              data-kind={kind.name}
              title={kind.doc}
              disabled={page === undefined}
              onPointerDown={(event) => {
                if (event.button !== 0) return;
                press.current = { x: event.clientX, y: event.clientY, drags: false };
                event.currentTarget.setPointerCapture(event.pointerId);
              }}
              onPointerMove={(event) => {
                const from = press.current;
                if (from === undefined) return;
                from.drags ||= Math.hypot(event.clientX - from.x, event.clientY - from.y) > dragBegins;
                if (from.drags) setGhost({ kind, x: event.clientX, y: event.clientY });
              }}
              onPointerUp={(event) => {
                const from = press.current;
                setGhost(undefined);
                if (from === undefined || !from.drags || page === undefined) return;
                const place = cellAt(page, event.clientX, event.clientY, kind.width, kind.height);
                if (place !== undefined) properties.onMake(kind, place);
              }}
              onLostPointerCapture={() => setGhost(undefined)}
              onPointerCancel={() => {
                press.current = undefined;
                setGhost(undefined);
              }}
              onClick={() => {
                // WHY here: a click follows each drag, too.
                const dragged = press.current?.drags ?? false;
                press.current = undefined;
                if (!dragged) properties.onMake(kind);
              }}
            >
              {t.kinds[kind.name] ?? kind.name}
            </button>
          </li>
        ))}
      </ul>
      <p class="quiet-text">{t.editor.paletteHelp}</p>
      {ghost === undefined ? null : (
        <div class="hmi-ghost" style={{ left: `${ghost.x}px`, top: `${ghost.y}px` }} aria-hidden="true">
          {t.kinds[ghost.kind.name] ?? ghost.kind.name}
        </div>
      )}
    </>
  );
}
