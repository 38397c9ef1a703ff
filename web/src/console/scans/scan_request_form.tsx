import { useSignal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { campus } from "../../shared/campus/campus";
import type { Point } from "../../shared/scene/scene";
import { ProblemAlert } from "../../shared/ui/alerts";
import { SelectField } from "../forms/select_field";
import { TextField } from "../forms/text_field";
import { scanRequests } from "../store/scans";
import { texts } from "../texts/texts";
import { AreaPicker } from "./area_picker";

const GIB = 1024 ** 3;

/** Asks all shuttles for scans of an area. */
export function ScanRequestForm() {
  const t = texts.value;
  const name = useSignal("");
  const area = useSignal<"campus" | "drawn">("campus");
  const outline = useSignal<readonly Point[]>([]);
  const hours = useSignal("24");
  const gigabytes = useSignal("2");
  const problem = useSignal<Problem | null>(null);
  const is_drawn = area.value === "drawn";
  const ask = async (event: Event) => {
    event.preventDefault();
    const result = await resultOf(
      api.POST("/api/v1/scan-requests", {
        body: {
          name: name.value,
          outline: is_drawn ? outline.value.map((corner): [number, number] => [...corner]) : [],
          every_m: 0.5,
          bytes_max: Math.round(Number(gigabytes.value) * GIB),
          hours: Number(hours.value),
        },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) {
      name.value = "";
      outline.value = [];
    }
    await scanRequests.refresh();
  };
  const number = { type: "number", required: true, step: "any" } as const;
  return (
    <form class="grid-form" onSubmit={(event) => void ask(event)}>
      <TextField label={t.scan_name} value={name} input={{ required: true, maxLength: 500 }} />
      <SelectField
        label={t.scan_area}
        value={area.value}
        options={[
          ["campus", t.scan_area_choice.campus],
          ["drawn", t.scan_area_choice.drawn],
        ]}
        onChange={(value) => (area.value = value === "drawn" ? "drawn" : "campus")}
      />
      {is_drawn && campus.value !== null && <AreaPicker campus={campus.value} outline={outline} />}
      <TextField label={t.scan_hours} value={hours} input={{ ...number, min: 0.1, max: 336 }} />
      <TextField
        label={t.scan_gigabytes}
        value={gigabytes}
        input={{ ...number, min: 0.01, max: 64 }}
      />
      <button class="button main" disabled={is_drawn && outline.value.length < 3}>
        {t.scan_ask}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </form>
  );
}
