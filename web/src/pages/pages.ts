// The pages, in the order of the navigation. A page is a row here, its name in texts.ts, and a component.
import type { JSX } from "preact";
import type { texts } from "../texts";
import { DiagramsPage } from "./diagrams";
import { AlarmsPage } from "./alarms";
import { LogPage } from "./log";
import { OverviewPage } from "./overview";
import { PanelPage } from "./panel";
import { TrendsPage } from "./trends";
import { UsersPage } from "./users";
import { VariablesPage } from "./variables";

export interface Page {
  name: keyof (typeof texts)["pages"];
  /** The least role that sees it. */
  right: "viewer" | "operator" | "engineer" | "admin";
  contents: () => JSX.Element;
}

export const pages: readonly Page[] = [
  { name: "overview", right: "viewer", contents: OverviewPage },
  { name: "panel", right: "viewer", contents: PanelPage },
  { name: "diagrams", right: "viewer", contents: DiagramsPage },
  { name: "variables", right: "viewer", contents: VariablesPage },
  { name: "trends", right: "viewer", contents: TrendsPage },
  { name: "alarms", right: "viewer", contents: AlarmsPage },
  { name: "log", right: "viewer", contents: LogPage },
  { name: "users", right: "admin", contents: UsersPage },
];
