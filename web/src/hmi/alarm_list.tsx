// An element with the alarms that are not in their normal state.
import type { JSX } from "preact";
import { useState } from "preact/hooks";
import { alarmTime } from "../alarm_banner";
import { AcknowledgeDialog } from "../pages/alarm_dialogs";
import { isUnacked, StateOf } from "../pages/alarms";
import { may, plc, usePolled } from "../plc";
import { texts } from "../texts";
import { ProblemBox } from "../ui/parts";
import { clipped } from "../values";
import type { HmiElement } from "./document";

const t = texts.alarms;

export function AlarmList(properties: { element: HmiElement }): JSX.Element {
  const { element } = properties;
  const polled = usePolled(() => plc.alarmsList({}), 1000);
  const [acknowledged, setAcknowledged] = useState<readonly string[]>([]);
  const wanted = element.class ?? "";
  const alarms = (polled.answer?.alarms ?? []).filter((alarm) => wanted === "" || alarm.class === wanted);
  return (
    <>
      <span class="hmi-label">{clipped(element.label ?? (wanted === "" ? t.present : wanted), 80)}</span>
      <ProblemBox problem={polled.problem} />
      <ul class="hmi-alarms" tabIndex={0} aria-label={clipped(element.label ?? t.present, 80)}>
        {alarms.map((alarm) => (
          <li key={alarm.name}>
            <StateOf alarm={alarm} />
            <span class="hmi-alarm-text">{clipped(alarm.text, 200)}</span>
            {alarm.since === undefined ? null : <span class="number quiet-text">{alarmTime(alarm.since)}</span>}
            {isUnacked(alarm) && may("alarms.ack") ? (
              <button type="button" class="small" aria-label={t.ackOne(alarm.name)} onClick={() => setAcknowledged([alarm.name])}>
                {t.ack}
              </button>
            ) : null}
          </li>
        ))}
        {alarms.length === 0 && polled.answer !== undefined ? <li>{t.none}</li> : null}
      </ul>
      {acknowledged.length === 0 ? null : <AcknowledgeDialog names={acknowledged} onClose={() => setAcknowledged([])} onDone={polled.again} />}
    </>
  );
}
