import type { JSX } from "preact";
import { useState } from "preact/hooks";
import { ask, connected, findSession, needsFirstUser, plc, problemOf, sessionEnd } from "../plc";
import { useSignal } from "../signals";
import { texts } from "../texts";
import { CallForm, Field } from "../ui/parts";

export function LoginPage(): JSX.Element {
  const first = useSignal(needsFirstUser);
  const ended = useSignal(sessionEnd);
  const reached = useSignal(connected);
  const [user, setUser] = useState("");
  const [password, setPassword] = useState("");
  const [code, setCode] = useState("");
  const submit = async (): Promise<void> => {
    await ask(() => (first ? plc.firstUser({ code, user, password }) : plc.login({ user, password })));
    sessionEnd.value = "";
    await findSession();
  };
  return (
    <main class="alone">
      <div class="card login">
        <p class="mark">
          <strong>{texts.product}</strong>
        </p>
        <h1>{first ? texts.login.first : texts.login.title}</h1>
        <div role="status">
          {ended === "" ? null : <p>{ended}</p>}
          {reached ? null : <p class="strip bad">{texts.link.lost}</p>}
        </div>
        {first ? <p>{texts.login.firstHelp}</p> : null}
        <CallForm submit={first ? texts.login.firstSubmit : texts.login.submit} onSubmit={submit} problemOf={problemOf}>
          {first ? (
            <Field label={texts.login.code}>
              {(id) => (
                <input id={id} name="code" value={code} required autoComplete="off" autoCapitalize="characters" spellcheck={false}
                  onInput={(event) => setCode(event.currentTarget.value)} />
              )}
            </Field>
          ) : null}
          <Field label={texts.login.user}>
            {(id) => (
              <input id={id} name="user" value={user} required maxLength={64} autoComplete="username" autoCapitalize="none" spellcheck={false}
                onInput={(event) => setUser(event.currentTarget.value)} />
            )}
          </Field>
          <Field label={first ? texts.login.newPassword : texts.login.password}>
            {(id) => (
              <input id={id} name="password" type="password" value={password} required maxLength={256}
                autoComplete={first ? "new-password" : "current-password"} onInput={(event) => setPassword(event.currentTarget.value)} />
            )}
          </Field>
        </CallForm>
      </div>
    </main>
  );
}
