// Light or dark: as the system says, unless somebody has chosen.
import { signal } from "@preact/signals-core";
import { keep, kept } from "./kept";

export const themes = ["auto", "light", "dark"] as const;
export type Theme = (typeof themes)[number];
const isTheme = (value: unknown): value is Theme => themes.some((theme) => theme === value);

export const theme = signal<Theme>(kept("theme", "auto", isTheme));
/** Counts changes of the colours that are shown, for what is painted by code. */
export const colours = signal(0);

export function setTheme(chosen: Theme): void {
  theme.value = chosen;
  keep("theme", chosen);
}

const systemIsDark = matchMedia("(prefers-color-scheme: dark)");

function show(): void {
  const dark = theme.peek() === "auto" ? systemIsDark.matches : theme.peek() === "dark";
  document.documentElement.dataset["theme"] = dark ? "dark" : "light";
  ++colours.value;
}

theme.subscribe(show);
systemIsDark.addEventListener("change", show);

/** A colour of the style sheet. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
