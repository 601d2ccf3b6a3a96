// The editor of HMI pages: palette, page, properties; every change is a step that can be undone.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { PagesGetAnswer } from "../../client/calls";
import type { LiveValues } from "../live";
import { notify, warn } from "../notice";
import { ask, plc, problemOf, session, type Problem } from "../plc";
import { texts } from "../texts";
import { download } from "../ui/download";
import { Dialog, ProblemBox, Section } from "../ui/parts";
import { clipped } from "../values";
import { cleaned, freeName, madeElement, nameOf, titleOf, withElement, withPage, placeOfField, type HmiDocument, type HmiElement, type HmiKind, type HmiPage } from "./document";
import { EditCanvas } from "./edit_canvas";
import { useHistory } from "./history";
import { Palette } from "./palette";
import { ElementForm, PageForm } from "./properties";

const t = texts.hmi.editor;
const newPage = { columns: 24, rows: 14 };

/** What is edited and not saved: other pages and the end of a session do not lose it. `version`: of the file that it began with. */
let unsaved: { user: string; version: string; kept: HmiDocument; document: HmiDocument } | undefined;

/** That of who is logged in now. */
export function draft(): { version: string; kept: HmiDocument; document: HmiDocument } | undefined {
  return unsaved?.user === session.peek()?.user ? unsaved : undefined;
}

function LeaveDialog(properties: { onLeave: () => void; onStay: () => void }): JSX.Element {
  return (
    <Dialog title={t.leaveTitle} onClose={properties.onStay}>
      <p>{t.leave}</p>
      <div class="buttons">
        <button type="button" class="danger" onClick={properties.onLeave}>
          {t.discard}
        </button>
        <button type="button" onClick={properties.onStay}>
          {t.stay}
        </button>
      </div>
    </Dialog>
  );
}

