import { render } from "preact";
import "uplot/dist/uPlot.min.css";
import "./style.css";
import "./style_parts.css";
import "./style_pages.css";
import "./style_hmi.css";
import "./style_diagrams.css";
import { App } from "./app";
import { findSession } from "./plc";

const root = document.getElementById("app");
if (root !== null) render(<App />, root);
void findSession();
