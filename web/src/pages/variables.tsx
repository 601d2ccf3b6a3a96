// All variables as a tree, or those that match; what one of them has, and what may be done with it; the watch list.
import type { JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Node } from "../../client/calls";
import { useForces, type Forces } from "../forces";
import { LiveValues, useLive, useLiveValues } from "../live";
import { ask, may, plc, problemOf, type Problem } from "../plc";
import { route } from "../route";
import { texts } from "../texts";
import { fetchParts, fold, isFoldable, newBranch, rowAt, rowCount, rowOf, unfold } from "../tree";
import { Badge, Choice, Empty, Field, ProblemBox, Section } from "../ui/parts";
import { VirtualRows, type RowAttributes } from "../ui/virtual_rows";
import { clipped, valueText } from "../values";
import { Details } from "./details";
import { ForceDialog } from "./force_dialog";
import { WatchList, useWatched } from "./watch_list";
import { WriteDialog } from "./write_dialog";

const t = texts.variables;
const rowHeight = 32;
const mostFound = 500;
export const bases = [10, 16, 2, 8] as const;
export type Base = (typeof bases)[number];

function ValueCell(properties: { values: LiveValues; node: Node; base: Base }): JSX.Element {
  const { node } = properties;
  const shown = node.kind === "value" && node.readable === true;
  const live = useLive(properties.values, shown ? node.path : undefined);
  if (node.kind !== "value") return <span class="row-value" />;
  if (!shown) {
    return (
      <span class="row-value quiet-text" title={t.localHelp}>
        {t.local}
      </span>
    );
  }
  const text = live.problem === "" ? valueText(live.raw, live.shape, properties.base) : texts.nothing;
  return <span class={`row-value number ${live.raw === true ? "on" : ""}`}>{clipped(text, 200)}</span>;
}

function NodeRow(properties: {
  attributes: RowAttributes;
  node: Node | undefined;
  name: string;
  level: number;
  open: boolean | undefined;
  place: number;
  total: number;
  tree: boolean;
  values: LiveValues;
  base: Base;
  forces: Forces;
  onFold?: () => void;
}): JSX.Element {
  const { attributes, node, open, tree } = properties;
  const active = attributes.class.includes("active");
  return (
    <div
      {...attributes}
      role={tree ? "treeitem" : "option"}
      aria-level={tree ? properties.level + 1 : undefined}
      aria-setsize={properties.total}
      aria-posinset={properties.place + 1}
      aria-expanded={tree ? open : undefined}
      aria-selected={active}
      data-path={node?.path}
    >
      <span class="row-name path" style={{ paddingLeft: `${Math.min(properties.level, 12) * 16}px` }}>
        {open === undefined ? (
          <span class="fold" />
        ) : (
          <span class="fold" aria-hidden="true" onClick={properties.onFold}>
            {open ? "▾" : "▸"}
          </span>
        )}
        <span class="name">{clipped(properties.name, 200)}</span>
        {node !== undefined && properties.forces.of(node.path) !== undefined ? <Badge kind="warning">{t.forced}</Badge> : null}
      </span>
      {node === undefined ? null : (
        <>
          <span class="row-type">{clipped(node.type ?? "", 100)}</span>
          <ValueCell values={properties.values} node={node} base={properties.base} />
          <span class="row-address">{node.address ?? ""}</span>
        </>
      )}
    </div>
  );
}

/** The tree, whose rows are those of what is unfolded. */
function Tree(properties: {
  values: LiveValues;
  base: Base;
  forces: Forces;
  onSelect: (node: Node | undefined) => void;
  onKey: (event: KeyboardEvent, node: Node) => boolean;
}): JSX.Element {
  const root = useMemo(() => newBranch("", 0), []);
  const [, redraw] = useState(0);
  const [active, setActive] = useState(0);
  const [problem, setProblem] = useState<Problem>();
  const again = (): void => redraw((n) => n + 1);
  const answered = (): void => {
    setProblem(undefined);
    again();
  };
  useEffect(() => fetchParts(root, 0, answered, (error) => setProblem(problemOf(error))), [root]);
  const selected = rowAt(root, active).node;
  useEffect(() => properties.onSelect(selected), [selected]);
  const toggle = (number: number): void => {
    const row = rowAt(root, number);
    if (row.below === undefined) {
      unfold(row);
    } else {
      fold(row);
    }
    again();
  };
  const onKey = (event: KeyboardEvent): boolean => {
    const row = rowAt(root, active);
    if (row.node === undefined) return false;
    if (event.key === "ArrowRight") {
      if (row.below !== undefined) setActive(active + 1);
      else if (isFoldable(row.node)) toggle(active);
      return true;
    }
    if (event.key === "ArrowLeft") {
      if (row.below !== undefined) {
        toggle(active);
      } else {
        // To what it is a part of.
        const first = rowOf(root, row.branch, 0);
        if (first !== undefined && first > 0) setActive(first - 1);
      }
      return true;
    }
    if (event.key === "Enter" && isFoldable(row.node)) {
      toggle(active);
      return true;
    }
    return properties.onKey(event, row.node);
  };
  if (root.total === 0) return <Empty>{t.empty}</Empty>;
  return (
    <>
      <ProblemBox problem={problem} />
      <VirtualRows
        label={t.tree}
        role="tree"
        count={rowCount(root)}
        rowHeight={rowHeight}
        active={active}
        onActive={setActive}
        onKey={onKey}
        row={(number, attributes) => {
          const row = rowAt(root, number);
          if (row.node === undefined) fetchParts(row.branch, row.place, answered, (error) => setProblem(problemOf(error)));
          const foldable = row.node !== undefined && isFoldable(row.node);
          return (
            <NodeRow
              key={`${row.branch.path}\n${row.place}`}
              attributes={attributes}
              node={row.node}
              name={row.node?.name ?? texts.loading}
              level={row.branch.level}
              open={foldable ? row.below !== undefined : undefined}
              place={row.place}
              total={row.branch.total ?? 1}
              tree={true}
              values={properties.values}
              base={properties.base}
              forces={properties.forces}
              onFold={() => toggle(number)}
            />
          );
        }}
      />
    </>
  );
}

