import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { api, resultOf, type Schemas } from "../../../shared/api/client";
import { idempotencyKey } from "../../../shared/api/idempotency_key";
import type { Problem } from "../../../shared/api/problem";
import { Loading, ProblemAlert } from "../../../shared/ui/alerts";
import { RoleGate } from "../../account/role_gate";
import { texts } from "../../texts/texts";
import { formatTimeWithSeconds } from "../../texts/times";
import type { PlaybackClock } from "../playback_clock";
import { ForkComparison } from "./fork_comparison";

type Policy = Schemas["ForkRequest"]["policy"];

const POLICIES: readonly Policy[] = [
  "improvement",
  "insertion",
  "departure-slack",
  "departure-slack-improvement",
];
const HOURS: readonly number[] = [1, 2, 6, 12];
const STOP_AGAIN_MS = 300;

interface ForkPanelProps {
  readonly clock: PlaybackClock;
  readonly end_ms: number;
}

/** From the moment that is shown on, the rides are dispatched again with another fleet or policy. */
export function ForkPanel({ clock, end_ms }: ForkPanelProps) {
  const t = texts.value;
  const more = useSignal(1);
  const policy = useSignal<Policy>("improvement");
  const hours = useSignal(2);
  /** The name of the comparison under way, by which it can be stopped. */
  const running = useSignal<string | null>(null);
  const problem = useSignal<Problem | null>(null);
  const fork = useSignal<{ readonly at_ms: number; readonly view: Schemas["ForkView"] } | null>(
    null,
  );
  const ids = { more: useId(), policy: useId(), hours: useId() };
  const compare = async (event: Event) => {
    event.preventDefault();
    const at_ms = Math.floor(clock.at_ms.value);
    const seconds = Math.floor(Math.min(3600 * hours.value, (end_ms - at_ms) / 1000));
    const fork_id = `fork-${idempotencyKey()}`;
    running.value = fork_id;
    problem.value = null;
    const result = await resultOf(
      api.POST("/api/v1/replays/forks", {
        body: {
          from_ms: at_ms,
          seconds: Math.max(seconds, 60),
          more: more.value,
          policy: policy.value,
          fork_id,
        },
      }),
    );
    running.value = null;
    if (result.ok) fork.value = { at_ms, view: result.value };
    else problem.value = result.problem;
  };
  const stop = async (fork_id: string) => {
    // The server reads its rides first, and does not know the comparison until then: it is asked again.
    while (running.peek() === fork_id) {
      const result = await resultOf(
        api.DELETE("/api/v1/replays/forks/{fork_id}", { params: { path: { fork_id } } }),
      );
      if (result.ok) return;
      if (result.problem.code !== "fork_unknown") {
        problem.value = result.problem;
        return;
      }
      await new Promise((resolve) => setTimeout(resolve, STOP_AGAIN_MS));
    }
  };
  return (
    <section class="block" aria-label={t.fork}>
      <h2>{t.fork}</h2>
      <p class="hint">{t.fork_lead}</p>
      <RoleGate roles={["dispatcher", "safety"]}>
        <form class="grid-form" onSubmit={(event) => void compare(event)}>
          <label class="field" for={ids.more}>
            {t.fork_more}
            <input
              id={ids.more}
              class="input"
              type="number"
              min={-50}
              max={50}
              required
              value={more.value}
              onInput={(event) => {
                more.value = event.currentTarget.valueAsNumber || 0;
              }}
            />
          </label>
          <label class="field" for={ids.policy}>
            {t.fork_policy}
            <select
              id={ids.policy}
              class="input"
              value={policy.value}
              onChange={(event) => {
                policy.value = event.currentTarget.value as Policy;
              }}
            >
              {POLICIES.map((name) => (
                <option key={name} value={name}>
                  {t.fork_policies[name]}
                </option>
              ))}
            </select>
          </label>
          <label class="field" for={ids.hours}>
            {t.fork_hours}
            <select
              id={ids.hours}
              class="input"
              value={hours.value}
              onChange={(event) => {
                hours.value = Number(event.currentTarget.value);
              }}
            >
              {HOURS.map((count) => (
                <option key={count} value={count}>
                  {t.fork_hour_count(count)}
                </option>
              ))}
            </select>
          </label>
          <button class="button" disabled={running.value !== null}>
            {t.fork_from(formatTimeWithSeconds(clock.at_ms.value))}
          </button>
        </form>
      </RoleGate>
      {running.value !== null && (
        <>
          <Loading text={t.fork_running} />
          <button
            type="button"
            class="button small"
            onClick={() => void stop(running.peek() ?? "")}
          >
            {t.fork_stop}
          </button>
        </>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {fork.value !== null && running.value === null && (
        <ForkComparison at_ms={fork.value.at_ms} fork={fork.value.view} />
      )}
    </section>
  );
}
