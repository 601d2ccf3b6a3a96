// Forms of what is edited: the keys that the server tells of each kind.
import type { JSX } from "preact";
import { useState } from "preact/hooks";
import { useLive, type LiveValues } from "../live";
import { texts } from "../texts";
import { Field } from "../ui/parts";
import { PathInput } from "../ui/path_input";
import { clipped, isDuration, isTooLarge } from "../values";
import { fitted, type HmiElement, type HmiKey, type HmiKind, type HmiPage } from "./document";
import { NumberText } from "./number_text";

const t = texts.hmi;
type Values = Record<string, unknown>;

/** TRUE, FALSE, a number, or else a text: also a whole number that would be rounded. */
function plainValue(text: string): boolean | number | string | undefined {
  const trimmed = text.trim();
  if (trimmed === "") return undefined;
  if (/^true$/i.test(trimmed)) return true;
  if (/^false$/i.test(trimmed)) return false;
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(trimmed) && !isTooLarge(trimmed) ? Number(trimmed) : text;
}

function plainText(value: unknown): string {
  return value === undefined || value === null ? "" : value === true ? "TRUE" : value === false ? "FALSE" : String(value);
}

/** A number that may be missing; what is no number is left as it was. `late`: taken when it is entered, not while it is typed. */
function NumberInput(properties: { id: string; value: number | undefined; onInput: (value: number | undefined) => void; whole?: boolean; late?: boolean; low?: number; high?: number }): JSX.Element {
  const { value } = properties;
  const [entered, setEntered] = useState<string>();
  const take = (input: HTMLInputElement): void => {
    const number = input.valueAsNumber;
    if (input.value === "" && input.validity.valid) properties.onInput(undefined);
    else if (Number.isFinite(number) && (properties.whole !== true || Number.isInteger(number))) properties.onInput(number);
  };
  return (
    <input
      id={properties.id}
      type="number"
      step={properties.whole === true ? 1 : "any"}
      min={properties.low}
      max={properties.high}
      value={entered ?? (value === undefined ? "" : String(value))}
      onInput={(event) => {
        setEntered(event.currentTarget.value);
        if (properties.late !== true) take(event.currentTarget);
      }}
      onChange={(event) => {
        if (properties.late === true) take(event.currentTarget);
      }}
      onBlur={() => setEntered(undefined)}
    />
  );
}

function KeyInput(properties: { id: string; field: HmiKey; value: unknown; pages: readonly HmiPage[]; durations: boolean; onInput: (value: unknown) => void }): JSX.Element {
  const { id, field, value, onInput } = properties;
  if (field.name === "variable") return <PathInput id={id} value={plainText(value)} onInput={onInput} />;
  if (field.name === "page" || field.choices !== undefined) {
    const choices = field.name === "page" ? properties.pages.map((page) => page.name) : (field.choices ?? []);
    return (
      <select id={id} value={plainText(value)} onChange={(event) => onInput(event.currentTarget.value)}>
        {["", ...choices].map((choice) => (
          <option key={choice} value={choice}>
            {field.name === "page" ? choice : (t.colours[choice] ?? choice)}
          </option>
        ))}
      </select>
    );
  }
  switch (field.type) {
    case "boolean":
      return <input id={id} type="checkbox" checked={value === true} onChange={(event) => onInput(event.currentTarget.checked ? true : undefined)} />;
    case "number":
    case "integer":
      return <NumberText id={id} value={typeof value === "number" ? value : undefined} durations={properties.durations} onInput={onInput} />;
    case "texts":
      return (
        <textarea
          id={id}
          rows={4}
          spellcheck={false}
          value={(Array.isArray(value) ? value : []).join("\n")}
          onInput={(event) => onInput(event.currentTarget.value === "" ? [] : event.currentTarget.value.split("\n").map((line) => line.trimStart()))}
          onBlur={(event) => onInput(event.currentTarget.value.split("\n").map((line) => line.trim()).filter((line) => line !== ""))}
        />
      );
    case "value":
      return <input id={id} value={plainText(value)} autoComplete="off" spellcheck={false} onChange={(event) => onInput(plainValue(event.currentTarget.value))} />;
    default:
      return <input id={id} value={plainText(value)} maxLength={500} autoComplete="off" onInput={(event) => onInput(event.currentTarget.value)} />;
  }
}

export function ElementForm(properties: {
  element: HmiElement;
  kind: HmiKind | undefined;
  pages: readonly HmiPage[];
  live: LiveValues;
  onChange: (element: HmiElement, key: string) => void;
}): JSX.Element {
  const { element, kind } = properties;
  const { shape } = useLive(properties.live, element.variable === "" ? undefined : element.variable);
  const isTime = shape !== undefined && isDuration(shape);
  const isNumber = (key: HmiKey): boolean => key.type === "number" || key.type === "integer";
  const help = (key: HmiKey): string => (isTime && isNumber(key) ? t.editor.inSeconds(clipped(key.doc, 200)) : clipped(key.doc, 200));
  const values = element as unknown as Values;
  const set = (key: string, value: unknown): void => properties.onChange({ ...(values as object), [key]: value } as unknown as HmiElement, key);
  return (
    <div class="hmi-form">
      <p class="quiet-text">{t.kinds[element.kind] ?? element.kind}</p>
      {(kind?.keys ?? []).map((key) => (
        <Field key={key.name} label={t.keys[key.name] ?? key.name} help={help(key)}>
          {(id) => <KeyInput id={id} field={key} value={values[key.name]} pages={properties.pages} durations={isTime || shape === undefined || key.name === "seconds"} onInput={(value) => set(key.name, value)} />}
        </Field>
      ))}
      <div class="hmi-measures">
        {(["x", "y", "width", "height"] as const).map((key) => {
          const first = key === "x" || key === "y" ? 1 : 0;
          return (
            <Field key={key} label={t.editor[key]}>
              {(id) => <NumberInput id={id} whole low={1} value={element[key] + first} onInput={(value) => (value === undefined ? undefined : set(key, value - first))} />}
            </Field>
          );
        })}
      </div>
    </div>
  );
}

export function PageForm(properties: { page: HmiPage; onChange: (page: HmiPage, key: string) => void }): JSX.Element {
  const { page, onChange } = properties;
  const cells = (key: "columns" | "rows") => (value: number | undefined): void => {
    if (value !== undefined && value >= 1 && value <= 200) onChange(fitted({ ...page, [key]: value }), key);
  };
  return (
    <div class="hmi-form">
      <Field label={t.editor.title}>{(id) => <input id={id} value={page.title ?? ""} maxLength={500} onInput={(event) => onChange({ ...page, title: event.currentTarget.value }, "title")} />}</Field>
      <Field label={t.editor.name}>{(id) => <input id={id} value={page.name} maxLength={40} spellcheck={false} onInput={(event) => onChange({ ...page, name: event.currentTarget.value }, "name")} />}</Field>
      <div class="hmi-measures">
        <Field label={t.editor.columns}>{(id) => <NumberInput id={id} whole late low={1} high={200} value={page.columns} onInput={cells("columns")} />}</Field>
        <Field label={t.editor.rows}>{(id) => <NumberInput id={id} whole late low={1} high={200} value={page.rows} onInput={cells("rows")} />}</Field>
      </div>
    </div>
  );
}