/** What a search has found, as a flat list. */
function Found(properties: {
  pattern: string;
  values: LiveValues;
  base: Base;
  forces: Forces;
  onSelect: (node: Node | undefined) => void;
  onKey: (event: KeyboardEvent, node: Node) => boolean;
}): JSX.Element {
  const [answer, setAnswer] = useState<{ nodes: Node[]; more: boolean }>();
  const [problem, setProblem] = useState<Problem>();
  const [active, setActive] = useState(0);
  useEffect(() => {
    let outdated = false;
    const timer = setTimeout(() => {
      ask(() => plc.valuesSearch({ pattern: `*${properties.pattern}*`, most: mostFound })).then(
        (found) => {
          if (outdated) return;
          setAnswer(found);
          setProblem(undefined);
          setActive(0);
        },
        (error: unknown) => {
          if (!outdated) setProblem(problemOf(error));
        },
      );
    }, 150);
    return () => {
      outdated = true;
      clearTimeout(timer);
    };
  }, [properties.pattern]);
  const selected = answer?.nodes[active];
  useEffect(() => properties.onSelect(selected), [selected]);
  return (
    <>
      <ProblemBox problem={problem} />
      <p role="status" class="quiet-text">
        {answer === undefined ? texts.loading : answer.nodes.length === 0 ? t.none : t.found(answer.nodes.length, answer.more)}
      </p>
      <VirtualRows
        label={t.search}
        role="listbox"
        count={answer?.nodes.length ?? 0}
        rowHeight={rowHeight}
        active={active}
        onActive={setActive}
        onKey={(event) => selected !== undefined && properties.onKey(event, selected)}
        row={(number, attributes) => (
          <NodeRow
            key={answer?.nodes[number]?.path}
            attributes={attributes}
            node={answer?.nodes[number]}
            name={answer?.nodes[number]?.path ?? ""}
            level={0}
            open={undefined}
            place={number}
            total={answer?.nodes.length ?? 0}
            tree={false}
            values={properties.values}
            base={properties.base}
            forces={properties.forces}
          />
        )}
      />
    </>
  );
}

export function VariablesPage(): JSX.Element {
  const values = useLiveValues(100);
  const [pattern, setPattern] = useState(() => route.peek().parameters.get("path") ?? "");
  const [base, setBase] = useState<Base>(10);
  const [selected, setSelected] = useState<Node>();
  const [writing, setWriting] = useState<string>();
  const [forcing, setForcing] = useState<string>();
  const watched = useWatched();
  const forces = useForces();
  const search = useRef<HTMLInputElement>(null);
  const onKey = (event: KeyboardEvent, node: Node): boolean => {
    if (node.kind !== "value") return false;
    if (event.key === "Enter" && node.writable === true && may("values.write")) {
      setWriting(node.path);
      return true;
    }
    if (event.key.toLowerCase() === "w" && node.readable === true) {
      watched.toggle(node.path);
      return true;
    }
    return false;
  };
  return (
    <div class="variables">
      <Section title={t.tree} class="fill">
        <div class="tools">
          <Field label={t.search} class="inline grow">
            {(id) => (
              <input id={id} ref={search} type="search" value={pattern} maxLength={900} placeholder={t.searchHelp} spellcheck={false}
                onInput={(event) => setPattern(event.currentTarget.value)} />
            )}
          </Field>
          <Choice label={t.base} value={base} options={bases} text={(one) => t.bases[one] ?? String(one)} onChange={setBase} />
        </div>
        <div class="row head" aria-hidden="true">
          <span class="row-name">{t.name}</span>
          <span class="row-type">{t.type}</span>
          <span class="row-value">{t.value}</span>
          <span class="row-address">{t.address}</span>
        </div>
        {pattern.trim() === "" ? (
          <Tree values={values} base={base} forces={forces} onSelect={setSelected} onKey={onKey} />
        ) : (
          <Found pattern={pattern.trim()} values={values} base={base} forces={forces} onSelect={setSelected} onKey={onKey} />
        )}
        <p class="quiet-text keys">{t.keys}</p>
      </Section>
      <div class="side">
        <Details values={values} node={selected} base={base} watched={watched} forces={forces} onWrite={setWriting} onForce={setForcing} />
        <WatchList values={values} base={base} watched={watched} onWrite={setWriting} />
      </div>
      {forcing === undefined ? null : (
        <ForceDialog
          path={forcing}
          values={values}
          base={base}
          onClose={() => {
            setForcing(undefined);
            forces.again();
          }}
        />
      )}
      {writing === undefined ? null : <WriteDialog path={writing} values={values} base={base} onClose={() => setWriting(undefined)} />}
    </div>
  );
}
