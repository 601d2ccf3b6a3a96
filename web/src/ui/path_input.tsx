// A field for the path of a variable, which offers those that match.
import type { JSX } from "preact";
import { useEffect, useId, useState } from "preact/hooks";
import { ask, plc } from "../plc";

const mostOffered = 20;

export function PathInput(properties: { id: string; value: string; placeholder?: string; onInput: (path: string) => void }): JSX.Element {
  const { value } = properties;
  const [offered, setOffered] = useState<string[]>([]);
  const list = useId();
  useEffect(() => {
    if (value.trim() === "") {
      setOffered([]);
      return undefined;
    }
    let outdated = false;
    const timer = setTimeout(() => {
      ask(() => plc.valuesSearch({ pattern: `*${value.trim()}*`, most: 200 })).then(
        (found) => outdated || setOffered(found.nodes.filter((node) => node.readable === true).slice(0, mostOffered).map((node) => node.path)),
        () => {},
      );
    }, 150);
    return () => {
      outdated = true;
      clearTimeout(timer);
    };
  }, [value]);
  return (
    <>
      <input id={properties.id} list={list} value={value} placeholder={properties.placeholder} maxLength={500} autoComplete="off" spellcheck={false}
        onInput={(event) => properties.onInput(event.currentTarget.value)} />
      <datalist id={list}>
        {offered.map((path) => (
          <option key={path} value={path} />
        ))}
      </datalist>
    </>
  );
}
