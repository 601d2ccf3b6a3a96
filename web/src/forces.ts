// What is forced, for pages that show it.
import type { Force } from "../client/calls";
import { notify, warn } from "./notice";
import { ask, plc, problemOf, usePolled } from "./plc";
import { texts } from "./texts";

export interface Forces {
  list: readonly Force[];
  of: (path: string) => Force | undefined;
  release: (path: string) => void;
  again: () => void;
}

export function useForces(): Forces {
  const polled = usePolled(() => plc.forcesList(), 1000);
  const list = polled.answer?.forces ?? [];
  return {
    list,
    // Names do not differ by case.
    of: (path) => list.find((force) => force.path.toUpperCase() === path.toUpperCase()),
    release: (path) => {
      ask(() => plc.forcesRelease({ path })).then(
        () => {
          notify(texts.forces.released(path));
          polled.again();
        },
        (error: unknown) => warn(problemOf(error).text),
      );
    },
    again: polled.again,
  };
}
