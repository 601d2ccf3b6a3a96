// What elements write: as the pages offer it, one call after the other.
import { useEffect, useRef } from "preact/hooks";
import type { Value } from "../../client/connection";
import { machineTime } from "../live";
import { warn } from "../notice";
import { ask, plc, problemOf } from "../plc";
import { texts } from "../texts";

/** How often a button says that it is still held. */
const renewMs = 1000;
/** How long a press or a value may be on its way. WHY: over a line that stood still it would come when nobody expects it any more. */
const lateMs = 2000;

/** Until when what is said now may come, by the clock of the machine; nothing while that is not known. */
function untilMs(): { until_ms?: number } {
  const now = machineTime();
  return now === undefined ? {} : { until_ms: Math.round(now * 1000) + lateMs };
}

function complain(error: unknown): void {
  warn(problemOf(error).text);
}

export async function writeOffered(path: string, value: Value): Promise<void> {
  try {
    const { written } = await ask(() => plc.valuesWrite({ values: [{ path, value }], offered: true, ...untilMs() }));
    if (written === 0) warn(texts.hmi.writtenTooLate);
  } catch (error) {
    complain(error);
  }
}

/** Writes the newest value; those that come while one is on its way are left out, but for the last. */
export function useNewestWrite(path: string): (value: Value) => void {
  const waiting = useRef<{ value: Value } | undefined>(undefined);
  const busy = useRef(false);
  return (value) => {
    waiting.current = { value };
    if (busy.current) return;
    busy.current = true;
    void (async () => {
      while (waiting.current !== undefined) {
        const next = waiting.current.value;
        waiting.current = undefined;
        await writeOffered(path, next);
      }
      busy.current = false;
    })();
  };
}

/** A button that is held: from `down` to `up`. */
export function useHold(path: string): { down: () => void; up: () => void } {
  const timer = useRef<ReturnType<typeof setInterval> | undefined>(undefined);
  // WHY one after the other: a release that overtakes its press would be none.
  const last = useRef<Promise<void>>(Promise.resolve());
  const say = (change: { pressed: boolean; renews?: boolean }): Promise<void> => {
    const until = change.pressed ? untilMs() : {};
    last.current = last.current.then(async () => {
      try {
        const answer = await ask(() => plc.pagesPress({ path, ...change, ...until }));
        if (change.pressed && !answer.held && timer.current !== undefined) {
          clearInterval(timer.current);
          timer.current = undefined;
          warn(change.renews === true ? texts.hmi.letGo : texts.hmi.tooLate);
        }
      } catch (error) {
        complain(error);
      }
    });
    return last.current;
  };
  const up = (): void => {
    if (timer.current === undefined) return;
    clearInterval(timer.current);
    timer.current = undefined;
    void say({ pressed: false });
  };
  const down = (): void => {
    if (timer.current !== undefined) return;
    void say({ pressed: true });
    let renewing = false;
    timer.current = setInterval(() => {
      if (renewing) return;
      renewing = true;
      void say({ pressed: true, renews: true }).finally(() => (renewing = false));
    }, renewMs);
  };
  const latest = useRef(up);
  latest.current = up;
  useEffect(() => {
    const leave = (): void => latest.current();
    addEventListener("blur", leave);
    document.addEventListener("visibilitychange", leave);
    return () => {
      removeEventListener("blur", leave);
      document.removeEventListener("visibilitychange", leave);
      leave();
    };
  }, []);
  return { down, up };
}
