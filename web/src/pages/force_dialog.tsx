import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";
import { LiveValues, useLive } from "../live";
import { notify } from "../notice";
import { ask, plc } from "../plc";
import { texts } from "../texts";
import { CallForm, Dialog, Empty, Field } from "../ui/parts";
import { valueText } from "../values";
import { ValueInput, valueOf, wrongValue } from "./write_dialog";

const t = texts.forces;
/** After which a force ends by itself, in seconds; 0: not at all. */
const spans = [0, 60, 600, 3600, 8 * 3600] as const;

export function ForceDialog(properties: { path: string; values: LiveValues; base: number; onClose: () => void }): JSX.Element {
  const { path } = properties;
  const { shape, raw, problem } = useLive(properties.values, path);
  const [entered, setEntered] = useState<string>();
  const [reason, setReason] = useState("");
  const [span, setSpan] = useState(0);
  useEffect(() => {
    if (entered === undefined && shape !== undefined && raw !== undefined) setEntered(valueText(raw, shape, properties.base));
  }, [shape, raw]);
  const submit = async (): Promise<void> => {
    if (shape === undefined) return;
    const value = valueOf(entered ?? "", shape);
    await ask(() => plc.forcesSet({ path, value, reason, ...(span === 0 ? {} : { seconds: span }) }));
    notify(t.done(path));
    properties.onClose();
  };
  return (
    <Dialog title={t.title(path)} onClose={properties.onClose}>
      {problem !== "" ? (
        <Empty>{problem}</Empty>
      ) : shape === undefined || entered === undefined ? (
        <p>{texts.loading}</p>
      ) : (
        <CallForm submit={t.submit} danger={true} onSubmit={submit} onCancel={properties.onClose} problemOf={wrongValue}>
          <p class="quiet-text">{t.help}</p>
          <Field label={t.value}>{(id) => <ValueInput id={id} shape={shape} value={entered} onInput={setEntered} />}</Field>
          <Field label={t.reason} help={t.reasonHelp}>
            {(id) => <input id={id} value={reason} required maxLength={500} onInput={(event) => setReason(event.currentTarget.value)} />}
          </Field>
          <Field label={t.lasts}>
            {(id) => (
              <select id={id} value={String(span)} onChange={(event) => setSpan(Number(event.currentTarget.value))}>
                {spans.map((one) => (
                  <option key={one} value={String(one)}>
                    {one === 0 ? t.never : t.span(one)}
                  </option>
                ))}
              </select>
            )}
          </Field>
        </CallForm>
      )}
    </Dialog>
  );
}
