// What a panel shows, made from the program without any configuration: variables at addresses, or else globals.
import type { Node } from "../client/calls";
import { ask, plc } from "./plc";

export type WidgetKind = "switch" | "lamp" | "number" | "text";
export interface Widget {
  kind: WidgetKind;
  node: Node;
}
export type GroupName = "inputs" | "outputs" | "memory" | "globals";
export interface Group {
  name: GroupName;
  widgets: Widget[];
}

/** A panel with more is no panel: the page of variables has all of them. */
const mostWidgets = 200;
const mostInstances = 30;

const numbers = /^(U?[SD]?INT|U?LINT|L?REAL|BYTE|D?WORD|LWORD)(\W|$)/;

function widgetOf(node: Node): Widget {
  if (node.type !== "BOOL") return { kind: numbers.test(node.type ?? "") ? "number" : "text", node };
  // Outputs belong to the program: what is written to them is gone with its next scan.
  const isSwitch = node.writable === true && !(node.address ?? "").startsWith("%Q");
  return { kind: isSwitch ? "switch" : "lamp", node };
}

function groupOf(node: Node): GroupName {
  const area = (node.address ?? "").slice(0, 2).toUpperCase();
  return area === "%I" ? "inputs" : area === "%Q" ? "outputs" : area === "%M" ? "memory" : "globals";
}

/** The panel of the program that runs. */
export async function makePanel(): Promise<Group[]> {
  const root = (await ask(() => plc.valuesBrowse({ path: "", most: 1000 }))).nodes;
  const branches = root.filter((node) => node.kind === "structure" || node.kind === "list").slice(0, mostInstances);
  const below = await Promise.all(branches.map((node) => ask(() => plc.valuesBrowse({ path: node.path, most: 500 }))));
  const isShown = (node: Node): boolean => node.kind === "value" && node.readable === true;
  const inLists = below.flatMap((answer, i) => (branches[i]?.kind === "list" ? answer.nodes : []));
  const globals = [...root, ...inLists].filter(isShown);
  const located = new Map<string, Node>();
  for (const node of [...root, ...below.flatMap((answer) => answer.nodes)].filter(isShown)) {
    // WHY the name: a program that uses a global at an address has it among its own.
    const key = `${node.address}\n${node.name}`;
    if (node.address !== undefined && !located.has(key)) located.set(key, node);
  }
  const shown = located.size !== 0 ? [...located.values()] : globals;
  const groups = new Map<GroupName, Widget[]>();
  for (const node of shown.slice(0, mostWidgets)) {
    const name = groupOf(node);
    groups.set(name, [...(groups.get(name) ?? []), widgetOf(node)]);
  }
  // Those of one height beside each other.
  const height = (widget: Widget): number => (widget.kind === "number" ? 1 : 0);
  for (const widgets of groups.values()) widgets.sort((one, other) => height(one) - height(other));
  const order: GroupName[] = ["inputs", "outputs", "memory", "globals"];
  return order.flatMap((name) => (groups.has(name) ? [{ name, widgets: groups.get(name) ?? [] }] : []));
}
