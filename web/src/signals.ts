// Signals in components: a component that reads one is drawn again when it changes.
import type { ReadonlySignal } from "@preact/signals-core";
import { useEffect, useState } from "preact/hooks";

export function useSignal<T>(signal: ReadonlySignal<T>): T {
  const [, set] = useState<T>(() => signal.peek());
  useEffect(() => signal.subscribe((value) => set(() => value)), [signal]);
  return signal.peek();
}
