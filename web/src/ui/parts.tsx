// Parts that pages are made of.
import type { ComponentChildren, JSX } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";
import type { Problem } from "../plc";
import { texts } from "../texts";
import { clipped } from "../values";

export function Section(properties: { title: string; actions?: ComponentChildren; children: ComponentChildren; class?: string }): JSX.Element {
  const id = useId();
  return (
    <section class={`card ${properties.class ?? ""}`} aria-labelledby={id}>
      <div class="card-head">
        <h2 id={id}>{properties.title}</h2>
        {properties.actions}
      </div>
      {properties.children}
    </section>
  );
}

export function Field(properties: { label: string; help?: string; children: (id: string) => ComponentChildren; class?: string }): JSX.Element {
  const id = useId();
  return (
    <div class={`field ${properties.class ?? ""}`}>
      <label for={id}>{properties.label}</label>
      {properties.children(id)}
      {properties.help === undefined ? null : <small>{properties.help}</small>}
    </div>
  );
}

export function Choice<T extends string | number>(properties: {
  label: string;
  value: T;
  options: readonly T[];
  text: (option: T) => string;
  onChange: (option: T) => void;
}): JSX.Element {
  return (
    <Field label={properties.label} class="inline">
      {(id) => (
        <select
          id={id}
          value={String(properties.value)}
          onChange={(event) => {
            const chosen = properties.options.find((option) => String(option) === event.currentTarget.value);
            if (chosen !== undefined) properties.onChange(chosen);
          }}
        >
          {properties.options.map((option) => (
            <option key={String(option)} value={String(option)}>
              {properties.text(option)}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}

export function Badge(properties: { kind: "good" | "warning" | "bad" | "plain"; children: ComponentChildren }): JSX.Element {
  return <span class={`badge ${properties.kind}`}>{properties.children}</span>;
}

/** What was refused, and what to do. */
export function ProblemBox(properties: { problem: Problem | undefined }): JSX.Element {
  const { problem } = properties;
  // WHY always there: a screen reader tells what comes into a region that it knows already.
  return (
    <div role="alert">
      {problem === undefined ? null : (
        <div class="problem">
          <p>{clipped(problem.text)}</p>
          {problem.help === "" ? null : <p>{clipped(problem.help)}</p>}
          {problem.code === "" ? null : <code>{texts.explain(problem.code)}</code>}
        </div>
      )}
    </div>
  );
}

/** A window above the page; Escape and the button close it. */
export function Dialog(properties: { title: string; onClose: () => void; children: ComponentChildren }): JSX.Element {
  const dialog = useRef<HTMLDialogElement>(null);
  // WHY: a text that is marked with the pointer until outside is no click on what is around.
  const from = useRef<EventTarget | null>(null);
  const id = useId();
  useEffect(() => {
    const before = document.activeElement;
    dialog.current?.showModal();
    return () => {
      if (before instanceof HTMLElement) before.focus();
    };
  }, []);
  return (
    <dialog
      ref={dialog}
      aria-labelledby={id}
      onClose={properties.onClose}
      onPointerDown={(event) => {
        from.current = event.target;
      }}
      onClick={(event) => {
        if (event.target === dialog.current && from.current === dialog.current) dialog.current?.close();
      }}
    >
      <div class="dialog-in">
        <div class="card-head">
          <h2 id={id} class="path">
            {clipped(properties.title, 120)}
          </h2>
          <button type="button" class="quiet" aria-label={texts.close} onClick={() => dialog.current?.close()}>
            ✕
          </button>
        </div>
        {properties.children}
      </div>
    </dialog>
  );
}

/** A form that makes one call; while it runs its button cannot be pressed. */
export function CallForm(properties: {
  submit: string;
  danger?: boolean;
  onSubmit: () => Promise<void>;
  onCancel?: () => void;
  children?: ComponentChildren;
  class?: string;
  problemOf: (error: unknown) => Problem;
}): JSX.Element {
  const [busy, setBusy] = useState(false);
  const [problem, setProblem] = useState<Problem>();
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (busy) return;
    setBusy(true);
    setProblem(undefined);
    try {
      await properties.onSubmit();
    } catch (error) {
      setProblem(properties.problemOf(error));
    }
    setBusy(false);
  };
  return (
    <form class={properties.class} onSubmit={(event) => void submit(event)}>
      {properties.children}
      <ProblemBox problem={problem} />
      <div class="buttons">
        <button type="submit" class={properties.danger === true ? "danger" : "primary"} disabled={busy}>
          {properties.submit}
        </button>
        {properties.onCancel === undefined ? null : (
          <button type="button" onClick={properties.onCancel}>
            {texts.cancel}
          </button>
        )}
      </div>
    </form>
  );
}

export function Empty(properties: { children: ComponentChildren }): JSX.Element {
  return <p class="empty">{properties.children}</p>;
}

/** Rows of two columns: what, and how it is. */
export function Facts(properties: { rows: readonly (readonly [string, ComponentChildren])[] }): JSX.Element {
  return (
    <dl class="facts">
      {properties.rows.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}

/** A table that is a list of cards where the screen is narrow. */
export function Table(properties: {
  label: string;
  columns: readonly { title: string; class?: string }[];
  rows: readonly { key: string; cells: readonly ComponentChildren[] }[];
}): JSX.Element {
  const { columns } = properties;
  return (
    <div class="table-frame" role="region" aria-label={properties.label} tabIndex={0}>
      <table aria-label={properties.label}>
        <thead>
          <tr>
            {columns.map((column) => (
              <th key={column.title} scope="col" class={column.class}>
                {column.title}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {properties.rows.map((row) => (
            <tr key={row.key}>
              {row.cells.map((cell, i) => (
                <td key={i} class={columns[i]?.class} data-title={columns[i]?.title}>
                  <span class="cell">{cell}</span>
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
