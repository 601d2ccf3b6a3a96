// HMI pages: those of the project, or one that is made from the program.
import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { PagesGetAnswer } from "../../client/calls";
import { Canvas } from "../hmi/canvas";
import { titleOf } from "../hmi/document";
import { draft, Editor } from "../hmi/editor";
import { useLiveValues } from "../live";
import { ask, may, plc, problemOf, usePolled, type Problem } from "../plc";
import { link, route } from "../route";
import { useSignal } from "../signals";
import { texts } from "../texts";
import { Empty, ProblemBox, Section } from "../ui/parts";
import { clipped } from "../values";

const t = texts.hmi;
/** How soon pages that somebody else has saved are shown. */
const lookMs = 5000;

function Problems(properties: { problems: readonly string[] }): JSX.Element | null {
  if (properties.problems.length === 0) return null;
  return (
    <div class="problem hmi-problems">
      <p>{t.problems}</p>
      <ul>
        {properties.problems.slice(0, 20).map((one) => (
          <li key={one}>
            <code>{clipped(one)}</code>
          </li>
        ))}
      </ul>
    </div>
  );
}

export function PanelPage(): JSX.Element {
  const values = useLiveValues(100);
  const { parameters } = useSignal(route);
  const [pages, setPages] = useState<PagesGetAnswer>();
  const [problem, setProblem] = useState<Problem>();
  const [editing, setEditing] = useState(() => draft() !== undefined && may("pages.save"));
  const load = (): void => {
    ask(() => plc.pagesGet()).then(setPages, (error: unknown) => setProblem(problemOf(error)));
  };
  const { answer: newest } = usePolled(() => plc.pagesReload(), lookMs);
  const known = `${pages?.version ?? ""} ${pages?.usable ?? true}`;
  const found = newest === undefined ? undefined : `${newest.version} ${newest.usable}`;
  useEffect(() => {
    if (found !== undefined && (pages === undefined || (found !== known && !editing))) load();
  }, [found, editing]);
  if (pages === undefined) {
    return problem === undefined ? <p>{texts.loading}</p> : <ProblemBox problem={problem} />;
  }
  const at = Math.max(0, pages.pages.findIndex((one) => one.name === parameters.get("page")));
  if (editing) {
    return (
      <Editor
        pages={pages}
        at={at}
        values={values}
        onSaved={(saved) => setPages(saved)}
        onClose={(name) => {
          if (name !== undefined) location.hash = link("panel", { page: name });
          setEditing(false);
          load();
        }}
      />
    );
  }
  const page = pages.pages[at];
  const edit = may("pages.save") ? (
    <span class="hmi-edit">
      {pages.usable ? null : <small id="why-no-edit">{t.cannotEdit}</small>}
      <button type="button" onClick={() => setEditing(true)} disabled={!pages.usable} aria-describedby={pages.usable ? undefined : "why-no-edit"}>
        {t.edit}
      </button>
    </span>
  ) : null;
  return (
    <>
      <Problems problems={pages.problems} />
      {pages.pages.length < 2 ? null : (
        <nav class="tabs" aria-label={t.pages}>
          {pages.pages.map((one, i) => (
            <a key={one.name} class="button" href={link("panel", { page: one.name })} aria-current={i === at ? "page" : undefined}>
              {clipped(titleOf(one), 60)}
            </a>
          ))}
        </nav>
      )}
      {page === undefined ? (
        <Section title={t.pages} actions={edit}>
          <Empty>{t.none}</Empty>
        </Section>
      ) : (
        <Section title={clipped(titleOf(page), 120)} actions={edit} class="hmi-page">
          {page.elements.length === 0 ? <Empty>{t.empty}</Empty> : <Canvas key={page.name} page={page} values={values} />}
          {pages.made ? <p class="quiet-text">{t.made}</p> : null}
        </Section>
      )}
    </>
  );
}
