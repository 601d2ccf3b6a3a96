// States of something that is edited: back and forth again.
import { useState } from "preact/hooks";

const mostSteps = 200;

export interface History<T> {
  value: T;
  /** A step that can be undone. With `step`: those with the same one, right after each other, are one. */
  set: (value: T, step?: string) => void;
  undo: () => void;
  redo: () => void;
  canUndo: boolean;
  canRedo: boolean;
  /** Whether it is something else than at the beginning, or than what was saved last. */
  changed: boolean;
  saved: (value: T) => void;
}

interface State<T> {
  past: readonly T[];
  value: T;
  future: readonly T[];
  kept: T;
  step: string;
}

/** `now`: what it is already, where it has been edited before. */
export function useHistory<T>(first: T, now: T = first): History<T> {
  const [state, setState] = useState<State<T>>({ past: now === first ? [] : [first], value: now, future: [], kept: first, step: "" });
  return {
    value: state.value,
    set: (value, step = "") =>
      setState((before) => {
        const same = step !== "" && step === before.step;
        return { ...before, past: same ? before.past : [...before.past, before.value].slice(-mostSteps), value, future: [], step };
      }),
    undo: () =>
      setState((before) => {
        const value = before.past[before.past.length - 1];
        if (value === undefined) return before;
        return { ...before, past: before.past.slice(0, -1), value, future: [before.value, ...before.future], step: "" };
      }),
    redo: () =>
      setState((before) => {
        const value = before.future[0];
        if (value === undefined) return before;
        return { ...before, past: [...before.past, before.value], value, future: before.future.slice(1), step: "" };
      }),
    canUndo: state.past.length !== 0,
    canRedo: state.future.length !== 0,
    changed: state.value !== state.kept,
    saved: (value) => setState((before) => ({ ...before, kept: value, step: "" })),
  };
}
