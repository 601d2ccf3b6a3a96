// How the plant is: state, tasks and what they need, what went wrong.
import type { JSX } from "preact";
import type { Event as InstructionEvent, Task, TaskHistograms, Times } from "../../client/calls";
import { connected, plc, usePolled } from "../plc";
import { link } from "../route";
import { useSignal } from "../signals";
import { texts } from "../texts";
import { Badge, Empty, Facts, ProblemBox, Section, Table } from "../ui/parts";
import { ageText, clipped, timeText } from "../values";
import { ForcedSection } from "./forced";
import { MachineSection } from "./machine";
import { Histogram } from "./histogram";
import { MessageLine } from "./message";

const t = texts.overview;

function StateBadge(properties: { state: string }): JSX.Element {
  const { state } = properties;
  if (!useSignal(connected)) return <Badge kind="plain">{t.unknown}</Badge>;
  const kind = state === "runs" ? "good" : state === "stopped" ? "bad" : state === "faulted" ? "warning" : "plain";
  return <Badge kind={kind}>{texts.states[state] ?? state}</Badge>;
}

/** From 100 ns to 10 s, by powers of ten. */
const decades = { from: 2, to: 10 };
function placeOf(ns: number): number {
  const log = Math.log10(Math.max(ns, 1));
  return Math.max(0, Math.min(100, ((log - decades.from) / (decades.to - decades.from)) * 100));
}

function TimesStrip(properties: { name: string; times: Times }): JSX.Element {
  const { times } = properties;
  if (times.count === 0) return <span class="quiet-text">{t.noScan}</span>;
  const least = placeOf(times.min_ns);
  const half = placeOf(times.p50_ns);
  const p99 = placeOf(times.p99_ns);
  const p999 = placeOf(times.p99_9_ns);
  const most = placeOf(times.max_ns);
  const words = [times.p50_ns, times.p99_ns, times.p99_9_ns, times.max_ns].map(timeText) as [string, string, string, string];
  return (
    <div class="times">
      <svg viewBox="0 0 100 12" preserveAspectRatio="none" role="img" aria-label={t.quantiles(properties.name, ...words)}>
        {[1, 2, 3, 4, 5, 6, 7].map((decade) => (
          <line key={decade} class="grid" x1={decade * 12.5} x2={decade * 12.5} y1="0" y2="12" />
        ))}
        <line class="whole" x1={least} x2={most} y1="6" y2="6" />
        <rect class="most" x={half} width={Math.max(0.8, p99 - half)} y="2" height="8" />
        <line class="tail" x1={p999} x2={p999} y1="1" y2="11" />
      </svg>
      <span class="number">
        {words[0]} <span class="quiet-text">/</span> {words[1]} <span class="quiet-text">/</span> {words[3]}
      </span>
    </div>
  );
}

function TaskCard(properties: { task: Task; histograms: TaskHistograms | undefined }): JSX.Element {
  const { task, histograms } = properties;
  const period = task.period_ns !== 0 ? timeText(task.period_ns) : task.trigger !== "" ? t.onEdge(clipped(task.trigger, 60)) : t.free;
  const bad = (n: number): JSX.Element => <span class={n === 0 ? "number" : "number warns"}>{n.toLocaleString("en")}</span>;
  return (
    <article class="task" aria-label={`${t.task} ${clipped(task.name, 60)}`}>
      <div class="card-head">
        <h3 class="path">{clipped(task.name, 60)}</h3>
        <StateBadge state={task.state} />
      </div>
      <Facts
        rows={[
          [t.period, <span class="number">{period}</span>],
          [t.priority, <span class="number">{task.priority}</span>],
          [t.engine, task.engine],
          [t.scans, <span class="number">{task.scans.toLocaleString("en")}</span>],
          [t.overruns, bad(task.overruns)],
          [t.missed, bad(task.missed)],
          [t.faults, bad(task.faults)],
        ]}
      />
      <Facts
        rows={[
          [t.latency, <TimesStrip name={t.latency} times={task.latency} />],
          [t.scan, <TimesStrip name={t.scan} times={task.scan} />],
          [t.response, <TimesStrip name={t.response} times={task.response} />],
        ]}
      />
      {histograms === undefined ? null : (
        <div class="histograms">
          <Histogram title={t.latency} bars={histograms.latency} />
          <Histogram title={t.scan} bars={histograms.scan} />
        </div>
      )}
    </article>
  );
}

