import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { TextField } from "../forms/text_field";
import { refreshSession, session } from "../session";
import { texts } from "../texts/texts";

/** Sets up an authenticator: picture, first code, recovery codes. */
export function SecondFactorForm() {
  const [password, code] = [useSignal(""), useSignal("")];
  const begun = useSignal<Schemas["NewSecondFactorView"] | null>(null);
  const recovery = useSignal<readonly string[]>([]);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const begin = async (event: Event) => {
    event.preventDefault();
    const body = { password: password.value };
    const result = await resultOf(api.POST("/api/v1/session/second-factor", { body }));
    problem.value = result.ok ? null : result.problem;
    begun.value = result.ok ? result.value : null;
    password.value = "";
  };
  const confirm = async (event: Event) => {
    event.preventDefault();
    const path = "/api/v1/session/second-factor/confirmation";
    const result = await resultOf(api.POST(path, { body: { code: code.value.trim() } }));
    problem.value = result.ok ? null : result.problem;
    code.value = "";
    if (!result.ok) return;
    begun.value = null;
    recovery.value = result.value.recovery_codes;
    await refreshSession();
  };
  const remove = async () => {
    const result = await resultOf(api.DELETE("/api/v1/session/second-factor"));
    problem.value = result.ok ? null : result.problem;
    await refreshSession();
  };
  const has_one = session.value?.second_factor === true;
  return (
    <>
      <p>{has_one ? t.second_factor_on : t.second_factor_off}</p>
      {begun.value === null ? (
        <form class="grid-form" onSubmit={(event) => void begin(event)}>
          <TextField
            label={t.present_password}
            value={password}
            input={{ required: true, type: "password", autocomplete: "current-password" }}
          />
          <button class="button main">
            {has_one ? t.second_factor_new : t.second_factor_begin}
          </button>
          {has_one && (
            <button type="button" class="button danger" onClick={() => void remove()}>
              {t.second_factor_remove}
            </button>
          )}
        </form>
      ) : (
        <form class="grid-form" onSubmit={(event) => void confirm(event)}>
          <img
            class="qr"
            alt={t.qr}
            src={`data:image/svg+xml,${encodeURIComponent(begun.value.qr_svg)}`}
          />
          <div>
            <p class="hint">{t.second_factor_scan}</p>
            <p class="secret">{begun.value.secret}</p>
          </div>
          <TextField
            label={t.code}
            value={code}
            input={{ required: true, autocomplete: "one-time-code", inputMode: "numeric" }}
          />
          <button class="button main">{t.confirm_code}</button>
        </form>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {recovery.value.length > 0 && (
        <Alert tone="good">
          <p>{t.recovery_once}</p>
          <p class="secret">{recovery.value.join("\n")}</p>
        </Alert>
      )}
    </>
  );
}
