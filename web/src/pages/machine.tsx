// Devices and what their values are worth, who asks over Modbus, what memory and disk have to spare.
import type { JSX } from "preact";
import { plc, usePolled } from "../plc";
import { texts } from "../texts";
import { Badge, Empty, Facts, ProblemBox, Section, Table } from "../ui/parts";
import { bytesText, clipped, timeText } from "../values";

const t = texts.overview;

export function MachineSection(): JSX.Element {
  const { answer, problem } = usePolled(() => plc.machine(), 2000);
  return (
    <Section title={t.resources}>
      <ProblemBox problem={problem} />
      {answer === undefined ? (
        <p>{texts.loading}</p>
      ) : (
        <>
          <Facts
            rows={[
              ...(answer.modbus.length === 0
                ? [[t.modbusOff, t.off] as const]
                : answer.modbus.map((one) => [t.modbus(one.line), t.clients(one.clients, one.requests, one.exceptions)] as const)),
              [t.ram, <span class="number">{t.ramOf(bytesText(answer.memory), bytesText(answer.memory_free), bytesText(answer.memory_all))}</span>],
              [t.disk, <span class="number">{t.diskOf(bytesText(answer.disk_free), bytesText(answer.disk_all))}</span>],
            ]}
          />
          {answer.drivers.length === 0 ? (
            <Empty>{t.noDrivers}</Empty>
          ) : (
            <Table
              label={t.drivers}
              columns={[
                { title: t.driver },
                { title: t.quality },
                { title: t.inputs, class: "number" },
                { title: t.oldest, class: "number" },
                { title: t.losses, class: "number" },
                { title: t.exchanges, class: "number" },
              ]}
              rows={answer.drivers.map((driver) => ({
                key: driver.name,
                cells: [
                  <span class="path">{clipped(driver.name, 60)}</span>,
                  <>
                    <Badge kind={driver.state === "good" ? "good" : driver.state === "lost" ? "bad" : "plain"}>{t.qualities[driver.state] ?? driver.state}</Badge>{" "}
                    {clipped(driver.problem, 200)}
                  </>,
                  driver.inputs === 0 ? "" : t.goodOf(driver.inputs_good, driver.inputs),
                  driver.inputs === 0 ? "" : timeText(driver.oldest_ms * 1e6),
                  driver.losses.toLocaleString("en"),
                  driver.exchanges.toLocaleString("en"),
                ],
              }))}
            />
          )}
        </>
      )}
    </Section>
  );
}
