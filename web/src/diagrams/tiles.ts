// The part of a drawing that is in view: pieces of SVG from the server as tiles, and what is known of their points
// written into them.
import type { FlowPoint } from "../../client/calls";
import { ask, plc } from "../plc";
import { texts } from "../texts";
import { clipped } from "../values";
import { state } from "./flow";

/** Pixels of the drawing. */
const tileWidth = 1600;
const tileHeight = 800;
/** Tiles that are kept though they are not in view. */
const mostKept = 40;
/** A pulse is seen for so long. */
const pulseMs = 600;
const space = "http://www.w3.org/2000/svg";

interface Tile {
  key: string;
  x: number;
  y: number;
  svg: SVGSVGElement | undefined;
  used: number;
}

export interface View {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** Pieces as the server gives them, as elements. Nothing in them runs: they are text of a project, escaped. */
export function parsePieces(pieces: string): ChildNode[] {
  const parsed = new DOMParser().parseFromString(`<svg xmlns="${space}">${pieces}</svg>`, "image/svg+xml");
  if (parsed.querySelector("parsererror") !== null) throw new Error("a drawing that is no SVG");
  return [...document.importNode(parsed.documentElement, true).childNodes];
}

export function newPicture(view: View, pieces: string): SVGSVGElement {
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
  svg.setAttribute("role", "none");
  svg.append(...parsePieces(pieces));
  return svg;
}

export class Tiles {
  private tiles = new Map<string, Tile>();
  private shown: Tile[] = [];
  private elements = new Map<number, Element[]>();
  private known = new Map<number, FlowPoint>();
  private pulses = new Map<Element, number>();
  private uses = 0;
  private timer: ReturnType<typeof setInterval> | undefined;
  private zoom = 1;
  private ended = false;

  constructor(
    private readonly frame: HTMLElement,
    private readonly pou: string,
    private readonly width: number,
    private readonly height: number,
    private readonly onPoints: (points: number[]) => void,
    private readonly onProblem: (error: unknown) => void,
  ) {
    this.timer = setInterval(() => this.endPulses(), 200);
  }

  close(): void {
    this.ended = true;
    clearInterval(this.timer);
    this.frame.replaceChildren();
  }

  /** What is in view, in pixels of the drawing. */
  show(view: View, zoom: number): void {
    if (this.ended) return;
    const resized = zoom !== this.zoom;
    this.zoom = zoom;
    const wanted: Tile[] = [];
    const lastRow = Math.min(Math.ceil(this.height / tileHeight), Math.floor((view.y + view.height) / tileHeight) + 1);
    const lastColumn = Math.min(Math.ceil(this.width / tileWidth), Math.floor((view.x + view.width) / tileWidth) + 1);
    for (let row = Math.max(0, Math.floor(view.y / tileHeight)); row < lastRow; ++row) {
      for (let column = Math.max(0, Math.floor(view.x / tileWidth)); column < lastColumn; ++column) {
        wanted.push(this.tile(column * tileWidth, row * tileHeight));
      }
    }
    const same = wanted.length === this.shown.length && wanted.every((tile, i) => tile === this.shown[i]);
    if (same && !resized) return;
    this.shown = wanted;
    this.place();
    this.forget();
  }

  /** What the server says of points, in this scan. */
  apply(points: readonly FlowPoint[]): void {
    for (const point of points) {
      this.known.set(point.point, point);
      for (const element of this.elements.get(point.point) ?? []) this.draw(element, point);
    }
  }

  /** Values of before are those of another scan or instance. */
  clear(): void {
    this.known.clear();
    for (const elements of this.elements.values()) elements.forEach((element) => this.draw(element, undefined));
  }

  points(): number[] {
    return [...this.elements.keys()];
  }

  private tile(x: number, y: number): Tile {
    const key = `${x},${y}`;
    let tile = this.tiles.get(key);
    if (tile === undefined) {
      tile = { key, x, y, svg: undefined, used: 0 };
      this.tiles.set(key, tile);
      void this.load(tile);
    }
    tile.used = ++this.uses;
    return tile;
  }

  private async load(tile: Tile): Promise<void> {
    const view = { x: tile.x, y: tile.y, width: tileWidth, height: tileHeight };
    try {
      const answer = await ask(() => plc.diagramsTile({ pou: this.pou, ...view }));
      if (this.ended) return;
      const svg = newPicture(view, answer.svg);
      svg.classList.add("tile");
      tile.svg = svg;
      if (this.shown.includes(tile)) this.place();
    } catch (error) {
      this.tiles.delete(tile.key);
      if (!this.ended) this.onProblem(error);
    }
  }

  private place(): void {
    const pictures: SVGSVGElement[] = [];
    for (const tile of this.shown) {
      if (tile.svg === undefined) continue;
      tile.svg.style.left = `${tile.x * this.zoom}px`;
      tile.svg.style.top = `${tile.y * this.zoom}px`;
      tile.svg.style.width = `${tileWidth * this.zoom}px`;
      tile.svg.style.height = `${tileHeight * this.zoom}px`;
      pictures.push(tile.svg);
    }
    const present = new Set<Element>(this.frame.children);
    const wanted = new Set<Element>(pictures);
    present.forEach((one) => wanted.has(one) || one.remove());
    pictures.forEach((one) => present.has(one) || this.frame.append(one));
    this.elements.clear();
    for (const picture of pictures) {
      for (const element of picture.querySelectorAll("[data-k]")) {
        const point = Number(element.getAttribute("data-k"));
        const known = this.elements.get(point);
        if (known === undefined) this.elements.set(point, [element]);
        else known.push(element);
      }
    }
    for (const [point, elements] of this.elements) elements.forEach((element) => this.draw(element, this.known.get(point)));
    this.onPoints(this.points());
  }

  /** What is not in view any more: the tiles unused for longest, and all values that nobody asks for now. */
  private forget(): void {
    const unused = [...this.tiles.values()].filter((tile) => !this.shown.includes(tile) && tile.svg !== undefined);
    unused.sort((a, b) => a.used - b.used);
    unused.slice(0, Math.max(0, unused.length - mostKept)).forEach((tile) => this.tiles.delete(tile.key));
  }

  private draw(element: Element, point: FlowPoint | undefined): void {
    const is = point?.state ?? 0;
    const has = (bit: number): boolean => (is & bit) !== 0;
    const isBool = has(state.bool);
    const list = element.classList;
    const power = isBool && has(state.known);
    // A place without a value: what was executed.
    const reached = point !== undefined && !isBool && !has(state.known);
    list.toggle("on", has(state.ran) && (power ? has(state.on) : reached));
    list.toggle("off", has(state.ran) && power && !has(state.on));
    list.toggle("notrun", point !== undefined && !has(state.ran));
    list.toggle("forced", has(state.forced));
    if (has(state.both)) {
      list.add("pulse");
      this.pulses.set(element, performance.now() + pulseMs);
    }
    const words = element.getAttribute("data-words") !== null;
    if (!words && !list.contains("value")) return;
    let text = isBool ? (words && power ? (has(state.on) ? "TRUE" : "FALSE") : "") : clipped(point?.text ?? "", 60);
    if (words && text === "" && point !== undefined && !has(state.ran)) text = texts.diagrams.notRun;
    if (has(state.forced)) text = text === "" ? `⚑ ${texts.variables.forced}` : `${text} ⚑`;
    if (element.textContent !== text) element.textContent = text;
  }

  private endPulses(): void {
    const now = performance.now();
    for (const [element, until] of this.pulses) {
      if (until > now) continue;
      element.classList.remove("pulse");
      this.pulses.delete(element);
    }
  }
}
