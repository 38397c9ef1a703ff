import { useSignal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { TextField } from "../forms/text_field";
import { session } from "../session";
import { texts } from "../texts/texts";

/** The operator chooses a password; other sessions end. */
export function PasswordForm() {
  const [password, new_password] = [useSignal(""), useSignal("")];
  const problem = useSignal<Problem | null>(null);
  const changed = useSignal(false);
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const body = { password: password.value, new_password: new_password.value };
    const result = await resultOf(api.POST("/api/v1/session/password", { body }));
    problem.value = result.ok ? null : result.problem;
    changed.value = result.ok;
    if (!result.ok) return;
    password.value = new_password.value = "";
    session.value = result.value;
  };
  return (
    <form class="grid-form" onSubmit={(event) => void submit(event)}>
      <TextField
        label={t.present_password}
        value={password}
        input={{ required: true, type: "password", autocomplete: "current-password" }}
      />
      <TextField
        label={t.new_password}
        value={new_password}
        hint={t.new_password_hint}
        input={{ required: true, type: "password", autocomplete: "new-password", minLength: 12 }}
      />
      <button class="button main">{t.change_password}</button>
      {changed.value && <p role="status">{t.password_changed}</p>}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </form>
  );
}
