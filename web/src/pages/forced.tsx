// The variables that are forced, with who did it and why.
import type { JSX } from "preact";
import { useForces } from "../forces";
import { may } from "../plc";
import { texts } from "../texts";
import { Badge, Empty, Section, Table } from "../ui/parts";
import { clipped } from "../values";

const t = texts.forces;
const timeOf = (utc: string): string => utc.replace("T", " ").replace(/\.\d+Z$/, "");

export function ForcedSection(): JSX.Element {
  const forces = useForces();
  return (
    <Section title={t.list} actions={forces.list.length === 0 ? null : <Badge kind="warning">{String(forces.list.length)}</Badge>}>
      {forces.list.length === 0 ? (
        <Empty>{t.none}</Empty>
      ) : (
        <Table
          label={t.list}
          columns={[
            { title: texts.variables.path },
            { title: t.value, class: "number" },
            { title: t.who },
            { title: t.reason },
            { title: t.until },
            { title: "", class: "end" },
          ]}
          rows={forces.list.map((force) => ({
            key: force.path,
            cells: [
              <span class="path">{clipped(force.path, 200)}</span>,
              <span title={force.yields ? t.yields : undefined}>{clipped(force.value, 100)}</span>,
              clipped(force.owner, 64),
              <span class="path">{clipped(force.reason, 500)}</span>,
              <span class="number">{force.until === undefined ? t.open : timeOf(force.until)}</span>,
              may("forces.release") ? (
                <button type="button" class="small" onClick={() => forces.release(force.path)}>
                  {texts.variables.release}
                </button>
              ) : null,
            ],
          }))}
        />
      )}
    </Section>
  );
}
