// The tree of variables as rows: parts are asked for when they come into view, so that arrays of any size can be shown.
import type { Node } from "../client/calls";
import { ask, plc } from "./plc";

/** Parts that are asked for at once. */
const chunk = 250;

export interface Branch {
  path: string;
  level: number;
  /** How many parts it has; unknown until the first answer. */
  total: number | undefined;
  parts: Map<number, Node>;
  /** Unfolded parts, by place, in order. */
  open: Map<number, Branch>;
  asked: Set<number>;
}

export interface Row {
  branch: Branch;
  /** Of the node in its branch. */
  place: number;
  node: Node | undefined;
  /** Set when it is unfolded. */
  below: Branch | undefined;
}

export function newBranch(path: string, level: number): Branch {
  return { path, level, total: undefined, parts: new Map(), open: new Map(), asked: new Set() };
}

export function rowCount(branch: Branch): number {
  // A branch whose size is not known yet shows one row that says so.
  let count = branch.total ?? 1;
  for (const below of branch.open.values()) count += rowCount(below);
  return count;
}

/** The row of this number, counted from 0 through all that is unfolded. */
export function rowAt(branch: Branch, number: number): Row {
  let place = 0;
  for (const [openPlace, below] of branch.open) {
    const before = openPlace - place;
    if (number < before) break;
    number -= before;
    place = openPlace;
    if (number === 0) return { branch, place, node: branch.parts.get(place), below };
    --number;
    const inside = rowCount(below);
    if (number < inside) return rowAt(below, number);
    number -= inside;
    ++place;
  }
  place += number;
  return { branch, place, node: branch.parts.get(place), below: undefined };
}

/** The row of a part of a branch; `from`: where the rows of `root` begin. Undefined when the branch is not unfolded. */
export function rowOf(root: Branch, branch: Branch, place: number): number | undefined {
  let number = 0;
  let at = 0;
  if (root === branch) {
    for (const [openPlace, below] of root.open) {
      if (openPlace >= place) break;
      number += rowCount(below);
    }
    return number + place;
  }
  for (const [openPlace, below] of root.open) {
    number += openPlace - at + 1;
    at = openPlace + 1;
    const inside = rowOf(below, branch, place);
    if (inside !== undefined) return number + inside;
    number += rowCount(below);
  }
  return undefined;
}

export function isFoldable(node: Node): boolean {
  return node.kind === "structure" || node.kind === "array" || node.kind === "list";
}

export function unfold(row: Row): void {
  if (row.node === undefined || row.below !== undefined || !isFoldable(row.node)) return;
  row.branch.open.set(row.place, newBranch(row.node.path, row.branch.level + 1));
  row.branch.open = new Map([...row.branch.open].sort((a, b) => a[0] - b[0]));
}

export function fold(row: Row): void {
  row.branch.open.delete(row.place);
}

/** Asks for the parts around a place, once; `done` when they are there. */
export function fetchParts(branch: Branch, place: number, done: () => void, failed: (error: unknown) => void): void {
  const from = Math.floor(place / chunk) * chunk;
  if (branch.asked.has(from)) return;
  branch.asked.add(from);
  ask(() => plc.valuesBrowse({ path: branch.path, from, most: chunk })).then(
    (answer) => {
      branch.total = answer.total;
      answer.nodes.forEach((node, i) => branch.parts.set(from + i, node));
      done();
    },
    (error: unknown) => {
      // The next look asks again.
      branch.asked.delete(from);
      failed(error);
    },
  );
}
