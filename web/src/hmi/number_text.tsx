// An entry of a number, or of a duration in seconds. What is neither is told where it is entered, and changes nothing.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { texts } from "../texts";
import { clipped, isTooLarge, plainNumberOf, secondsOf } from "../values";

const t = texts.hmi.editor;

/** `durations`: whether a text like T#2m counts, as so many seconds; of an element whose variable is not known it does. */
export function NumberText(properties: { id: string; value: number | undefined; durations: boolean; onInput: (value: number | undefined) => void }): JSX.Element {
  const { id, value, durations, onInput } = properties;
  const [entered, setEntered] = useState<string>();
  const [refused, setRefused] = useState(false);
  const before = useRef(value);
  /** What it has made of what was entered, the last that came back first: whoever types fast is ahead of it. */
  const given = useRef([value]);
  useEffect(() => {
    const at = given.current.lastIndexOf(value);
    // Somebody else has changed the value, as a step back does: what was entered is not of this one.
    if (at < 0) setEntered(undefined);
    given.current = at < 0 ? [value] : given.current.slice(at);
  }, [value]);
  const parsed = (text: string): number | undefined | null => {
    if (text.trim() === "") return undefined;
    return isTooLarge(text) ? null : (plainNumberOf(text) ?? (durations ? secondsOf(text) : null));
  };
  const isWrong = entered !== undefined && parsed(entered) === null;
  const why = (text: string): string => (isTooLarge(text) ? t.tooLarge(clipped(text, 40)) : durations ? t.noSeconds(clipped(text, 40)) : t.noNumber(clipped(text, 40)));
  const type = (text: string): void => {
    setEntered(text);
    setRefused(false);
    const number = parsed(text);
    // WHY: 1, on the way to 1m3x, is not what somebody meant.
    const made = number === null ? before.current : number;
    given.current.push(made);
    onInput(made);
  };
  const leave = (): void => {
    setRefused(isWrong);
    if (!isWrong) setEntered(undefined);
  };
  return (
    <>
      <input
        id={id}
        value={entered ?? (value === undefined ? "" : String(value))}
        autoComplete="off"
        spellcheck={false}
        aria-invalid={refused && isWrong}
        aria-describedby={`${id}-refused`}
        onFocus={() => {
          before.current = value;
        }}
        onInput={(event) => type(event.currentTarget.value)}
        onChange={() => setRefused(isWrong)}
        onBlur={leave}
      />
      <small id={`${id}-refused`} class="refused" role="alert">
        {refused && isWrong ? why(entered) : null}
      </small>
    </>
  );
}
