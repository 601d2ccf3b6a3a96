// One element of a page, whatever its kind.
import type { JSX } from "preact";
import { type LiveValues, useLive } from "../live";
import { may } from "../plc";
import { link } from "../route";
import { texts } from "../texts";
import { clipped } from "../values";
import { AlarmList } from "./alarm_list";
import { Button, NumberEntry, Slider, Switch } from "./controls";
import type { HmiElement } from "./document";
import { Plot } from "./plot";
import { Bar, Gauge, Lamp, Motor, NumberShown, Picture, Pipe, Tank, Text, Valve } from "./shapes";

export function Widget(properties: { element: HmiElement; values: LiveValues }): JSX.Element {
  const { element, values } = properties;
  const path = element.variable === "" ? undefined : element.variable;
  const live = useLive(values, path);
  const both = { element, live };
  const writes = may("values.write");
  switch (element.kind) {
    case "lamp":
      return <Lamp {...both} />;
    case "switch":
      return writes ? <Switch {...both} /> : <Lamp {...both} />;
    case "button":
      return writes ? <Button {...both} /> : <Lamp {...both} />;
    case "slider":
      return writes ? <Slider {...both} /> : <NumberShown {...both} />;
    case "number":
      return writes && element.entered === true ? <NumberEntry {...both} /> : <NumberShown {...both} />;
    case "gauge":
      return <Gauge {...both} />;
    case "bar":
      return <Bar {...both} />;
    case "tank":
      return <Tank {...both} />;
    case "valve":
      return <Valve {...both} />;
    case "motor":
      return <Motor {...both} />;
    case "pipe":
      return <Pipe {...both} />;
    case "plot":
      return <Plot element={element} values={values} />;
    case "alarms":
      return <AlarmList element={element} />;
    case "text":
      return <Text {...both} />;
    case "picture":
      return <Picture element={element} />;
    case "link":
      return (
        <a class="button hmi-button" href={link("panel", { page: element.page ?? "" })}>
          {clipped(element.label ?? element.page ?? "", 80)}
        </a>
      );
    default:
      return <span>{texts.hmi.unknownKind(clipped(element.kind, 40))}</span>;
  }
}
