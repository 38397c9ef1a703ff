import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Loading, Note, ProblemNote } from "../../shared/ui/alerts";
import { Question } from "../../shared/ui/dialog";
import { TextField } from "../forms/text_field";
import { tokens } from "../store/lists";
import { texts } from "../texts/texts";
import { day, now_ms } from "../texts/times";

export function DeveloperTokens() {
  const t = texts.value;
  const shown = tokens.value.value;
  useEffect(() => void tokens.refresh(), []);
  return (
    <section class="block card">
      <h2>{t.tokens_title}</h2>
      <p class="hint">{t.tokens_lead}</p>
      <NewToken />
      {tokens.problem.value !== null && <ProblemNote problem={tokens.problem.value} />}
      {shown === null && tokens.problem.value === null && <Loading text={t.loading} />}
      {shown?.length === 0 && <p class="empty">{t.no_tokens}</p>}
      <ul class="rows">
        {shown?.map((token) => (
          <li key={token.token_id} class="token">
            <TokenLine token={token} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function NewToken() {
  const name = useSignal("");
  const days = useSignal("30");
  const may_drive = useSignal(false);
  const secret = useSignal("");
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const scopes: ("read" | "drive")[] = may_drive.value ? ["read", "drive"] : ["read"];
    const body = { name: name.value, scopes, valid_days: Number(days.value) };
    const answer = await answerOf(api.POST("/api/v1/developer-tokens", { body }));
    secret.value = answer.ok ? answer.value.secret : "";
    problem.value = answer.ok ? null : answer.problem;
    if (answer.ok) name.value = "";
    await tokens.refresh();
  };
  return (
    <form class="grid-form" onSubmit={(event) => void submit(event)}>
      <TextField
        label={t.token_name}
        value={name}
        hint={t.id_hint}
        input={{
          required: true,
          pattern: "[A-Za-z0-9][A-Za-z0-9._@:\\-]{0,63}",
          autocomplete: "off",
        }}
      />
      <TextField
        label={t.valid_days}
        value={days}
        input={{ required: true, type: "number", min: 1, max: 366 }}
      />
      <div class="checks">
        <label class="check">
          <input type="checkbox" checked disabled />
          {t.scope_read}
        </label>
        <label class="check">
          <input
            type="checkbox"
            checked={may_drive.value}
            onChange={(event) => {
              may_drive.value = event.currentTarget.checked;
            }}
          />
          {t.scope_drive}
        </label>
      </div>
      <button class="button main">{t.make_token}</button>
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {secret.value !== "" && (
        <Note tone="good">
          <p>{t.token_once}</p>
          <p class="secret">{secret.value}</p>
        </Note>
      )}
    </form>
  );
}

function TokenLine({ token }: { readonly token: Schemas["TokenView"] }) {
  const asking = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const is_over = Date.parse(token.expires_at) <= now_ms();
  const revoke = async () => {
    asking.value = false;
    const path = { params: { path: { token_id: token.token_id } } };
    const answer = await answerOf(api.DELETE("/api/v1/developer-tokens/{token_id}", path));
    problem.value = answer.ok ? null : answer.problem;
    await tokens.refresh();
  };
  return (
    <>
      <span>
        <strong>{token.name}</strong>
        <small>
          {token.scopes.join(", ")} · {t.expires(day(token.expires_at))} · {token.made_by}
        </small>
      </span>
      {token.revoked_at !== null ? (
        <span class="chip calm">{t.revoked}</span>
      ) : is_over ? (
        <span class="chip calm">{t.expired}</span>
      ) : (
        <button
          type="button"
          class="button small danger"
          onClick={() => {
            asking.value = true;
          }}
        >
          {t.revoke}
        </button>
      )}
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {asking.value && (
        <Question
          danger
          title={t.revoke_title(token.name)}
          text={t.revoke_text}
          yes={t.revoke}
          no={t.cancel}
          onNo={() => {
            asking.value = false;
          }}
          onYes={() => void revoke()}
        />
      )}
    </>
  );
}
