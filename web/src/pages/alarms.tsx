// What is wrong in the plant, who has seen it, and what was.
import type { JSX } from "preact";
import { useState } from "preact/hooks";
import type { Alarm, AlarmEvent } from "../../client/calls";
import { alarmTime } from "../alarm_banner";
import { may, plc, usePolled } from "../plc";
import { texts } from "../texts";
import { Badge, Choice, Empty, ProblemBox, Section, Table } from "../ui/parts";
import { clipped } from "../values";
import { AcknowledgeDialog, AlarmDialog } from "./alarm_dialogs";

const t = texts.alarms;
const mostEvents = 100;
const mostAlarms = 1000;

export function isUnacked(alarm: Alarm): boolean {
  return alarm.state === "unacked active" || alarm.state === "unacked returned";
}

export function StateOf(properties: { alarm: Alarm }): JSX.Element {
  const { alarm } = properties;
  const urgent = alarm.priority === "high" || alarm.priority === "critical";
  const kind = alarm.state === "normal" ? "good" : isUnacked(alarm) ? (urgent ? "bad" : "warning") : alarm.state === "acked active" ? "warning" : "plain";
  return (
    <>
      <Badge kind={kind}>{t.states[alarm.state] ?? alarm.state}</Badge>
      {alarm.until === undefined ? null : <small> {t.until(alarmTime(alarm.until))}</small>}
    </>
  );
}

function valueText(value: number | undefined): string {
  return value === undefined ? "" : String(Number(value.toPrecision(7)));
}

function Present(): JSX.Element {
  const [all, setAll] = useState(false);
  const polled = usePolled(() => plc.alarmsList({ all, most: mostAlarms }), 500);
  const [acknowledged, setAcknowledged] = useState<readonly string[]>([]);
  const [shown, setShown] = useState<Alarm>();
  const alarms = polled.answer?.alarms ?? [];
  const unacked = alarms.filter(isUnacked).map((alarm) => alarm.name);
  return (
    <Section
      title={t.present}
      actions={
        may("alarms.ack") ? (
          <button type="button" disabled={unacked.length === 0} onClick={() => setAcknowledged(unacked)}>
            {t.ackAll}
          </button>
        ) : null
      }
    >
      <div class="tools">
        <label class="check">
          <input type="checkbox" checked={all} onChange={(event) => { setAll(event.currentTarget.checked); setTimeout(polled.again, 0); }} /> {t.all}
        </label>
      </div>
      <ProblemBox problem={polled.problem} />
      {alarms.length < mostAlarms ? null : <p class="quiet-text">{t.cut(mostAlarms)}</p>}
      {polled.answer === undefined ? (
        <p>{texts.loading}</p>
      ) : alarms.length === 0 ? (
        <Empty>{polled.answer.all === 0 ? t.noAlarms : t.none}</Empty>
      ) : (
        <Table
          label={t.present}
          columns={[
            { title: t.state },
            { title: t.priority },
            { title: t.alarm },
            { title: t.value, class: "number" },
            { title: t.since },
            { title: t.by },
            { title: "", class: "end" },
          ]}
          rows={alarms.map((alarm) => ({
            key: alarm.name,
            cells: [
              <StateOf alarm={alarm} />,
              t.priorities[alarm.priority] ?? alarm.priority,
              <>
                <strong>{clipped(alarm.text, 200)}</strong> <span class="path quiet-text">{clipped(alarm.name, 120)}</span>
                {alarm.class === "" ? null : <small> {clipped(alarm.class, 60)}</small>}
                {alarm.order === undefined ? null : (
                  <>
                    {" "}
                    <Badge kind="plain">{t.order(clipped(alarm.group, 40), alarm.order)}</Badge>
                  </>
                )}
              </>,
              valueText(alarm.value),
              alarm.since === undefined ? "" : (
                <span class="number" title={alarm.scan === undefined ? undefined : t.scan(alarm.task ?? "", alarm.scan)}>
                  {alarmTime(alarm.since)}
                </span>
              ),
              <span title={alarm.comment === undefined ? undefined : clipped(alarm.comment, 500)}>{clipped(alarm.user ?? "", 64)}</span>,
              <span class="buttons">
                {isUnacked(alarm) && may("alarms.ack") ? (
                  <button type="button" class="small" aria-label={t.ackOne(alarm.name)} onClick={() => setAcknowledged([alarm.name])}>
                    {t.ack}
                  </button>
                ) : null}
                <button type="button" class="small quiet" aria-label={t.moreOf(alarm.name)} onClick={() => setShown(alarm)}>
                  {t.more}
                </button>
              </span>,
            ],
          }))}
        />
      )}
      {acknowledged.length === 0 ? null : (
        <AcknowledgeDialog names={acknowledged} onClose={() => setAcknowledged([])} onDone={polled.again} />
      )}
      {shown === undefined ? null : <AlarmDialog alarm={shown} onClose={() => setShown(undefined)} onDone={polled.again} />}
    </Section>
  );
}

function History(): JSX.Element {
  const [before, setBefore] = useState<number>();
  const [name, setName] = useState("");
  const names = usePolled(() => plc.alarmsList({ all: true }), 0).answer?.alarms.map((alarm) => alarm.name).sort() ?? [];
  const polled = usePolled(
    () => plc.alarmsHistory({ most: mostEvents, ...(before === undefined ? {} : { before }), ...(name === "" ? {} : { name }) }),
    before === undefined ? 1000 : 0,
  );
  const events: readonly AlarmEvent[] = polled.answer?.events ?? [];
  const last = events[events.length - 1]?.number;
  const go = (number: number | undefined): void => {
    setBefore(number);
    setTimeout(polled.again, 0);
  };
  return (
    <Section
      title={t.history}
      actions={
        <span class="buttons">
          <button type="button" disabled={before === undefined} onClick={() => go(undefined)}>
            {t.newest}
          </button>
          <button type="button" disabled={events.length < mostEvents || last === undefined} onClick={() => go(last)}>
            {t.older}
          </button>
        </span>
      }
    >
      <div class="tools">
        <Choice label={t.ofOne} value={name} options={["", ...names]} text={(one) => (one === "" ? t.ofAll : clipped(one, 60))}
          onChange={(one) => { setName(one); go(undefined); }} />
      </div>
      <ProblemBox problem={polled.problem} />
      {polled.answer === undefined ? (
        <p>{texts.loading}</p>
      ) : events.length === 0 ? (
        <Empty>{t.noHistory}</Empty>
      ) : (
        <Table
          label={t.history}
          columns={[{ title: t.when }, { title: t.what }, { title: t.alarm }, { title: t.value, class: "number" }, { title: t.by }, { title: t.comment }]}
          rows={events.map((event) => ({
            key: String(event.number),
            cells: [
              <span class="number" title={event.scan === undefined ? undefined : t.scan(event.task ?? "", event.scan)}>
                {event.time.replace("T", " ").replace(/Z$/, "")}
              </span>,
              t.happened[event.what] ?? event.what,
              <>
                {clipped(event.text, 200)} <span class="path quiet-text">{clipped(event.alarm, 120)}</span>
              </>,
              valueText(event.value),
              clipped(event.user ?? "", 64),
              <span class="path">{clipped(event.comment ?? "", 500)}</span>,
            ],
          }))}
        />
      )}
    </Section>
  );
}

export function AlarmsPage(): JSX.Element {
  return (
    <>
      <Present />
      <History />
    </>
  );
}
