// Beside a diagram: what is selected, where else it is used, why it has its value, what a search has found.
import type { JSX } from "preact";
import type { CauseLink, DrawnPlace, DrawnUse } from "../../client/calls";
import { link } from "../route";
import { texts } from "../texts";
import { Badge, Empty, Facts, Section } from "../ui/parts";
import { clipped } from "../values";
import type { Selected } from "./sheet";
import { utcText } from "./past";

const t = texts.diagrams;

export function placeText(place: DrawnPlace): string {
  const where = place.network !== 0 ? t.network(place.network) : place.line !== 0 ? t.line(place.line) : "";
  return `${clipped(place.pou, 80)}${where === "" ? "" : `, ${where}`}`;
}

export function SelectedCard(properties: {
  selected: Selected | undefined;
  path: string | undefined;
  canOpen: boolean;
  canAsk: boolean;
  busy: boolean;
  onOpen: () => void;
  onUses: () => void;
  onWhy: () => void;
}): JSX.Element {
  const { selected, path } = properties;
  if (selected === undefined) {
    return (
      <Section title={t.selected}>
        <Empty>{t.select}</Empty>
      </Section>
    );
  }
  const named = selected.name !== "";
  return (
    <Section title={clipped(named ? selected.name : selected.type || selected.kind, 120)} class="details">
      <Facts
        rows={[
          [t.kind, <span class="path">{clipped(selected.type === "" ? selected.kind : `${selected.kind} ${selected.type}`, 120)}</span>],
          ...(path === undefined ? [] : [[t.path, <span class="path">{clipped(path, 200)}</span>] as const]),
        ]}
      />
      <div class="buttons">
        {selected.type !== "" && properties.canOpen ? (
          <button type="button" class="primary" onClick={properties.onOpen}>
            {t.open}
          </button>
        ) : null}
        {named && properties.canAsk ? (
          <button type="button" disabled={properties.busy} onClick={properties.onWhy}>
            {t.why}
          </button>
        ) : null}
        {named ? (
          <button type="button" onClick={properties.onUses}>
            {t.uses}
          </button>
        ) : null}
        {path === undefined ? null : (
          <>
            <a class="button" href={link("variables", { path })}>
              {t.variable}
            </a>
            <a class="button" href={link("trends", { path })}>
              {texts.variables.trend}
            </a>
          </>
        )}
      </div>
    </Section>
  );
}

export function FoundList(properties: {
  title: string;
  found: readonly DrawnUse[];
  more: boolean;
  onShow: (place: DrawnPlace) => void;
  onClose: () => void;
}): JSX.Element {
  return (
    <Section
      title={clipped(properties.title, 120)}
      actions={
        <button type="button" class="quiet small" aria-label={texts.close} onClick={properties.onClose}>
          ✕
        </button>
      }
    >
      <p role="status" class="quiet-text">
        {properties.found.length === 0 ? t.nothingFound : t.found(properties.found.length, properties.more)}
      </p>
      <ul class="places">
        {properties.found.map((one, i) => (
          <li key={i}>
            <button type="button" class="quiet place" onClick={() => properties.onShow(one.place)}>
              <span class="path">
                {clipped(one.place.kind === "line" ? one.place.text : `${one.place.kind} ${one.place.text}`, 120)}
                {one.writes ? <Badge kind="plain">{t.writes}</Badge> : null}
              </span>
              <small>{placeText(one.place)}</small>
            </button>
          </li>
        ))}
      </ul>
    </Section>
  );
}

export function CauseList(properties: { links: readonly CauseLink[]; onShow: (link: CauseLink) => void; onClose: () => void }): JSX.Element {
  const first = properties.links[0];
  return (
    <Section
      title={first === undefined ? t.why : t.whyTitle(clipped(first.variable, 100), first.value)}
      actions={
        <button type="button" class="quiet small" aria-label={texts.close} onClick={properties.onClose}>
          ✕
        </button>
      }
    >
      <ol class="places causes">
        {properties.links.slice(1).map((one, i) => (
          <li key={i}>
            <p>{t.causes[one.kind](clipped(one.variable, 100), one.value)}</p>
            <small>
              {t.scan(one.scan, one.task)}
              {one.utc_ms === undefined ? "" : `, ${utcText(one.utc_ms)}`}
            </small>
            {one.place === undefined ? null : (
              <button type="button" class="quiet place" onClick={() => properties.onShow(one)}>
                <span class="path">{clipped(one.place.kind === "line" ? one.place.text : `${one.place.kind} ${one.place.text}`, 100)}</span>
                <small>
                  {placeText(one.place)}
                  {one.instance === undefined || one.instance === one.place.pou ? "" : ` (${clipped(one.instance, 80)})`}
                </small>
              </button>
            )}
          </li>
        ))}
      </ol>
    </Section>
  );
}
