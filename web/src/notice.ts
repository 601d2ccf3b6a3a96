// One short message at the edge of the page: that something is done.
import { signal } from "@preact/signals-core";

export const notice = signal("");
let timer: ReturnType<typeof setTimeout> | undefined;

export function notify(text: string): void {
  notice.value = text;
  clearTimeout(timer);
  timer = setTimeout(() => {
    notice.value = "";
  }, 5000);
}
