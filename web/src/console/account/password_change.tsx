import { Logo } from "../../shared/ui/icons";
import { LanguageSwitch } from "../../shared/ui/language_switch";
import { signOut } from "../session";
import { texts } from "../texts/texts";
import { PasswordForm } from "./password_form";

/** All that an operator sees whose password was given by an admin. */
export function PasswordChange() {
  const t = texts.value;
  return (
    <main class="sign-in">
      <section class="card">
        <header>
          <Logo />
          <LanguageSwitch />
        </header>
        <h1>{t.initial_title}</h1>
        <p class="hint">{t.initial_text}</p>
        <PasswordForm />
        <button type="button" class="button" onClick={() => void signOut()}>
          {t.sign_out}
        </button>
      </section>
    </main>
  );
}
