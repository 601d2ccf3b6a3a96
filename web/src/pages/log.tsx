// The log as it comes, of what kind and from whom one wants.
import type { JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { LogRecord } from "../../client/calls";
import { ask, onLinkLost, plc, problemOf, type Problem } from "../plc";
import { texts } from "../texts";
import { Choice, Empty, Field, ProblemBox, Section } from "../ui/parts";
import { MessageLine } from "./message";

const t = texts.log;
const levels = ["note", "warning", "error"] as const;
type Level = (typeof levels)[number];
/** Messages that the page keeps, and those that it shows. */
const mostKept = 5000;
const mostShown = 1000;

interface Kept {
  records: LogRecord[];
  missed: number;
}

/** The messages so far, then those that come. */
function useMessages(): Kept & { problem: Problem | undefined } {
  const [kept, setKept] = useState<Kept>({ records: [], missed: 0 });
  const [problem, setProblem] = useState<Problem>();
  useEffect(() => {
    let socket: WebSocket | undefined;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let ended = false;
    let wait = 500;
    let last = 0;
    let waiting: LogRecord[] = [];
    let missed = 0;
    // WHY together: a thousand messages a second are one drawing.
    const flush = (): void => {
      timer = undefined;
      const fresh = waiting;
      const lost = missed;
      waiting = [];
      missed = 0;
      setKept((before) => ({ records: [...before.records, ...fresh].slice(-mostKept), missed: before.missed + lost }));
    };
    const follow = (): void => {
      socket = plc.logStream({ after: last });
      socket.onopen = () => {
        wait = 500;
        setProblem(undefined);
      };
      socket.onmessage = (event: MessageEvent<string>) => {
        const record = JSON.parse(event.data) as LogRecord & { missed?: number };
        if (record.missed !== undefined) {
          missed += record.missed;
        } else {
          last = record.number;
          waiting.push(record);
        }
        timer ??= setTimeout(flush, 100);
      };
      socket.onclose = again;
    };
    const again = (): void => {
      if (ended) return;
      setTimeout(() => {
        if (!ended) void begin();
      }, wait);
      wait = Math.min(wait * 2, 8000);
    };
    const begin = async (): Promise<void> => {
      try {
        const answer = await ask(() => plc.log({ most: 1000 }));
        if (ended) return;
        last = answer.last;
        waiting = [];
        setKept({ records: answer.records, missed: 0 });
        follow();
      } catch (error) {
        if (ended) return;
        setProblem(problemOf(error));
        again();
      }
    };
    void begin();
    const forgetLink = onLinkLost(() => {
      if (socket === undefined) return;
      socket.onopen = socket.onmessage = socket.onclose = null;
      socket.close();
      socket = undefined;
      again();
    });
    return () => {
      ended = true;
      forgetLink();
      clearTimeout(timer);
      socket?.close();
    };
  }, []);
  return { ...kept, problem };
}

export function LogPage(): JSX.Element {
  const { records, missed, problem } = useMessages();
  const [level, setLevel] = useState<Level>("note");
  const [source, setSource] = useState("");
  const [text, setText] = useState("");
  const [follows, setFollows] = useState(true);
  const [shownRecords, setShownRecords] = useState<LogRecord[]>([]);
  const list = useRef<HTMLOListElement>(null);
  useEffect(() => {
    if (follows) setShownRecords(records);
  }, [records, follows]);
  const sources = useMemo(() => ["", ...new Set(shownRecords.map((record) => record.source ?? t.plcRun))].sort(), [shownRecords]);
  const matching = useMemo(() => {
    const words = text.toLowerCase();
    return shownRecords.filter(
      (record) =>
        levels.indexOf(record.severity as Level) >= levels.indexOf(level) &&
        (source === "" || (record.source ?? t.plcRun) === source) &&
        (words === "" || `${record.message} ${record.task ?? ""} ${record.code ?? ""}`.toLowerCase().includes(words)),
    );
  }, [shownRecords, level, source, text]);
  const shown = matching.slice(-mostShown);
  useEffect(() => {
    const element = list.current;
    if (follows && element !== null) element.scrollTop = element.scrollHeight;
  }, [shown.length, matching[matching.length - 1]?.number, follows]);
  return (
    <Section title={t.shown(shown.length, records.length)} class="fill">
      <div class="tools">
        <Choice label={t.level} value={level} options={levels} text={(one) => t.levels[one] ?? one} onChange={setLevel} />
        <Choice label={t.source} value={source} options={sources} text={(one) => (one === "" ? t.allSources : one)} onChange={setSource} />
        <Field label={t.text} class="inline">
          {(id) => <input id={id} type="search" value={text} onInput={(event) => setText(event.currentTarget.value)} />}
        </Field>
        <label class="check">
          <input type="checkbox" checked={follows} onChange={(event) => setFollows(event.currentTarget.checked)} /> {t.follow}
        </label>
      </div>
      <ProblemBox problem={problem} />
      {missed === 0 ? null : <p class="strip warning">{t.missed(missed)}</p>}
      {shown.length === 0 ? (
        <Empty>{t.empty}</Empty>
      ) : (
        <ol class="messages scrolled" ref={list} tabIndex={0} aria-label={texts.pages.log}>
          {shown.map((record) => (
            <MessageLine key={record.number} record={record} />
          ))}
        </ol>
      )}
    </Section>
  );
}
