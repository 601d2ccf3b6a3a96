// What a browser keeps: choices and watch lists, by name. Without storage they last as long as the page.
const inPage = new Map<string, string>();

export function kept<T>(name: string, otherwise: T, isGood: (value: unknown) => value is T): T {
  let text = inPage.get(name) ?? null;
  try {
    text ??= localStorage.getItem(`picard.${name}`);
  } catch {
    // Storage is forbidden.
  }
  if (text === null) return otherwise;
  try {
    const value: unknown = JSON.parse(text);
    return isGood(value) ? value : otherwise;
  } catch {
    return otherwise;
  }
}

export function keep(name: string, value: unknown): void {
  const text = JSON.stringify(value);
  inPage.set(name, text);
  try {
    localStorage.setItem(`picard.${name}`, text);
  } catch {
    // Full or forbidden.
  }
}

export const isNumber = (value: unknown): value is number => typeof value === "number" && Number.isFinite(value);
export const isText = (value: unknown): value is string => typeof value === "string";
export const isTexts = (value: unknown): value is string[] => Array.isArray(value) && value.every(isText);