function placeText(event: InstructionEvent): string {
  const place = event.line === 0 ? "" : `${event.file}:${event.line}`;
  return [event.pou, event.element, place].filter((part) => part !== "").join(", ");
}

export function OverviewPage(): JSX.Element {
  const target = usePolled(() => plc.target(), 1000);
  const tasks = usePolled(() => plc.tasks(), 1000);
  const histograms = usePolled(() => plc.tasksHistograms(), 2000);
  const program = usePolled(() => plc.program(), 0);
  const events = usePolled(() => plc.events(), 2000);
  const messages = usePolled(() => plc.log({ least: "warning", most: 5 }), 2000);
  const now = target.answer;
  const runs = program.answer;
  return (
    <>
      <ProblemBox problem={target.problem ?? tasks.problem} />
      <div class="columns">
        <Section title={t.plant} actions={now === undefined ? null : <StateBadge state={now.state} />}>
          {now === undefined ? (
            <p>{texts.loading}</p>
          ) : (
            <>
              <Facts
                rows={[
                  [t.plant, <span class="path">{clipped(now.plant, 100)}</span>],
                  [t.uptime, <span class="number">{ageText(now.uptime_ms)}</span>],
                  [t.time, <span class="number">{now.time.replace("T", " ").replace(/\.\d+/, "")}</span>],
                  [t.machine, clipped(now.machine, 100)],
                  [t.system, `${now.system}, ${now.processor}`],
                  [texts.product, now.product],
                  [t.realtime, now.realtime_priority ? t.yes : <Badge kind="warning">{t.no}</Badge>],
                  [t.memory, now.memory_locked ? t.yes : <Badge kind="warning">{t.no}</Badge>],
                ]}
              />
              {now.refused.length === 0 ? null : (
                <details>
                  <summary>{t.refused}</summary>
                  <ul>
                    {now.refused.map((sentence) => (
                      <li key={sentence}>{clipped(sentence)}</li>
                    ))}
                  </ul>
                </details>
              )}
            </>
          )}
        </Section>
        <Section title={t.program}>
          {runs === undefined ? (
            <p>{texts.loading}</p>
          ) : (
            <Facts
              rows={[
                [t.project, <span class="path">{clipped(runs.project, 200)}</span>],
                [t.compiler, clipped(runs.compiler, 100)],
                [t.options, clipped(runs.options, 300)],
                [t.image, <code title={runs.image}>{runs.image.slice(0, 16)}</code>],
              ]}
            />
          )}
        </Section>
      </div>
      <Section title={t.tasks}>
        <p class="quiet-text">{t.times}</p>
        <div class="tasks">{tasks.answer?.tasks.map((task, i) => <TaskCard key={task.name} task={task} histograms={histograms.answer?.tasks[i]} />) ?? <p>{texts.loading}</p>}</div>
      </Section>
      <MachineSection />
      <ForcedSection />
      <div class="columns">
        <Section
          title={t.messages}
          actions={
            <a class="button quiet" href={link("log")}>
              {t.allMessages}
            </a>
          }
        >
          {messages.answer === undefined ? (
            <p>{texts.loading}</p>
          ) : messages.answer.records.length === 0 ? (
            <Empty>{t.noMessages}</Empty>
          ) : (
            <ol class="messages">
              {messages.answer.records
                .slice()
                .reverse()
                .map((record) => (
                  <MessageLine key={record.number} record={record} />
                ))}
            </ol>
          )}
        </Section>
        <Section title={t.events}>
          {events.answer === undefined ? (
            <p>{texts.loading}</p>
          ) : events.answer.events.length === 0 ? (
            <Empty>{t.noEvents}</Empty>
          ) : (
            <Table
              label={t.events}
              columns={[{ title: t.event }, { title: t.place }, { title: t.task }, { title: t.howOften, class: "number" }]}
              rows={events.answer.events.slice(0, 100).map((event, i) => ({
                key: String(i),
                cells: [
                  event.event,
                  <span class="path">{clipped(placeText(event), 200)}</span>,
                  <span class="path">{clipped(event.task, 60)}</span>,
                  event.count.toLocaleString("en"),
                ],
              }))}
            />
          )}
          {(events.answer?.others ?? 0) === 0 ? null : <p>{t.others(events.answer?.others ?? 0)}</p>}
        </Section>
      </div>
    </>
  );
}
