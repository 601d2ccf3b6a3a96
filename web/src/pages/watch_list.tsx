// Variables that somebody watches. The browser keeps which.
import type { JSX } from "preact";
import { useState } from "preact/hooks";
import { keep, kept, isTexts } from "../kept";
import { LiveValues, useLive } from "../live";
import { may } from "../plc";
import { link } from "../route";
import { texts } from "../texts";
import { Empty, Section } from "../ui/parts";
import { clipped, valueText } from "../values";

const t = texts.variables;

export interface Watched {
  paths: readonly string[];
  has: (path: string) => boolean;
  toggle: (path: string) => void;
}

export function useWatched(): Watched {
  const [paths, setPaths] = useState<string[]>(() => kept("watch", [], isTexts));
  return {
    paths,
    has: (path) => paths.includes(path),
    toggle: (path) => {
      const next = paths.includes(path) ? paths.filter((one) => one !== path) : [...paths, path];
      setPaths(next);
      keep("watch", next);
    },
  };
}

function WatchedRow(properties: { path: string; values: LiveValues; base: number; watched: Watched; onWrite: (path: string) => void }): JSX.Element {
  const { path } = properties;
  const live = useLive(properties.values, path);
  return (
    <li class="watched">
      <span class="path name">{clipped(path, 120)}</span>
      <span class={`number value ${live.raw === true ? "on" : ""}`} title={live.problem}>
        {live.problem === "" ? clipped(valueText(live.raw, live.shape, properties.base), 100) : texts.nothing}
      </span>
      <span class="buttons">
        {may("values.write") ? (
          <button type="button" class="quiet small" aria-label={t.writeTitle(path)} onClick={() => properties.onWrite(path)}>
            {t.write}
          </button>
        ) : null}
        <a class="button quiet small" aria-label={`${t.trend}: ${path}`} href={link("trends", { path })}>
          ∿
        </a>
        <button type="button" class="quiet small" aria-label={`${t.unwatch}: ${path}`} onClick={() => properties.watched.toggle(path)}>
          ✕
        </button>
      </span>
    </li>
  );
}

export function WatchList(properties: { values: LiveValues; base: number; watched: Watched; onWrite: (path: string) => void }): JSX.Element {
  const { paths } = properties.watched;
  return (
    <Section title={t.watches}>
      {paths.length === 0 ? (
        <Empty>{t.noWatches}</Empty>
      ) : (
        <ul class="watches">
          {paths.map((path) => (
            <WatchedRow key={path} path={path} values={properties.values} base={properties.base} watched={properties.watched} onWrite={properties.onWrite} />
          ))}
        </ul>
      )}
    </Section>
  );
}
