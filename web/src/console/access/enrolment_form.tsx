import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { TextField } from "../forms/text_field";
import { texts } from "../texts/texts";

const NAME_PATTERN = "[A-Za-z0-9][A-Za-z0-9._@:\\-]{0,63}";

export function EnrolmentForm() {
  const vehicle_id = useSignal("");
  const name = useSignal("");
  const seats = useSignal("6");
  const wheelchairs = useSignal("0");
  const code = useSignal<Schemas["CodeView"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const body = {
      vehicle_id: vehicle_id.value,
      name: name.value,
      seats: Number(seats.value),
      wheelchair_places: Number(wheelchairs.value),
    };
    const result = await resultOf(api.POST("/api/v1/enrolments/codes", { body }));
    code.value = result.ok ? result.value : null;
    problem.value = result.ok ? null : result.problem;
  };
  return (
    <section class="block card">
      <h2>{t.enrol_title}</h2>
      <form class="grid-form" onSubmit={(event) => void submit(event)}>
        <TextField
          label={t.vehicle_id}
          value={vehicle_id}
          hint={t.id_hint}
          input={{ required: true, pattern: NAME_PATTERN, autocomplete: "off" }}
        />
        <TextField
          label={t.vehicle_name}
          value={name}
          input={{ required: true, maxLength: 64, autocomplete: "off" }}
        />
        <TextField
          label={t.seats}
          value={seats}
          input={{ required: true, type: "number", min: 1, max: 200 }}
        />
        <TextField
          label={t.wheelchairs}
          value={wheelchairs}
          input={{ required: true, type: "number", min: 0, max: 50 }}
        />
        <button class="button main">{t.make_code}</button>
      </form>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {code.value !== null && (
        <Alert tone="good">
          <strong>{t.code_for(code.value.vehicle_id)}</strong>
          <p>{t.enrol_lead}</p>
          <p class="secret">{code.value.code}</p>
        </Alert>
      )}
    </section>
  );
}
