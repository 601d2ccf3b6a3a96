// The frame around the pages: navigation, who is logged in, whether the PLC answers.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { AlarmBanner } from "./alarm_banner";
import { notice, notify } from "./notice";
import { LoginPage } from "./pages/login";
import { AccountDialog } from "./pages/account";
import { pages, type Page } from "./pages/pages";
import { ask, connected, findSession, hasRole, plc, programs, session, watchLink } from "./plc";
import { link, route } from "./route";
import { useSignal } from "./signals";
import { texts } from "./texts";
import { setTheme, theme, themes } from "./theme";
import { Choice } from "./ui/parts";
import { clipped } from "./values";

function ThemeChoice(): JSX.Element {
  const chosen = useSignal(theme);
  return <Choice label={texts.theme.label} value={chosen} options={themes} text={(one) => texts.theme[one]} onChange={setTheme} />;
}

function Refused(properties: { text: string }): JSX.Element {
  return (
    <div class="card centred">
      <p>{properties.text}</p>
      <a class="button" href={link("overview")}>
        {texts.refused.home}
      </a>
    </div>
  );
}

/** `begun`: with another one the page begins anew. */
function contents(page: Page | undefined, begun: number): JSX.Element {
  if (page === undefined) return <Refused text={texts.refused.unknown} />;
  if (!hasRole(page.right)) {
    const role = session.peek()?.role ?? "";
    return <Refused text={texts.refused.role(texts.roles[page.right] ?? page.right, texts.roles[role] ?? role)} />;
  }
  const Contents = page.contents;
  return <Contents key={begun} />;
}

/** "#/log" of where one is; the hash itself belongs to the pages. */
function toContents(event: Event): void {
  event.preventDefault();
  document.getElementById("contents")?.focus();
}

function Shell(): JSX.Element {
  const { page: name } = useSignal(route);
  const who = useSignal(session);
  const reached = useSignal(connected);
  const said = useSignal(notice);
  const [account, setAccount] = useState(false);
  const [menu, setMenu] = useState(false);
  const [plant, setPlant] = useState("");
  const page = pages.find((one) => one.name === name);
  const title = page === undefined ? texts.product : texts.pages[page.name];
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    void ask(() => plc.target()).then((target) => setPlant(target.plant)).catch(() => {});
  }, []);
  useEffect(() => {
    document.title = `${title} – ${clipped(plant === "" ? texts.product : plant, 60)}`;
  }, [title, plant]);
  const shown = useRef(name);
  useEffect(() => {
    if (shown.current === name) return;
    shown.current = name;
    setMenu(false);
    // Another page: a screen reader begins at its heading.
    heading.current?.focus();
  }, [name]);
  useEffect(watchLink, []);
  const program = useSignal(programs);
  const before = useRef(program);
  useEffect(() => {
    if (before.current !== program) notify(texts.link.otherProgram);
    before.current = program;
  }, [program]);
  const logout = (): void => {
    void ask(() => plc.logout()).catch(() => {}).finally(() => void findSession());
  };
  return (
    <div class={reached ? "shell" : "shell stale"}>
      <a class="skip" href="#contents" onClick={toContents}>
        {texts.skip}
      </a>
      <header>
        <a class="mark" href={link("overview")}>
          <strong>{texts.product}</strong> <span class="path">{clipped(plant, 60)}</span>
        </a>
        <button type="button" class="menu quiet" aria-expanded={menu} aria-controls="navigation" onClick={() => setMenu(!menu)}>
          {texts.menu}
        </button>
        <div id="navigation" class={menu ? "navigation open" : "navigation"}>
          <nav aria-label={texts.navigation}>
            <ul>
              {pages
                .filter((one) => hasRole(one.right))
                .map((one) => (
                  <li key={one.name}>
                    <a href={link(one.name)} aria-current={one.name === name ? "page" : undefined}>
                      {texts.pages[one.name]}
                    </a>
                  </li>
                ))}
            </ul>
          </nav>
          <div class="who">
            <ThemeChoice />
            <button type="button" class="quiet" onClick={() => setAccount(true)} title={texts.account.title}>
              {clipped(who?.user ?? "", 40)} <small>({texts.roles[who?.role ?? ""] ?? ""})</small>
            </button>
            <button type="button" onClick={logout}>
              {texts.login.out}
            </button>
          </div>
        </div>
      </header>
      <div role="status" class="strips">
        {reached ? null : <p class="strip bad">{texts.link.lost}</p>}
        {said === undefined ? null : <p class={`strip ${said.kind}`}>{clipped(said.text)}</p>}
      </div>
      <AlarmBanner />
      <main id="contents" tabIndex={-1}>
        <h1 ref={heading} tabIndex={-1}>
          {title}
        </h1>
        {contents(page, program)}
      </main>
      {account ? <AccountDialog onClose={() => setAccount(false)} /> : null}
    </div>
  );
}

export function App(): JSX.Element {
  const who = useSignal(session);
  const reached = useSignal(connected);
  if (who === undefined) {
    return (
      <main class="alone">
        <p role="status">{reached ? texts.loading : texts.link.lost}</p>
      </main>
    );
  }
  if (who === null) return <LoginPage />;
  return <Shell key={who.user} />;
}
