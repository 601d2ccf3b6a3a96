// Who may do what, who is here, who did what.
import type { JSX } from "preact";
import { useState } from "preact/hooks";
import type { User } from "../../client/calls";
import { warn } from "../notice";
import { ask, may, plc, problemOf, session, usePolled } from "../plc";
import { useSignal } from "../signals";
import { texts } from "../texts";
import { Badge, CallForm, Dialog, Empty, Field, ProblemBox, Section, Table } from "../ui/parts";
import { ageText, clipped } from "../values";

const t = texts.users;
const roles = ["viewer", "operator", "engineer", "admin"] as const;
type Role = (typeof roles)[number];
const roleNamed = (name: string): Role => roles.find((role) => role === name) ?? "viewer";

function RoleField(properties: { value: Role; onChange: (role: Role) => void; most?: Role }): JSX.Element {
  const offered = roles.slice(0, properties.most === undefined ? roles.length : roles.findIndex((role) => role === properties.most) + 1);
  return (
    <Field label={t.role} help={t.roleHelp[properties.value] ?? ""}>
      {(id) => (
        <select id={id} value={properties.value} onChange={(event) => properties.onChange(roleNamed(event.currentTarget.value))}>
          {offered.map((role) => (
            <option key={role} value={role}>
              {texts.roles[role]}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}

function TextField(properties: { label: string; value: string; onInput: (value: string) => void; password?: boolean; required?: boolean }): JSX.Element {
  const rest = {
    value: properties.value,
    required: properties.required ?? true,
    autoCapitalize: "none",
    spellcheck: false,
    onInput: (event: Event & { currentTarget: HTMLInputElement }) => properties.onInput(event.currentTarget.value),
  } as const;
  return (
    <Field label={properties.label}>
      {(id) =>
        properties.password === true ? (
          <input {...rest} id={id} type="password" maxLength={256} autoComplete="new-password" />
        ) : (
          <input {...rest} id={id} type="text" maxLength={64} autoComplete="off" />
        )
      }
    </Field>
  );
}

function AddUser(properties: { onDone: () => void; onClose: () => void }): JSX.Element {
  const [user, setUser] = useState("");
  const [password, setPassword] = useState("");
  const [role, setRole] = useState<Role>("viewer");
  return (
    <Dialog title={t.add} onClose={properties.onClose}>
      <CallForm
        submit={t.submit}
        problemOf={problemOf}
        onCancel={properties.onClose}
        onSubmit={async () => {
          await ask(() => plc.usersAdd({ user, password, role }));
          properties.onDone();
          properties.onClose();
        }}
      >
        <TextField label={t.user} value={user} onInput={setUser} />
        <TextField label={t.password} value={password} onInput={setPassword} password={true} />
        <RoleField value={role} onChange={setRole} />
      </CallForm>
    </Dialog>
  );
}

function ChangeUser(properties: { user: User; onDone: () => void; onClose: () => void }): JSX.Element {
  const [password, setPassword] = useState("");
  const [role, setRole] = useState<Role>(properties.user.role);
  return (
    <Dialog title={t.changeTitle(properties.user.user)} onClose={properties.onClose}>
      <CallForm
        submit={t.save}
        problemOf={problemOf}
        onCancel={properties.onClose}
        onSubmit={async () => {
          await ask(() => plc.usersChange({ user: properties.user.user, role, ...(password === "" ? {} : { password }) }));
          properties.onDone();
          properties.onClose();
        }}
      >
        <p class="quiet-text">{t.changeHelp}</p>
        <RoleField value={role} onChange={setRole} />
        <TextField label={t.newPassword} value={password} onInput={setPassword} password={true} required={false} />
      </CallForm>
    </Dialog>
  );
}

function RemoveUser(properties: { user: User; onDone: () => void; onClose: () => void }): JSX.Element {
  return (
    <Dialog title={t.removeTitle(properties.user.user)} onClose={properties.onClose}>
      <CallForm
        submit={t.remove}
        danger={true}
        problemOf={problemOf}
        onCancel={properties.onClose}
        onSubmit={async () => {
          await ask(() => plc.usersRemove({ user: properties.user.user }));
          properties.onDone();
          properties.onClose();
        }}
      >
        <p>{t.removeHelp}</p>
      </CallForm>
    </Dialog>
  );
}

function AddToken(properties: { onDone: () => void; onClose: () => void }): JSX.Element {
  const [name, setName] = useState("");
  const [role, setRole] = useState<Role>("viewer");
  const [days, setDays] = useState("365");
  const [token, setToken] = useState("");
  return (
    <Dialog title={t.addToken} onClose={properties.onClose}>
      {token === "" ? (
        <CallForm
          submit={t.submit}
          problemOf={problemOf}
          onCancel={properties.onClose}
          onSubmit={async () => {
            setToken((await ask(() => plc.tokensAdd({ name, role, days: Number(days) }))).token);
            properties.onDone();
          }}
        >
          <TextField label={t.token} value={name} onInput={setName} />
          <RoleField value={role} onChange={setRole} most={roleNamed(session.peek()?.role ?? "")} />
          <Field label={t.days}>
            {(id) => <input id={id} type="number" min={0} max={36500} required value={days} onInput={(event) => setDays(event.currentTarget.value)} />}
          </Field>
        </CallForm>
      ) : (
        <div role="status">
          <p>{t.tokenIs}</p>
          <p>
            <code class="secret">{token}</code>
          </p>
        </div>
      )}
    </Dialog>
  );
}

type Opened = { what: "add" } | { what: "token" } | { what: "change" | "remove"; user: User } | undefined;

export function UsersPage(): JSX.Element {
  const me = useSignal(session);
  const users = usePolled(() => plc.users(), 5000);
  const tokens = usePolled(() => plc.tokens(), 5000);
  const sessions = usePolled(() => plc.sessions(), 5000);
  const audit = usePolled(() => plc.audit({ most: 200 }), 5000);
  const [opened, setOpened] = useState<Opened>();
  const close = (): void => setOpened(undefined);
  const again = (): void => {
    users.again();
    tokens.again();
    sessions.again();
    audit.again();
  };
  const run = (call: () => Promise<unknown>): void => {
    ask(call).then(again, (error: unknown) => {
      warn(problemOf(error).text);
      again();
    });
  };
  return (
    <>
      <ProblemBox problem={users.problem} />
      <div class="columns">
        <Section
          title={t.users}
          actions={
            may("users.add") ? (
              <button type="button" class="primary" onClick={() => setOpened({ what: "add" })}>
                {t.add}
              </button>
            ) : null
          }
        >
          <Table
            label={t.users}
            columns={[{ title: t.user }, { title: t.role }, { title: "", class: "end" }]}
            rows={(users.answer?.users ?? []).map((user) => ({
              key: user.user,
              cells: [
                <>
                  <span class="path">{clipped(user.user, 64)}</span> {user.user === me?.user ? <Badge kind="plain">{t.you}</Badge> : null}
                </>,
                texts.roles[user.role] ?? user.role,
                <span class="buttons">
                  <button type="button" class="small" onClick={() => setOpened({ what: "change", user })}>
                    {t.change}
                  </button>
                  <button type="button" class="small" onClick={() => setOpened({ what: "remove", user })}>
                    {t.remove}
                  </button>
                </span>,
              ],
            }))}
          />
        </Section>
        <Section title={t.sessions}>
          <Table
            label={t.sessions}
            columns={[{ title: t.user }, { title: t.address }, { title: t.since }, { title: t.idle }, { title: "", class: "end" }]}
            rows={(sessions.answer?.sessions ?? []).map((one) => ({
              key: String(one.session),
              cells: [
                <span class="path">{clipped(one.user, 64)}</span>,
                one.address,
                <span class="number">{ageText(one.age_ms)}</span>,
                <span class="number">{ageText(one.idle_ms)}</span>,
                one.session === me?.session ? (
                  <Badge kind="plain">{t.thisOne}</Badge>
                ) : (
                  <button type="button" class="small" onClick={() => run(() => plc.sessionsEnd({ session: one.session }))}>
                    {t.end}
                  </button>
                ),
              ],
            }))}
          />
        </Section>
      </div>
      <Section
        title={t.tokens}
        actions={
          <button type="button" onClick={() => setOpened({ what: "token" })}>
            {t.addToken}
          </button>
        }
      >
        {tokens.answer?.tokens.length === 0 ? (
          <Empty>{t.noTokens}</Empty>
        ) : (
          <Table
            label={t.tokens}
            columns={[{ title: t.token }, { title: t.owner }, { title: t.role }, { title: t.made }, { title: t.expires }, { title: "", class: "end" }]}
            rows={(tokens.answer?.tokens ?? []).map((token) => ({
              key: `${token.user}/${token.name}`,
              cells: [
                <span class="path">{clipped(token.name, 64)}</span>,
                <span class="path">{clipped(token.user, 64)}</span>,
                texts.roles[token.role] ?? token.role,
                <span class="number">{token.made.slice(0, 10)}</span>,
                <span class="number">{token.expires?.slice(0, 10) ?? t.never}</span>,
                <button type="button" class="small" onClick={() => run(() => plc.tokensRevoke({ name: token.name, user: token.user }))}>
                  {t.revoke}
                </button>,
              ],
            }))}
          />
        )}
      </Section>
      <Section title={t.audit}>
        <Table
          label={t.audit}
          columns={[{ title: t.when }, { title: t.user }, { title: t.address }, { title: t.what }, { title: t.details }]}
          rows={(audit.answer?.records ?? [])
            .slice()
            .reverse()
            .map((record) => ({
              key: String(record.n),
              cells: [
                <span class="number">{record.time.replace("T", " ").replace("Z", "")}</span>,
                <span class="path">{clipped(record.user, 64)}</span>,
                record.address,
                record.what,
                record.details === undefined || Object.keys(record.details as object).length === 0 ? null : <span class="path">{clipped(JSON.stringify(record.details), 300)}</span>,
              ],
            }))}
        />
      </Section>
      {opened?.what === "add" ? <AddUser onDone={again} onClose={close} /> : null}
      {opened?.what === "token" ? <AddToken onDone={again} onClose={close} /> : null}
      {opened?.what === "change" ? <ChangeUser user={opened.user} onDone={again} onClose={close} /> : null}
      {opened?.what === "remove" ? <RemoveUser user={opened.user} onDone={again} onClose={close} /> : null}
    </>
  );
}