export function Editor(properties: { pages: PagesGetAnswer; at: number; values: LiveValues; onSaved: (pages: PagesGetAnswer) => void; onClose: (shown: string | undefined) => void }): JSX.Element {
  const { pages, values } = properties;
  const kinds = new Map<string, HmiKind>(pages.kinds.map((kind) => [kind.name, kind]));
  const [begun] = useState(draft);
  const history = useHistory<HmiDocument>(begun?.kept ?? { pages: pages.pages, comment: pages.comment }, begun?.document);
  const document_ = history.value;
  const [wanted, setAt] = useState(properties.at);
  const at = Math.max(0, Math.min(wanted, document_.pages.length - 1));
  const page = document_.pages[at];
  const [chosen, setSelected] = useState<number>();
  const selected = chosen !== undefined && page !== undefined && chosen < page.elements.length ? chosen : undefined;
  const [version, setVersion] = useState(begun?.version ?? pages.version);
  const [busy, setBusy] = useState(false);
  const saving = useRef(false);
  const [problem, setProblem] = useState<Problem>();
  const [leaving, setLeaving] = useState(false);
  const [said, say] = useState("");
  // So that keys go on with what was just made, or is wrong.
  const [made, setMade] = useState(0);

  const kept = useRef<HmiDocument>(begun?.kept ?? history.value);
  useEffect(() => {
    unsaved = history.changed ? { user: session.peek()?.user ?? "", version, kept: kept.current, document: document_ } : undefined;
  }, [document_, history.changed, version]);
  useEffect(() => {
    if (!history.changed) return undefined;
    const ask_ = (event: BeforeUnloadEvent): void => event.preventDefault();
    addEventListener("beforeunload", ask_);
    return () => removeEventListener("beforeunload", ask_);
  }, [history.changed]);

  const tell = (element: HmiElement): void =>
    say(t.element(texts.hmi.kinds[element.kind] ?? element.kind, clipped(nameOf(element), 60), element.x, element.y, element.width, element.height));
  const setPage = (next: HmiPage, step?: string): void => history.set(withPage(document_, at, next), step);
  const change = (index: number, element: HmiElement, step?: string): void => {
    if (page === undefined) return;
    const next = withElement(page, index, element);
    setPage(next, step);
    const now = next.elements[index];
    if (now !== undefined) tell(now);
  };
  const add = (element: HmiElement): void => {
    if (page === undefined) return;
    setPage({ ...page, elements: [...page.elements, element] });
    setSelected(page.elements.length);
    setMade((before) => before + 1);
    tell(element);
  };
  const make = (kind: HmiKind, place?: { x: number; y: number }): void => {
    if (page !== undefined) add(madeElement(kind, page, place));
  };
  const copy = (index: number): void => {
    const element = page?.elements[index];
    if (page === undefined || element === undefined) return;
    add({ ...element, x: Math.min(element.x + 1, page.columns - element.width), y: Math.min(element.y + 1, page.rows - element.height) });
  };
  const remove = (index: number): void => {
    const element = page?.elements[index];
    if (page === undefined || element === undefined) return;
    setPage({ ...page, elements: page.elements.filter((_, i) => i !== index) });
    setSelected(undefined);
    say(t.removed(texts.hmi.kinds[element.kind] ?? element.kind));
  };
  const front = (index: number): void => {
    const element = page?.elements[index];
    if (page === undefined || element === undefined) return;
    setPage({ ...page, elements: [...page.elements.filter((_, i) => i !== index), element] });
    setSelected(page.elements.length - 1);
  };
  const addPage = (): void => {
    history.set({ ...document_, pages: [...document_.pages, { name: freeName(document_, "page"), ...newPage, elements: [] }] });
    setAt(document_.pages.length);
    setSelected(undefined);
  };
  const removePage = (): void => {
    history.set({ ...document_, pages: document_.pages.filter((_, i) => i !== at) });
    setSelected(undefined);
  };
  /** Says which element of what was sent is wrong, and goes there. */
  const showRefusal = (refused: Problem, sent: HmiDocument): void => {
    const place = placeOfField(refused.field);
    const wrongPage = place === undefined ? undefined : sent.pages[place.page];
    if (place === undefined || wrongPage === undefined) return setProblem(refused);
    const wrong = place.element === undefined ? undefined : wrongPage.elements[place.element];
    const key = wrong === undefined ? undefined : texts.hmi.keys[place.key ?? ""];
    const where = wrong === undefined ? t.onPage(clipped(titleOf(wrongPage), 60)) : t.wrongElement(texts.hmi.kinds[wrong.kind] ?? wrong.kind, clipped(nameOf(wrong), 60), wrong.x, wrong.y, key);
    const text = `${where}: ${refused.text}`;
    setProblem({ ...refused, text });
    setAt(place.page);
    setSelected(place.element);
    if (wrong === undefined) return;
    setMade((before) => before + 1);
    // WHY twice: on a narrow screen the one above is out of sight when the element is in it.
    warn(text);
  };
  /** `over`: the version that is written over, where somebody else has saved meanwhile. */
  const save = async (over = version): Promise<void> => {
    // WHY: a second one would find what the first one has written, and call it somebody else's.
    if (saving.current) return;
    saving.current = true;
    setBusy(true);
    setProblem(undefined);
    const sent = document_;
    try {
      const clean = document_.pages.map((one) => ({ ...one, title: one.title === "" ? undefined : one.title, elements: one.elements.map((element) => cleaned(element, kinds.get(element.kind))) }));
      const answer = await ask(() => plc.pagesSave({ version: over, pages: clean, comment: [...document_.comment] }));
      setVersion(answer.version);
      kept.current = sent;
      history.saved(sent);
      properties.onSaved({ ...pages, version: answer.version, made: false, pages: clean, problems: answer.problems });
      notify(t.saved);
    } catch (error) {
      showRefusal(problemOf(error), sent);
    }
    saving.current = false;
    setBusy(false);
  };
  const saveOver = (): void => {
    ask(() => plc.pagesReload()).then(
      (now) => save(now.version),
      (error: unknown) => setProblem(problemOf(error)),
    );
  };
  const leave = (): void => {
    unsaved = undefined;
    properties.onClose(page?.name);
  };
  const onKey = (event: KeyboardEvent): void => {
    if (!event.ctrlKey && !event.metaKey) return;
    if (event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement) return;
    const key = event.key.toLowerCase();
    if (key === "z" || key === "y") {
      event.preventDefault();
      if (key === "y" || event.shiftKey) history.redo();
      else history.undo();
    } else if (key === "s") {
      event.preventDefault();
      void save();
    }
  };

  const element = selected === undefined ? undefined : page?.elements[selected];
  const kind = element === undefined ? undefined : kinds.get(element.kind);
  return (
    <div class="hmi-editor" onKeyDown={onKey}>
      <div class="tools">
        <span class="buttons">
          <button type="button" class="primary" onClick={() => void save()} disabled={busy || (!history.changed && !pages.made)}>
            {t.save}
          </button>
          <button type="button" onClick={history.undo} disabled={!history.canUndo}>
            {t.undo}
          </button>
          <button type="button" onClick={history.redo} disabled={!history.canRedo}>
            {t.redo}
          </button>
          <button type="button" onClick={() => (history.changed ? setLeaving(true) : leave())}>
            {t.close}
          </button>
        </span>
        <span class="tabs">
          {document_.pages.map((one, i) => (
            <button
              key={i}
              type="button"
              aria-pressed={i === at}
              onClick={() => {
                setAt(i);
                setSelected(undefined);
              }}
            >
              {clipped(titleOf(one), 60)}
            </button>
          ))}
          <button type="button" onClick={addPage}>
            {t.addPage}
          </button>
        </span>
        {history.changed ? <small>{t.changed}</small> : null}
      </div>
      <ProblemBox problem={problem} />
      {problem?.code !== "P7778" ? null : (
        <div class="buttons">
          <button type="button" onClick={() => download("pages.json", JSON.stringify(document_, null, 1), "application/json")}>
            {t.keepCopy}
          </button>
          <button type="button" class="danger" onClick={saveOver}>
            {t.saveOver}
          </button>
        </div>
      )}
      <div class="hmi-workplace">
        <Section title={t.palette} class="hmi-palette">
          <Palette kinds={pages.kinds} page={page} onMake={make} />
        </Section>
        <Section title={t.canvas} class="hmi-page">
          {page === undefined ? null : (
            <EditCanvas page={page} made={made} values={values} selected={selected} onSelect={setSelected} onChange={change} onRemove={remove} onCopy={copy} />
          )}
          <p class="quiet-text">{t.canvasHelp}</p>
        </Section>
        <div class="side">
          <Section title={t.properties}>
            {selected === undefined || element === undefined ? (
              <p class="quiet-text">{t.choose}</p>
            ) : (
              <>
                <ElementForm
                  key={`${at} ${selected} ${element.kind}`}
                  element={element}
                  kind={kind}
                  pages={document_.pages}
                  live={values}
                  onChange={(next, key) => change(selected, next, `${at} ${selected} ${key}`)}
                />
                <div class="buttons">
                  <button type="button" onClick={() => copy(selected)}>
                    {t.copy}
                  </button>
                  <button type="button" onClick={() => front(selected)}>
                    {t.front}
                  </button>
                  <button type="button" class="danger" onClick={() => remove(selected)}>
                    {t.remove}
                  </button>
                </div>
              </>
            )}
          </Section>
          {page === undefined ? null : (
            <Section title={t.page}>
              <PageForm key={at} page={page} onChange={(next, key) => setPage(next, `${at} ${key}`)} />
              <button type="button" class="danger" onClick={removePage}>
                {t.removePage}
              </button>
            </Section>
          )}
        </div>
      </div>
      <p class="unseen" role="status">
        {said}
      </p>
      {leaving ? <LeaveDialog onLeave={leave} onStay={() => setLeaving(false)} /> : null}
    </div>
  );
}
