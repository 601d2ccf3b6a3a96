// A POU on paper: A4 pages across, each with a title block, of which no rung is cut where that can be.
import { ask, plc } from "../plc";
import { texts } from "../texts";
import { clipped } from "../values";
import { newPicture } from "./tiles";

const t = texts.diagrams;
/** Pixels of a page that a drawing has: 277 by 166 mm. */
const pageWidth = 1047;
const pageHeight = 627;
const leastScale = 0.6;
export const mostPages = 300;

export interface PrintPart {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** The pieces of a drawing that go onto pages, and how large they are drawn. */
export function pagesOf(width: number, height: number, breaks: readonly number[]): { scale: number; parts: PrintPart[] } {
  const scale = Math.max(leastScale, Math.min(1, pageWidth / Math.max(width, 1)));
  const wide = pageWidth / scale;
  const high = pageHeight / scale;
  const parts: PrintPart[] = [];
  for (let y = 0, next = 0; y < height && parts.length < mostPages; ) {
    let end = Math.min(height, y + high);
    if (end < height) {
      while (next < breaks.length && (breaks[next] ?? 0) <= end) ++next;
      const last = breaks[next - 1] ?? 0;
      if (last > y + high / 4) end = last;
    }
    for (let x = 0; x < width && parts.length < mostPages; x += wide) {
      parts.push({ x: Math.floor(x), y: Math.floor(y), width: Math.ceil(wide), height: Math.ceil(end - y) });
    }
    y = end;
  }
  return { scale, parts };
}

function cell(name: string, value: string): HTMLElement {
  const element = document.createElement("span");
  const label = document.createElement("small");
  label.textContent = name;
  element.append(label, ` ${clipped(value, 120)}`);
  return element;
}

/** Asks for all of it, and opens the browser's print. */
export async function print(pou: string): Promise<void> {
  const [sheet, program, target] = await Promise.all([
    ask(() => plc.diagramsSheet({ pou, breaks: true })),
    ask(() => plc.program()),
    ask(() => plc.target()),
  ]);
  const { scale, parts } = pagesOf(sheet.width, sheet.height, sheet.breaks ?? []);
  const paper = document.createElement("div");
  paper.className = "paper";
  const today = new Date().toISOString().slice(0, 10);
  for (const [i, part] of parts.entries()) {
    const tile = await ask(() => plc.diagramsTile({ pou, ...part }));
    const page = document.createElement("section");
    page.className = "paper-page drawing";
    const picture = newPicture(part, tile.svg);
    picture.style.width = `${part.width * scale}px`;
    picture.style.height = `${part.height * scale}px`;
    const block = document.createElement("footer");
    block.className = "title-block";
    block.append(
      cell(t.plant, target.plant),
      cell(t.project, program.project),
      cell(t.pou, pou),
      cell(t.image, program.image.slice(0, 16)),
      cell(t.date, today),
      cell(t.page, t.pageOf(i + 1, parts.length)),
    );
    page.append(picture, block);
    paper.append(page);
  }
  document.body.append(paper);
  document.body.classList.add("on-paper");
  addEventListener(
    "afterprint",
    () => {
      paper.remove();
      document.body.classList.remove("on-paper");
    },
    { once: true },
  );
  window.print();
}
