// The variable that is selected: all that is known of it, its latest course, what may be done.
import type { JSX } from "preact";
import type { Node } from "../../client/calls";
import { LiveValues, useLive } from "../live";
import { may } from "../plc";
import { link } from "../route";
import { texts } from "../texts";
import { Empty, Facts, Section } from "../ui/parts";
import { Sparkline } from "../ui/sparkline";
import { clipped, isDrawable, isInteger, valueText } from "../values";
import type { Forces } from "../forces";
import type { Watched } from "./watch_list";

const t = texts.variables;
export function Details(properties: {
  values: LiveValues;
  node: Node | undefined;
  base: number;
  watched: Watched;
  forces: Forces;
  onWrite: (path: string) => void;
  onForce: (path: string) => void;
}): JSX.Element {
  const { node, watched, forces } = properties;
  const shown = node?.kind === "value" && node.readable === true;
  const live = useLive(properties.values, shown ? node.path : undefined);
  if (node === undefined) {
    return (
      <Section title={t.value}>
        <Empty>{t.select}</Empty>
      </Section>
    );
  }
  const { raw, shape } = live;
  const forced = forces.of(node.path);
  const otherBases = shape !== undefined && isInteger(shape) ? [10, 16, 2].filter((base) => base !== properties.base) : [];
  return (
    <Section title={clipped(node.path, 120)} class="details">
      {shown ? <p class="big number">{clipped(valueText(raw, shape, properties.base), 2000)}</p> : null}
      {forced === undefined ? null : (
        <p class="strip warning">
          {t.forcedBy(clipped(forced.owner, 64), clipped(forced.reason, 500))} {forced.yields ? texts.forces.yields : ""}
        </p>
      )}
      <Facts
        rows={[
          [t.type, <span class="path">{clipped(node.type ?? node.kind, 200)}</span>],
          ...(node.address === undefined ? [] : [[t.address, <span class="number">{node.address}</span>] as const]),
          ...otherBases.map((base) => [t.bases[base] ?? "", <span class="number">{valueText(raw, shape, base)}</span>] as const),
        ]}
      />
      {shown && shape !== undefined && isDrawable(shape) ? <Sparkline key={node.path} live={live} /> : null}
      {node.kind === "value" && node.readable !== true ? <p class="quiet-text">{t.localHelp}.</p> : null}
      {node.kind !== "value" ? null : (
        <div class="buttons">
          {may("values.write") && node.writable === true ? (
            <button type="button" class="primary" onClick={() => properties.onWrite(node.path)}>
              {t.write}
            </button>
          ) : null}
          {may("forces.set") && shown && forced === undefined ? (
            <button type="button" onClick={() => properties.onForce(node.path)}>
              {t.force}
            </button>
          ) : null}
          {may("forces.release") && forced !== undefined ? (
            <button type="button" class="danger" onClick={() => forces.release(forced.path)}>
              {t.release}
            </button>
          ) : null}
          {shown ? (
            <button type="button" aria-pressed={watched.has(node.path)} onClick={() => watched.toggle(node.path)}>
              {watched.has(node.path) ? t.unwatch : t.watch}
            </button>
          ) : null}
          {shown && shape !== undefined && isDrawable(shape) ? (
            <a class="button" href={link("trends", { path: node.path })}>
              {t.trend}
            </a>
          ) : null}
        </div>
      )}
      {node.kind === "value" && may("values.write") && node.writable !== true ? <p class="quiet-text">{t.readOnly}</p> : null}
    </Section>
  );
}
