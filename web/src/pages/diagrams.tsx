// Drawings and texts of POUs, with the power flow of the plant that runs, or of any recorded scan.
import type { JSX } from "preact";
import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import type { CauseLink, DiagramsSheetAnswer, DrawnInstance, DrawnPlace, DrawnPou, DrawnUse } from "../../client/calls";
import { LiveFlow, PastFlow, type Looked } from "../diagrams/flow";
import { TimeBar, type Shown } from "../diagrams/past";
import { print } from "../diagrams/print";
import { Sheet, type Selected } from "../diagrams/sheet";
import { CauseList, FoundList, SelectedCard } from "../diagrams/side";
import type { Tiles, View } from "../diagrams/tiles";
import { isNumber, keep, kept } from "../kept";
import { ask, plc, problemOf, type Problem } from "../plc";
import { link, route } from "../route";
import { useSignal } from "../signals";
import { texts } from "../texts";
import { Choice, Empty, Field, ProblemBox, Section } from "../ui/parts";
import { clipped } from "../values";

const t = texts.diagrams;
const zooms = [0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3] as const;
const mostInstances = 1000;

/** The address of a place, so that the way back is the browser's. */
function linkTo(pou: string, instance: string | undefined, place?: DrawnPlace): string {
  const parameters: Record<string, string> = { pou };
  if (instance !== undefined && instance !== "") parameters["instance"] = instance;
  if (place !== undefined) {
    parameters["body"] = String(place.body);
    if (place.element === undefined) parameters["line"] = String(place.line);
    else parameters["element"] = String(place.element);
  }
  return link("diagrams", parameters);
}

/** The instances of a POU; a field to search where there are many. */
function InstanceChoice(properties: { pou: DrawnPou; instance: string; onChange: (instance: string) => void }): JSX.Element | null {
  const { pou } = properties;
  const [pattern, setPattern] = useState("");
  const [answer, setAnswer] = useState<{ instances: DrawnInstance[]; total: number }>();
  useEffect(() => {
    let outdated = false;
    ask(() => plc.diagramsInstances({ pou: pou.pou, pattern, most: mostInstances })).then(
      (found) => outdated || setAnswer(found),
      () => {},
    );
    return () => {
      outdated = true;
    };
  }, [pou.pou, pattern]);
  if (answer === undefined || pou.instances < 2) return null;
  const paths = answer.instances.map((one) => one.path);
  const options = paths.includes(properties.instance) || properties.instance === "" ? paths : [properties.instance, ...paths];
  return (
    <>
      <Choice label={t.instance} value={properties.instance} options={options} text={(path) => clipped(path, 80)} onChange={properties.onChange} />
      {pou.instances <= 50 ? null : (
        <Field label={t.instanceSearch} class="inline">
          {(id) => <input id={id} type="search" value={pattern} maxLength={200} spellcheck={false} onInput={(event) => setPattern(event.currentTarget.value)} />}
        </Field>
      )}
    </>
  );
}

