// Which page is shown: the hash of the address, "#/trends?path=Level". The way back is the browser's.
import { signal } from "@preact/signals-core";

export interface Route {
  page: string;
  parameters: URLSearchParams;
}

function read(): Route {
  const [page = "", query = ""] = location.hash.replace(/^#\/?/, "").split("?", 2);
  return { page: page === "" ? "overview" : page, parameters: new URLSearchParams(query) };
}

export const route = signal<Route>(read());
addEventListener("hashchange", () => {
  route.value = read();
});

export function link(page: string, parameters: Record<string, string> = {}): string {
  const query = new URLSearchParams(parameters).toString();
  return `#/${page}${query === "" ? "" : `?${query}`}`;
}
