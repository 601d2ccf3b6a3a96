import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { Value } from "../../client/connection";
import { LiveValues, useLive } from "../live";
import { notify } from "../notice";
import { ask, plc, problemOf, type Problem } from "../plc";
import { texts } from "../texts";
import { CallForm, Dialog, Empty, Facts, Field } from "../ui/parts";
import { clipped, isInteger, isReal, parsedValue, valueText, type Shape } from "../values";

const t = texts.variables;

export function ValueInput(properties: { id: string; shape: Shape; value: string; onInput: (value: string) => void }): JSX.Element {
  const { id, shape, value } = properties;
  const field = useRef<HTMLElement>(null);
  // WHY not autofocus: the value, and with it this field, comes after the dialog.
  useEffect(() => field.current?.focus(), []);
  const members = shape.form === "bool" ? ["FALSE", "TRUE"] : shape.members?.map((member) => member.name);
  if (members !== undefined && members.length !== 0) {
    return (
      <select id={id} ref={(element) => void (field.current = element)} value={value} onChange={(event) => properties.onInput(event.currentTarget.value)}>
        {members.includes(value) ? null : <option value={value}>{value}</option>}
        {members.map((name) => (
          <option key={name} value={name}>
            {clipped(name, 100)}
          </option>
        ))}
      </select>
    );
  }
  return (
    <input
      id={id}
      ref={(element) => void (field.current = element)}
      value={value}
      autoComplete="off"
      spellcheck={false}
      inputMode={isReal(shape) ? "decimal" : "text"}
      onFocus={(event) => event.currentTarget.select()}
      onInput={(event) => properties.onInput(event.currentTarget.value)}
    />
  );
}

/** What was entered, for a call. Throws, with a sentence, when it is no value. */
export function valueOf(entered: string, shape: Shape): Value {
  const value = parsedValue(entered, shape);
  if (value !== null) return value;
  throw new Error(isInteger(shape) ? t.problem.integer : isReal(shape) ? t.problem.real : t.problem.number);
}

export function wrongValue(error: unknown): Problem {
  const isOwn = error instanceof Error && error.constructor === Error;
  return isOwn ? { text: error.message, code: "", help: "" } : problemOf(error);
}

export function WriteDialog(properties: { path: string; values: LiveValues; base: number; onClose: () => void }): JSX.Element {
  const { path } = properties;
  const live = useLive(properties.values, path);
  const [entered, setEntered] = useState<string>();
  const [reason, setReason] = useState("");
  const { shape, raw } = live;
  useEffect(() => {
    if (entered !== undefined || shape === undefined || raw === undefined) return;
    // The other one is what somebody wants of a BOOL.
    setEntered(typeof raw === "boolean" ? (raw ? "FALSE" : "TRUE") : valueText(raw, shape, properties.base));
  }, [shape, raw]);
  const submit = async (): Promise<void> => {
    if (shape === undefined) return;
    const value = valueOf(entered ?? "", shape);
    await ask(() => plc.valuesWrite({ values: [{ path, value }], ...(reason === "" ? {} : { reason }) }));
    notify(t.written(path));
    properties.onClose();
  };
  return (
    <Dialog title={t.writeTitle(path)} onClose={properties.onClose}>
      {live.problem !== "" ? (
        <Empty>{live.problem}</Empty>
      ) : shape === undefined || entered === undefined ? (
        <p>{texts.loading}</p>
      ) : (
        <CallForm submit={t.submit} onSubmit={submit} onCancel={properties.onClose} problemOf={wrongValue}>
          <Facts
            rows={[
              [t.type, clipped(shape.type, 100)],
              [t.present, <span class="number">{clipped(valueText(raw, shape, properties.base), 200)}</span>],
            ]}
          />
          <Field label={t.next} help={t.writeHelp}>
            {(id) => <ValueInput id={id} shape={shape} value={entered} onInput={setEntered} />}
          </Field>
          <Field label={t.reason} help={t.reasonHelp}>
            {(id) => <input id={id} value={reason} maxLength={500} onInput={(event) => setReason(event.currentTarget.value)} />}
          </Field>
        </CallForm>
      )}
    </Dialog>
  );
}
