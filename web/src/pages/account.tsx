import type { JSX } from "preact";
import { useState } from "preact/hooks";
import { ask, findSession, plc, problemOf, sessionEnd } from "../plc";
import { texts } from "../texts";
import { CallForm, Dialog, Field } from "../ui/parts";

export function AccountDialog(properties: { onClose: () => void }): JSX.Element {
  const [before, setBefore] = useState("");
  const [next, setNext] = useState("");
  const submit = async (): Promise<void> => {
    await ask(() => plc.password({ old: before, new: next }));
    await findSession();
    sessionEnd.value = texts.account.changed;
  };
  return (
    <Dialog title={texts.account.title} onClose={properties.onClose}>
      <CallForm submit={texts.account.change} onSubmit={submit} onCancel={properties.onClose} problemOf={problemOf}>
        <Field label={texts.account.old}>
          {(id) => (
            <input id={id} type="password" value={before} required autoComplete="current-password"
              onInput={(event) => setBefore(event.currentTarget.value)} />
          )}
        </Field>
        <Field label={texts.account.next}>
          {(id) => (
            <input id={id} type="password" value={next} required minLength={10} autoComplete="new-password"
              onInput={(event) => setNext(event.currentTarget.value)} />
          )}
        </Field>
      </CallForm>
      <p>
        <a href="/licences.txt">{texts.account.licences}</a>
      </p>
    </Dialog>
  );
}
