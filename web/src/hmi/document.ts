// HMI pages as data: what the editor does to them, without a screen.
import type { HmiElement, HmiKind, HmiPage } from "../../client/calls";

export type { HmiElement, HmiKey, HmiKind, HmiPage } from "../../client/calls";

export interface HmiDocument {
  pages: readonly HmiPage[];
  comment: readonly string[];
}

/** "Level" of "Main.tank.Level". */
export function lastPart(path: string): string {
  return path.slice(path.lastIndexOf(".") + 1);
}

/** What people call it. */
export function nameOf(element: HmiElement): string {
  return element.label ?? (element.variable !== undefined ? lastPart(element.variable) : (element.text ?? element.variables?.map(lastPart).join(", ") ?? ""));
}

/** What people call a page. */
export function titleOf(page: HmiPage): string {
  return page.title === undefined || page.title === "" ? page.name : page.title;
}

/** The same element, as near as it can be on the page. */
export function placed(page: HmiPage, element: HmiElement): HmiElement {
  const width = Math.max(1, Math.min(element.width, page.columns));
  const height = Math.max(1, Math.min(element.height, page.rows));
  const x = Math.max(0, Math.min(element.x, page.columns - width));
  const y = Math.max(0, Math.min(element.y, page.rows - height));
  return { ...element, x, y, width, height };
}

/** The first place where nothing is; the upper left corner when there is none. */
export function freePlace(page: HmiPage, width: number, height: number): { x: number; y: number } {
  const taken = (x: number, y: number): boolean =>
    page.elements.some((one) => x < one.x + one.width && one.x < x + width && y < one.y + one.height && one.y < y + height);
  for (let y = 0; y + height <= page.rows; ++y) {
    for (let x = 0; x + width <= page.columns; ++x) if (!taken(x, y)) return { x, y };
  }
  return { x: 0, y: 0 };
}

/** A new element, with something in each key that it needs. */
export function madeElement(kind: HmiKind, page: HmiPage, at?: { x: number; y: number }): HmiElement {
  const place = at ?? freePlace(page, kind.width, kind.height);
  const element: HmiElement = { kind: kind.name, x: place.x, y: place.y, width: kind.width, height: kind.height };
  const values = element as unknown as Record<string, unknown>;
  for (const key of kind.keys) if (key.required) values[key.name] = key.type === "texts" ? [] : "";
  return placed(page, element);
}

export function withPage(document: HmiDocument, at: number, page: HmiPage): HmiDocument {
  return { ...document, pages: document.pages.map((one, i) => (i === at ? page : one)) };
}

export function withElement(page: HmiPage, at: number, element: HmiElement): HmiPage {
  return { ...page, elements: page.elements.map((one, i) => (i === at ? placed(page, element) : one)) };
}

/** What a refusal of pages.save is about: "pages[0].elements[2].low". */
export function placeOfField(field: string | undefined): { page: number; element: number | undefined; key: string | undefined } | undefined {
  const found = /^pages\[(\d+)\](?:\.elements\[(\d+)\])?(?:\.(\w+))?/.exec(field ?? "");
  if (found === null) return undefined;
  return { page: Number(found[1]), element: found[2] === undefined ? undefined : Number(found[2]), key: found[3] };
}

/** A page name that is not taken: "page", "page-2", .. */
export function freeName(document: HmiDocument, wanted: string): string {
  for (let n = 1; ; ++n) {
    const name = n === 1 ? wanted : `${wanted}-${n}`;
    if (!document.pages.some((page) => page.name === name)) return name;
  }
}

/** The page with other measures: what was outside comes in. */
export function fitted(page: HmiPage): HmiPage {
  return { ...page, elements: page.elements.map((one) => placed(page, one)) };
}

/** Keys of a kind that have nothing in them are left out; those of another kind, too. */
export function cleaned(element: HmiElement, kind: HmiKind | undefined): HmiElement {
  const { kind: name, x, y, width, height, comment } = element;
  const clean: Record<string, unknown> = { kind: name, x, y, width, height };
  const values = element as unknown as Record<string, unknown>;
  for (const key of kind?.keys ?? []) {
    const value = values[key.name];
    if (value === undefined || value === null) continue;
    if (value === "" && !key.required) continue;
    clean[key.name] = value;
  }
  if (comment !== undefined) clean["comment"] = comment;
  return clean as unknown as HmiElement;
}
