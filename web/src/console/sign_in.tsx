import { useSignal } from "@preact/signals";
import type { Problem } from "../shared/api/problem";
import { ProblemAlert } from "../shared/ui/alerts";
import { Logo } from "../shared/ui/icons";
import { LanguageSwitch } from "../shared/ui/language_switch";
import { TextField } from "./forms/text_field";
import { signIn } from "./session";
import { texts } from "./texts/texts";

export function SignIn() {
  const name = useSignal("");
  const password = useSignal("");
  const busy = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    busy.value = true;
    problem.value = await signIn(name.value, password.value);
    busy.value = false;
  };
  return (
    <main class="sign-in">
      <form class="card" onSubmit={(event) => void submit(event)}>
        <header>
          <Logo />
          <LanguageSwitch />
        </header>
        <h1>{t.title}</h1>
        <p class="hint">{t.sign_in_lead}</p>
        <TextField
          label={t.name}
          value={name}
          input={{ required: true, autocomplete: "username", autocapitalize: "none" }}
        />
        <TextField
          label={t.password}
          value={password}
          input={{ required: true, type: "password", autocomplete: "current-password" }}
        />
        {problem.value !== null && <ProblemAlert problem={problem.value} />}
        <button class="button main large wide" disabled={busy.value}>
          {busy.value ? t.signing_in : t.sign_in}
        </button>
      </form>
    </main>
  );
}
