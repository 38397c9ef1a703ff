import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { TextField } from "../forms/text_field";
import { developerTokens } from "../store/developer_tokens";
import { texts } from "../texts/texts";
import { formatDateTime, now_ms } from "../texts/times";

export function DeveloperTokenList() {
  const t = texts.value;
  const shown = developerTokens.value.value;
  useEffect(() => void developerTokens.refresh(), []);
  return (
    <section class="block card">
      <h2>{t.tokens_title}</h2>
      <p class="hint">{t.tokens_lead}</p>
      <TokenForm />
      {developerTokens.problem.value !== null && (
        <ProblemAlert problem={developerTokens.problem.value} />
      )}
      {shown === null && developerTokens.problem.value === null && <Loading text={t.loading} />}
      {shown?.length === 0 && <p class="empty">{t.no_tokens}</p>}
      <ul class="rows">
        {shown?.map((token) => (
          <li key={token.token_id} class="token">
            <TokenRow token={token} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function TokenForm() {
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
    const result = await resultOf(api.POST("/api/v1/developer-tokens", { body }));
    secret.value = result.ok ? result.value.secret : "";
    problem.value = result.ok ? null : result.problem;
    if (result.ok) name.value = "";
    await developerTokens.refresh();
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
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {secret.value !== "" && (
        <Alert tone="good">
          <p>{t.token_once}</p>
          <p class="secret">{secret.value}</p>
        </Alert>
      )}
    </form>
  );
}

function TokenRow({ token }: { readonly token: Schemas["TokenView"] }) {
  const confirming = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const is_expired = Date.parse(token.expires_at) <= now_ms();
  const revoke = async () => {
    confirming.value = false;
    const path = { params: { path: { token_id: token.token_id } } };
    const result = await resultOf(api.DELETE("/api/v1/developer-tokens/{token_id}", path));
    problem.value = result.ok ? null : result.problem;
    await developerTokens.refresh();
  };
  return (
    <>
      <span>
        <strong>{token.name}</strong>
        <small>
          {token.scopes.join(", ")} · {t.expires(formatDateTime(token.expires_at))} ·{" "}
          {token.made_by}
        </small>
      </span>
      {token.revoked_at !== null ? (
        <span class="chip calm">{t.revoked}</span>
      ) : is_expired ? (
        <span class="chip calm">{t.expired}</span>
      ) : (
        <button
          type="button"
          class="button small danger"
          onClick={() => {
            confirming.value = true;
          }}
        >
          {t.revoke}
        </button>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {confirming.value && (
        <ConfirmDialog
          danger
          title={t.revoke_title(token.name)}
          text={t.revoke_text}
          yes={t.revoke}
          no={t.cancel}
          onNo={() => {
            confirming.value = false;
          }}
          onYes={() => void revoke()}
        />
      )}
    </>
  );
}
