import type { Signal } from "@preact/signals";
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { TextField } from "../forms/text_field";
import type { Role } from "../session";
import { operators } from "../store/operators";
import { texts } from "../texts/texts";

type Operator = Schemas["OperatorView"];

const ROLES: readonly Role[] = ["dispatcher", "safety", "admin"];

/** Operators by name and what each may do; admins change it here. */
export function OperatorList() {
  const t = texts.value;
  const shown = operators.value.value;
  const initial = useSignal<Schemas["OperatorWithPassword"] | null>(null);
  useEffect(() => void operators.refresh(), []);
  return (
    <section class="block card">
      <h2>{t.operators}</h2>
      <p class="hint">{t.operators_lead}</p>
      <OperatorForm initial={initial} />
      {initial.value !== null && (
        <Alert tone="good">
          <strong>{t.initial_for(initial.value.name)}</strong>
          <p>{t.initial_once}</p>
          <p class="secret">{initial.value.initial_password}</p>
        </Alert>
      )}
      {operators.problem.value !== null && <ProblemAlert problem={operators.problem.value} />}
      {shown === null && operators.problem.value === null && <Loading text={t.loading} />}
      <ul class="rows">
        {shown?.map((operator) => (
          <li key={operator.name} class="operator" data-operator={operator.name}>
            <OperatorRow operator={operator} initial={initial} />
          </li>
        ))}
      </ul>
    </section>
  );
}

interface WithInitialPassword {
  readonly initial: Signal<Schemas["OperatorWithPassword"] | null>;
}

function OperatorForm({ initial }: WithInitialPassword) {
  const name = useSignal("");
  const roles = useSignal<readonly Role[]>([]);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const body = { name: name.value, roles: [...roles.value] };
    const result = await resultOf(api.POST("/api/v1/operators", { body }));
    problem.value = result.ok ? null : result.problem;
    initial.value = result.ok ? result.value : null;
    if (result.ok) name.value = "";
    await operators.refresh();
  };
  return (
    <form class="grid-form" onSubmit={(event) => void submit(event)}>
      <TextField
        label={t.name}
        value={name}
        hint={t.id_hint}
        input={{
          required: true,
          pattern: "[A-Za-z0-9][A-Za-z0-9._@:\\-]{0,63}",
          autocomplete: "off",
        }}
      />
      <RoleChecks
        own={roles.value}
        onChange={(next) => {
          roles.value = next;
        }}
      />
      <button class="button main">{t.create_operator}</button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </form>
  );
}

interface RoleChecksProps {
  readonly own: readonly Role[];
  readonly onChange: (roles: readonly Role[]) => void;
}

function RoleChecks({ own, onChange }: RoleChecksProps) {
  const t = texts.value;
  return (
    <div class="checks">
      {ROLES.map((role) => (
        <label key={role} class="check">
          <input
            type="checkbox"
            checked={own.includes(role)}
            onChange={(event) =>
              onChange(
                event.currentTarget.checked
                  ? [...own, role]
                  : own.filter((other) => other !== role),
              )
            }
          />
          {t.roles[role]}
        </label>
      ))}
    </div>
  );
}

function OperatorRow({ operator, initial }: WithInitialPassword & { readonly operator: Operator }) {
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const params = { path: { name: operator.name } };
  const finish = async (result: Result<unknown>) => {
    problem.value = result.ok ? null : result.problem;
    await operators.refresh();
  };
  const change = async (roles: readonly Role[], disabled: boolean) => {
    const body = { roles: [...roles], disabled };
    await finish(await resultOf(api.PUT("/api/v1/operators/{name}", { params, body })));
  };
  const reset = async () => {
    const result = await resultOf(api.POST("/api/v1/operators/{name}/password", { params }));
    initial.value = result.ok ? result.value : null;
    await finish(result);
  };
  const resetFactor = async () =>
    finish(await resultOf(api.DELETE("/api/v1/operators/{name}/second-factor", { params })));
  return (
    <>
      <span>
        <strong>{operator.name}</strong>
        <small>
          {operator.disabled && `${t.disabled} · `}
          {operator.password_change_needed && `${t.initial_password} · `}
          {operator.second_factor ? t.with_second_factor : t.without_second_factor}
        </small>
      </span>
      <RoleChecks
        own={operator.roles}
        onChange={(roles) => void change(roles, operator.disabled)}
      />
      <span class="buttons">
        <button type="button" class="button small" onClick={() => void reset()}>
          {t.reset_password}
        </button>
        {operator.second_factor && (
          <button type="button" class="button small" onClick={() => void resetFactor()}>
            {t.reset_second_factor}
          </button>
        )}
        <button
          type="button"
          class={`button small ${operator.disabled ? "" : "danger"}`}
          onClick={() => void change(operator.roles, !operator.disabled)}
        >
          {operator.disabled ? t.enable : t.disable}
        </button>
      </span>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </>
  );
}
