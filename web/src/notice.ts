// One short message at the edge of the page: that something is done, or why it is not.
import { signal } from "@preact/signals-core";

export interface Notice {
  text: string;
  kind: "good" | "warning";
}

export const notice = signal<Notice | undefined>(undefined);
let timer: ReturnType<typeof setTimeout> | undefined;

function show(text: string, kind: Notice["kind"]): void {
  notice.value = { text, kind };
  clearTimeout(timer);
  timer = setTimeout(() => {
    notice.value = undefined;
  }, 5000);
}

export function notify(text: string): void {
  show(text, "good");
}

export function warn(text: string): void {
  show(text, "warning");
}