function Diagram(properties: { pous: readonly DrawnPou[]; pou: DrawnPou }): JSX.Element {
  const { pou } = properties;
  const { parameters } = useSignal(route);
  const instance = parameters.get("instance") ?? "";
  const [sheet, setSheet] = useState<DiagramsSheetAnswer & { of: string }>();
  const [zoom, setZoom] = useState(() => kept("zoom", 1, isNumber));
  const [goal, setGoal] = useState<View>();
  const [shown, setShown] = useState<Shown>();
  const [selected, setSelected] = useState<Selected>();
  const [path, setPath] = useState<string>();
  const [problem, setProblem] = useState<Problem>();
  const [busy, setBusy] = useState(false);
  const [text, setText] = useState("");
  const [found, setFound] = useState<{ title: string; found: DrawnUse[]; more: boolean }>();
  const [causes, setCauses] = useState<{ recording: number; links: CauseLink[] }>();
  /** The recording that is looked into; undefined: live. */
  const [past, setPast] = useState<number>();
  /** The scan of it that is wanted: by its number, or, on another task, by the time. */
  const wish = useRef<{ scan?: number; now_ns?: number }>({});
  const shownWish = useRef(wish.current);
  const tiles = useRef<Tiles | undefined>(undefined);
  const points = useRef<number[]>([]);
  const lookAgain = useRef(() => {});
  const fail = useCallback((error: unknown) => setProblem(problemOf(error)), []);
  const looked: Looked = { pou: pou.pou, instance, task: "" };

  useEffect(() => {
    let outdated = false;
    setSelected(undefined);
    setProblem(undefined);
    ask(() => plc.diagramsSheet({ pou: pou.pou })).then((answer) => outdated || setSheet({ ...answer, of: pou.pou }), fail);
    return () => {
      outdated = true;
    };
  }, [pou.pou]);

  // Live, or one scan: whatever is shown asks for the points that are in view.
  useEffect(() => {
    tiles.current?.clear();
    if (!pou.live && past === undefined) {
      setShown(undefined);
      lookAgain.current = () => {};
      return undefined;
    }
    if (past !== undefined) {
      let ended = false;
      let nowNs: number | undefined;
      const flow = new PastFlow(
        past,
        (frame) => {
          if (ended) return;
          nowNs = frame.nowNs;
          wish.current = shownWish.current = { scan: frame.scan };
          tiles.current?.apply(frame.points);
          setShown({ scan: frame.scan, utcMs: frame.utcMs, task: frame.task, past: { first: frame.first, last: frame.last } });
        },
        setProblem,
      );
      lookAgain.current = () => flow.show(looked, points.current, wish.current);
      lookAgain.current();
      return () => {
        ended = true;
        lookAgain.current = () => {};
        // The next POU may be on another task, which counts its own scans; what was asked for meanwhile stays.
        if (nowNs !== undefined && wish.current === shownWish.current) wish.current = { now_ns: nowNs };
      };
    }
    let task = "";
    const flow = new LiveFlow(
      (frame) => {
        tiles.current?.apply(frame.points);
        setShown({ scan: frame.scan, utcMs: frame.utcMs, task, past: undefined });
      },
      (answer, refused) => {
        task = answer?.task ?? "";
        setProblem(refused);
      },
    );
    lookAgain.current = () => flow.look(looked, points.current);
    lookAgain.current();
    return () => {
      flow.close();
      lookAgain.current = () => {};
    };
  }, [pou.pou, pou.live, instance, past]);

  const body = parameters.get("body");
  const element = parameters.get("element");
  const line = parameters.get("line");
  useEffect(() => {
    setGoal(undefined);
    if (body === null || sheet?.of !== pou.pou) return;
    const place = { pou: pou.pou, body: Number(body), ...(element === null ? {} : { element: Number(element) }), ...(line === null ? {} : { line: Number(line) }) };
    ask(() => plc.diagramsPlace(place)).then(setGoal, fail);
  }, [parameters, sheet]);

  useEffect(() => {
    setPath(undefined);
    if (selected === undefined || selected.name === "") return undefined;
    let outdated = false;
    const asked = { text: clipped(selected.name, 199), pou: pou.pou, instance, uses: true, most: 1 };
    ask(() => plc.diagramsFind(asked)).then((answer) => outdated || setPath(answer.path), () => {});
    return () => {
      outdated = true;
    };
  }, [selected, instance]);

  const working = (work: Promise<void>): void => {
    setBusy(true);
    setProblem(undefined);
    work.catch(fail).finally(() => setBusy(false));
  };
  const pause = (): void =>
    working(
      ask(() => plc.diagramsPast()).then(({ recording }) => {
        wish.current = shown === undefined ? {} : { scan: shown.scan };
        setPast(recording);
      }),
    );
  const showScan = (scan: number): void => {
    wish.current = { scan };
    lookAgain.current();
  };
  const show = (place: DrawnPlace, on?: string): void => {
    location.hash = linkTo(place.pou, on ?? (place.pou === pou.pou ? instance : undefined), place);
  };
  const search = (event: Event): void => {
    event.preventDefault();
    const wanted = text.trim();
    if (wanted === "") return;
    working(ask(() => plc.diagramsFind({ text: clipped(wanted, 199) })).then((answer) => setFound({ title: t.searchTitle(wanted), ...answer })));
  };
  const uses = (name: string): void =>
    working(ask(() => plc.diagramsFind({ text: clipped(name, 199), pou: pou.pou, instance, uses: true })).then((answer) => setFound({ title: t.usesTitle(name), ...answer })));
  const why = (name: string): void => {
    const asked = { pou: pou.pou, instance, name };
    const when = past === undefined || shown === undefined ? {} : { recording: past, scan: shown.scan };
    working(ask(() => plc.diagramsWhy({ ...asked, ...when })).then(setCauses));
  };
  const open = (block: Selected): void => {
    const type = properties.pous.find((one) => one.pou.toUpperCase() === block.type.toUpperCase());
    if (type === undefined) return;
    working(
      ask(() => plc.diagramsInstances({ pou: type.pou, pattern: clipped(block.name, 400) })).then(({ instances }) => {
        const below = `${instance === "" ? (shownInstance ?? "") : instance}.${block.name}`.toUpperCase();
        const exact = instances.find((one) => one.path.toUpperCase() === below) ?? instances.find((one) => one.path.toUpperCase() === block.name.toUpperCase());
        location.hash = linkTo(type.pou, (exact ?? instances[0])?.path);
      }),
    );
  };
  const [shownInstance, setShownInstance] = useState<string>();
  useEffect(() => {
    setShownInstance(instance === "" ? undefined : instance);
    if (instance !== "" || pou.instances === 0) return;
    ask(() => plc.diagramsInstances({ pou: pou.pou, most: 1 })).then(({ instances }) => setShownInstance(instances[0]?.path), () => {});
  }, [pou.pou, instance]);
  const step = (direction: 1 | -1): void => {
    const near = zooms.reduce<number>((best, one, i) => (Math.abs(one - zoom) < Math.abs((zooms[best] ?? 1) - zoom) ? i : best), 0);
    const next = zooms[Math.max(0, Math.min(zooms.length - 1, near + direction))] ?? 1;
    keep("zoom", next);
    setZoom(next);
  };

  return (
    <div class="variables">
      <Section title={clipped(shownInstance === undefined || shownInstance === pou.pou ? pou.pou : `${pou.pou}: ${shownInstance}`, 120)} class="fill">
        <div class="tools">
          <Choice label={t.pou} value={pou.pou} options={properties.pous.map((one) => one.pou)} text={(name) => clipped(name, 80)}
            onChange={(name) => (location.hash = linkTo(name, undefined))} />
          <InstanceChoice pou={pou} instance={shownInstance ?? ""} onChange={(one) => (location.hash = linkTo(pou.pou, one))} />
          <form class="field inline grow" role="search" onSubmit={search}>
            <label for="diagram-search">{t.search}</label>
            <span class="joined">
              <input id="diagram-search" type="search" value={text} maxLength={200} spellcheck={false} onInput={(event) => setText(event.currentTarget.value)} />
              <button type="submit">{t.find}</button>
            </span>
          </form>
          <span class="buttons">
            <button type="button" aria-label={t.zoomOut} title={t.zoomOut} onClick={() => step(-1)}>
              −
            </button>
            <button type="button" aria-label={t.zoomIn} title={t.zoomIn} onClick={() => step(1)}>
              +
            </button>
            <a class="button" href={`/api/diagrams/svg?${new URLSearchParams({ pou: pou.pou })}`} download={`${pou.pou}.svg`}>
              {t.svg}
            </a>
            <button type="button" disabled={busy} onClick={() => working(print(pou.pou))}>
              {t.print}
            </button>
          </span>
        </div>
        <TimeBar shown={shown} busy={busy} onPause={pause} onLive={() => setPast(undefined)} onScan={showScan} />
        {sheet?.of !== pou.pou ? (
          <p>{texts.loading}</p>
        ) : (
          <Sheet
            pou={pou.pou}
            width={sheet.width}
            height={sheet.height}
            zoom={zoom}
            goal={goal}
            live={past === undefined}
            onTiles={(made) => {
              tiles.current = made;
            }}
            onPoints={(seen) => {
              points.current = seen;
              lookAgain.current();
            }}
            onSelect={setSelected}
            onProblem={fail}
            onZoom={step}
          />
        )}
        <p class="quiet-text">{pou.live ? t.help : t.notLive}</p>
      </Section>
      <div class="side">
        <ProblemBox problem={problem} />
        <SelectedCard
          selected={selected}
          path={path}
          canOpen={selected !== undefined && properties.pous.some((one) => one.pou.toUpperCase() === selected.type.toUpperCase())}
          canAsk={pou.live}
          busy={busy}
          onOpen={() => selected !== undefined && open(selected)}
          onUses={() => selected !== undefined && uses(selected.name)}
          onWhy={() => selected !== undefined && why(selected.name)}
        />
        {causes === undefined ? null : (
          <CauseList
            links={causes.links}
            onClose={() => setCauses(undefined)}
            onShow={(one) => {
              wish.current = { scan: one.scan };
              setPast(causes.recording);
              lookAgain.current();
              if (one.place !== undefined) show(one.place, one.instance);
            }}
          />
        )}
        {found === undefined ? null : <FoundList {...found} onShow={(place) => show(place)} onClose={() => setFound(undefined)} />}
      </div>
    </div>
  );
}

export function DiagramsPage(): JSX.Element {
  const [pous, setPous] = useState<DrawnPou[]>();
  const [problem, setProblem] = useState<Problem>();
  const { parameters } = useSignal(route);
  useEffect(() => {
    ask(() => plc.diagrams()).then(
      (answer) => setPous(answer.pous),
      (error: unknown) => setProblem(problemOf(error)),
    );
  }, []);
  const wanted = parameters.get("pou")?.toUpperCase();
  const pou = pous?.find((one) => one.pou.toUpperCase() === wanted) ?? pous?.find((one) => one.owner === "program") ?? pous?.[0];
  return (
    <>
      <ProblemBox problem={problem} />
      {pous === undefined ? <p>{texts.loading}</p> : pou === undefined ? <Empty>{t.none}</Empty> : <Diagram pous={pous} pou={pou} />}
    </>
  );
}
