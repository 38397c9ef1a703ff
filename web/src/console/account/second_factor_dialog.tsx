import { useSignal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { TextField } from "../forms/text_field";
import { session } from "../session";
import { texts } from "../texts/texts";
import { secondFactorQuestion } from "./second_factor_question";

/** Shown when a command needs a code of the authenticator; the command is sent again afterwards. */
export function SecondFactorDialog() {
  return secondFactorQuestion.value === null ? null : <CodeQuestion />;
}

function CodeQuestion() {
  const code = useSignal("");
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const finish = (answered: boolean) => secondFactorQuestion.peek()?.(answered);
  const submit = async (event: Event) => {
    event.preventDefault();
    const body = { code: code.value.trim() };
    const result = await resultOf(api.POST("/api/v1/session/second-factor/checks", { body }));
    problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    session.value = result.value;
    finish(true);
  };
  return (
    <Dialog title={t.code_title} onClose={() => finish(false)}>
      <form class="grid-form" onSubmit={(event) => void submit(event)}>
        <p>{t.code_text}</p>
        <TextField
          label={t.code}
          value={code}
          input={{ required: true, autocomplete: "one-time-code", maxLength: 64 }}
        />
        {problem.value !== null && <ProblemAlert problem={problem.value} />}
        <div class="dialog-buttons">
          <button type="button" class="button" onClick={() => finish(false)}>
            {t.cancel}
          </button>
          <button class="button main">{t.confirm_code}</button>
        </div>
      </form>
    </Dialog>
  );
}
