// What people do with alarms: acknowledge them, shelve them, take them out of service.
import type { JSX } from "preact";
import { useState } from "preact/hooks";
import type { Alarm } from "../../client/calls";
import { notify } from "../notice";
import { ask, may, plc, problemOf } from "../plc";
import { texts } from "../texts";
import { CallForm, Choice, Dialog, Facts, Field } from "../ui/parts";
import { clipped } from "../values";

const t = texts.alarms;
/** How long an alarm may be shelved, in seconds. */
const spans = [600, 3600, 4 * 3600, 8 * 3600, 24 * 3600, 7 * 24 * 3600] as const;

function Comment(properties: { label: string; value: string; required: boolean; onInput: (text: string) => void }): JSX.Element {
  return (
    <Field label={properties.label}>
      {(id) => (
        <input id={id} value={properties.value} required={properties.required} maxLength={500} autoComplete="off"
          onInput={(event) => properties.onInput(event.currentTarget.value)} />
      )}
    </Field>
  );
}

export function AcknowledgeDialog(properties: { names: readonly string[]; onClose: () => void; onDone: () => void }): JSX.Element {
  const [comment, setComment] = useState("");
  const submit = async (): Promise<void> => {
    const answer = await ask(() => plc.alarmsAck({ names: [...properties.names], ...(comment === "" ? {} : { comment }) }));
    notify(t.ackDone(answer.acknowledged));
    properties.onDone();
    properties.onClose();
  };
  return (
    <Dialog title={t.ackTitle(properties.names.length)} onClose={properties.onClose}>
      <CallForm submit={t.ack} onSubmit={submit} onCancel={properties.onClose} problemOf={problemOf}>
        <ul class="names">
          {properties.names.slice(0, 20).map((name) => (
            <li key={name} class="path">
              {clipped(name, 120)}
            </li>
          ))}
        </ul>
        <Comment label={t.comment} value={comment} required={false} onInput={setComment} />
      </CallForm>
    </Dialog>
  );
}

function ShelveForm(properties: { alarm: Alarm; onDone: (text: string) => void }): JSX.Element {
  const { name } = properties.alarm;
  const [span, setSpan] = useState<number>(spans[1]);
  const [reason, setReason] = useState("");
  if (properties.alarm.until !== undefined) {
    const submit = async (): Promise<void> => {
      await ask(() => plc.alarmsUnshelve({ name }));
      properties.onDone(t.unshelve);
    };
    return <CallForm submit={t.unshelve} onSubmit={submit} problemOf={problemOf} />;
  }
  const submit = async (): Promise<void> => {
    await ask(() => plc.alarmsShelve({ name, seconds: span, reason }));
    properties.onDone(t.states["shelved"] ?? "");
  };
  return (
    <CallForm submit={t.shelve} onSubmit={submit} problemOf={problemOf}>
      <p class="quiet-text">{t.shelveHelp}</p>
      <Choice label={t.shelfSpan} value={span} options={spans as readonly number[]} text={t.span} onChange={setSpan} />
      <Comment label={t.reason} value={reason} required={true} onInput={setReason} />
    </CallForm>
  );
}

function ServiceForm(properties: { alarm: Alarm; onDone: (text: string) => void }): JSX.Element {
  const { name } = properties.alarm;
  const out = properties.alarm.state === "out of service";
  const [reason, setReason] = useState("");
  const submit = async (): Promise<void> => {
    await ask(() => plc.alarmsService({ name, out: !out, reason }));
    properties.onDone(out ? t.inService : (t.states["out of service"] ?? ""));
  };
  return (
    <CallForm submit={out ? t.inService : t.outOfService} danger={!out} onSubmit={submit} problemOf={problemOf}>
      {out ? null : <p class="quiet-text">{t.serviceHelp}</p>}
      <Comment label={t.reason} value={reason} required={true} onInput={setReason} />
    </CallForm>
  );
}

export function AlarmDialog(properties: { alarm: Alarm; onClose: () => void; onDone: () => void }): JSX.Element {
  const { alarm } = properties;
  const done = (text: string): void => {
    notify(t.done(alarm.name, text));
    properties.onDone();
    properties.onClose();
  };
  return (
    <Dialog title={alarm.name} onClose={properties.onClose}>
      <p>{clipped(alarm.text)}</p>
      {alarm.help === "" ? null : <p>{clipped(alarm.help)}</p>}
      <Facts
        rows={[
          [t.state, t.states[alarm.state] ?? alarm.state],
          ...(alarm.variable === "" ? [] : [[texts.variables.path, <span class="path">{clipped(alarm.variable, 200)}</span>] as const]),
          ...(alarm.user === undefined ? [] : [[t.by, clipped(alarm.user, 64)] as const]),
          ...(alarm.comment === undefined ? [] : [[t.comment, clipped(alarm.comment, 500)] as const]),
        ]}
      />
      {may("alarms.shelve") ? <ShelveForm alarm={alarm} onDone={done} /> : null}
      {may("alarms.service") ? <ServiceForm alarm={alarm} onDone={done} /> : null}
    </Dialog>
  );
}
