// The PLC that serves the pages: calls, who is logged in, whether it answers.
import { signal } from "@preact/signals-core";
import { useEffect, useRef, useState } from "preact/hooks";
import { Plc, rights, type SessionAnswer } from "../client/calls";
import { PicardError } from "../client/connection";
import { texts } from "./texts";

export { PicardError };
export type Session = SessionAnswer;

/** Longest time of a call. */
const patienceMs = 30_000;
/** Of one that the server answers at once: without an answer the connection counts as lost. */
const linkPatienceMs = 5000;

export const plc = new Plc("", undefined, patienceMs);
const link = new Plc("", undefined, linkPatienceMs);
/** Undefined until the server was asked; null: nobody is logged in. */
export const session = signal<Session | null | undefined>(undefined);
/** Why nobody is, where that is worth saying. */
export const sessionEnd = signal("");
/** Nobody can log in: the first user is still to be made. */
export const needsFirstUser = signal(false);
/** Whether the latest attempt reached the server. */
export const connected = signal(true);

const roles = ["anybody", "viewer", "operator", "engineer", "admin"];

export function hasRole(needed: string): boolean {
  const role = session.peek()?.role ?? "anybody";
  return roles.indexOf(role) >= roles.indexOf(needed);
}

/** Whether the caller may make this call, as its row says. */
export function may(call: keyof typeof rights): boolean {
  return hasRole(rights[call]);
}

/** What was refused, for people. */
export interface Problem {
  text: string;
  code: string;
  help: string;
  /** What was wrong in the request: "values[2].path". */
  field?: string | undefined;
}

export function problemOf(error: unknown): Problem {
  if (error instanceof PicardError) return { text: error.text, code: error.code, help: error.help ?? "", field: error.field };
  if (error instanceof TypeError) return { text: texts.link.lost, code: "", help: "" };
  return { text: String(error), code: "", help: "" };
}

/** Makes a call, and notes what its failure says about session and connection. */
export async function ask<T>(call: () => Promise<T>): Promise<T> {
  try {
    const answer = await call();
    connected.value = true;
    return answer;
  } catch (error) {
    if (error instanceof PicardError) {
      connected.value = true;
      if (error.status === 401 && error.code === "P7710") {
        if (session.peek()) sessionEnd.value = texts.login.ended;
        needsFirstUser.value = error.help?.includes("/api/first-user") ?? false;
        session.value = null;
      }
    } else if (error instanceof TypeError) {
      // What fetch throws when nobody answers.
      connected.value = false;
    }
    throw error;
  }
}

/** Finds out whether it is the session or the connection that has ended. */
export function checkLink(): void {
  void ask(() => link.session()).catch(() => {});
}

/** The image that runs, as it was told last. */
let image: string | undefined;
/** How often another program was found to run: what a page knows of names, drawings and places is of the one before. */
export const programs = signal(0);

/** Finds out whether another program runs by now. */
export async function checkProgram(): Promise<void> {
  const now = (await ask(() => link.session())).image;
  if (image !== undefined && image !== now) ++programs.value;
  image = now;
}

/** Asks who is logged in, until the server answers. */
export async function findSession(): Promise<void> {
  for (let wait = 500; ; wait = Math.min(wait * 2, 8000)) {
    try {
      session.value = await ask(() => link.session());
      return;
    } catch (error) {
      if (error instanceof PicardError && session.peek() === null) return;
      await new Promise((resolve) => setTimeout(resolve, wait));
    }
  }
}

/**
 * Looks every 2 s, while the page is seen, whether the server answers. WHY: a cable that is pulled ends no connection; what
 * a stream told last would look live for minutes.
 */
export function watchLink(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let ended = false;
  const look = async (): Promise<void> => {
    if (!document.hidden) await checkProgram().catch(() => {});
    if (!ended) timer = setTimeout(() => void look(), 2000);
  };
  void look();
  return () => {
    ended = true;
    clearTimeout(timer);
  };
}

/** Calls `lost` each time the connection is found to be lost, until the returned function is called. */
export function onLinkLost(lost: () => void): () => void {
  return connected.subscribe((is) => {
    if (!is) lost();
  });
}

/** The latest answer of a call that is made again and again while the page is seen. */
export function usePolled<T>(call: () => Promise<T>, periodMs: number): { answer: T | undefined; problem: Problem | undefined; again: () => void } {
  const [state, setState] = useState<{ answer: T | undefined; problem: Problem | undefined }>({ answer: undefined, problem: undefined });
  const latest = useRef(call);
  latest.current = call;
  const now = useRef(() => {});
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let ended = false;
    const run = async (): Promise<void> => {
      clearTimeout(timer);
      if (!document.hidden) {
        try {
          const answer = await ask(() => latest.current());
          if (!ended) setState({ answer, problem: undefined });
        } catch (error) {
          // That nobody answers is said above all pages.
          const problem = error instanceof TypeError ? undefined : problemOf(error);
          if (!ended) setState((before) => ({ answer: before.answer, problem }));
        }
      }
      if (!ended && periodMs > 0) timer = setTimeout(() => void run(), periodMs);
    };
    now.current = () => void run();
    void run();
    return () => {
      ended = true;
      clearTimeout(timer);
    };
  }, [periodMs]);
  return { ...state, again: () => now.current() };
}
