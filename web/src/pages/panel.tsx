// Lamps, switches and numbers of the program that runs.
import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";
import { LiveValues, useLive, useLiveValues } from "../live";
import { notify } from "../notice";
import { makePanel, type Group, type Widget } from "../panel";
import { ask, may, plc, problemOf, type Problem } from "../plc";
import { texts } from "../texts";
import { Empty, ProblemBox, Section } from "../ui/parts";
import { Sparkline } from "../ui/sparkline";
import { clipped, valueText } from "../values";

const t = texts.panel;

function Instrument(properties: { widget: Widget; values: LiveValues }): JSX.Element {
  const { kind, node } = properties.widget;
  const live = useLive(properties.values, node.path);
  const name = clipped(node.name, 80);
  const on = live.raw === true;
  const head = (
    <span class="instrument-head">
      <span class="path">{name}</span>
      <small class="number">{node.address ?? ""}</small>
    </span>
  );
  if (kind === "switch" && may("values.write")) {
    const write = (): void => {
      ask(() => plc.valuesWrite({ values: [{ path: node.path, value: !on }] })).catch((error: unknown) => notify(problemOf(error).text));
    };
    return (
      <li class="instrument" data-path={node.path}>
        {head}
        <button type="button" role="switch" aria-checked={on} aria-label={name} class="switch" disabled={live.raw === undefined} onClick={write}>
          <span class="switch-knob" aria-hidden="true" />
          {on ? t.on : t.off}
        </button>
      </li>
    );
  }
  if (kind === "switch" || kind === "lamp") {
    return (
      <li class="instrument" data-path={node.path}>
        {head}
        <span class="lamp-line">
          <svg class={on ? "lamp on" : "lamp"} viewBox="0 0 24 24" role="img" aria-label={t.lamp(name, on)}>
            <circle cx="12" cy="12" r="9" />
          </svg>
          <span aria-hidden="true">{live.raw === undefined ? "…" : on ? t.on : t.off}</span>
        </span>
      </li>
    );
  }
  return (
    <li class="instrument" data-path={node.path}>
      {head}
      <span class="big number">{clipped(valueText(live.raw, live.shape), 200)}</span>
      {kind === "number" ? <Sparkline live={live} /> : null}
    </li>
  );
}

export function PanelPage(): JSX.Element {
  const values = useLiveValues(100);
  const [groups, setGroups] = useState<Group[]>();
  const [problem, setProblem] = useState<Problem>();
  useEffect(() => {
    makePanel().then(setGroups, (error: unknown) => setProblem(problemOf(error)));
  }, []);
  return (
    <>
      <ProblemBox problem={problem} />
      {groups === undefined ? (
        <p>{texts.loading}</p>
      ) : groups.length === 0 ? (
        <Empty>{t.empty}</Empty>
      ) : (
        groups.map((group) => (
          <Section key={group.name} title={t.groups[group.name] ?? group.name}>
            <ul class="instruments">
              {group.widgets.map((widget) => (
                <Instrument key={widget.node.path} widget={widget} values={values} />
              ))}
            </ul>
          </Section>
        ))
      )}
      <p class="quiet-text">{t.help}</p>
    </>
  );
}
