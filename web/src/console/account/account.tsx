import { session } from "../session";
import { texts } from "../texts/texts";
import { PasswordForm } from "./password_form";
import { SecondFactorForm } from "./second_factor_form";

/** The operator's own roles, password and second factor. */
export function Account() {
  const t = texts.value;
  const roles = session.value?.roles ?? [];
  return (
    <section class="block card">
      <h2>{t.account}</h2>
      <p>{t.your_roles(roles.map((role) => t.roles[role]).join(", "))}</p>
      <h3>{t.change_password}</h3>
      <PasswordForm />
      <h3>{t.second_factor}</h3>
      <SecondFactorForm />
    </section>
  );
}
