// A message of the log as a line.
import type { JSX } from "preact";
import { useState } from "preact/hooks";
import type { LogRecord } from "../../client/calls";
import { texts } from "../texts";
import { Badge } from "../ui/parts";
import { clipped } from "../values";

const t = texts.log;
const mostDetails = 20_000;

export function MessageLine(properties: { record: LogRecord }): JSX.Element {
  const { record } = properties;
  const [open, setOpen] = useState(false);
  const kind = record.severity === "error" ? "bad" : record.severity === "warning" ? "warning" : "plain";
  const more = record.details !== undefined || record.message.length > 400;
  return (
    <li class={`message ${record.severity}`}>
      <time class="number" dateTime={record.time}>
        {record.time.replace("T", " ").replace("Z", "")}
      </time>
      <Badge kind={kind}>{t.severities[record.severity] ?? record.severity}</Badge>
      <span class="message-source">{clipped(record.source ?? t.plcRun, 60)}</span>
      <span class="message-text">
        {clipped(record.message)}
        {record.task === undefined ? null : (
          <small class="number">{record.scan === undefined ? clipped(record.task, 60) : t.scan(clipped(record.task, 60), record.scan)}</small>
        )}
        {record.code === undefined ? null : <code>{texts.explain(record.code)}</code>}
        {more ? (
          <button type="button" class="quiet small" aria-expanded={open} onClick={() => setOpen(!open)}>
            {open ? texts.less : texts.more}
          </button>
        ) : null}
        {open ? <pre>{clipped(`${record.message}\n${record.details ?? ""}`, mostDetails)}</pre> : null}
      </span>
    </li>
  );
}
