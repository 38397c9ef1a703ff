import type { Schemas } from "../../shared/api/client";

/** What the fleet replay says of a day that is dispatched again. */
export const forkEn = {
  fork: "What if",
  fork_lead:
    "Dispatches the rides from this moment on again: with the fleet of then, and with your change. Nothing changes for anyone.",
  fork_more: "Shuttles more (or less, with a minus)",
  fork_policy: "Policy",
  fork_policies: {
    improvement: "as now: insert, then improve",
    insertion: "insert only",
    "departure-slack": "insert, depart later",
    "departure-slack-improvement": "insert, depart later, improve",
  } satisfies Record<Schemas["ForkRequest"]["policy"], string> as Record<string, string>,
  fork_hours: "Rides of the next",
  fork_hour_count: (hours: number) => (hours === 1 ? "hour" : `${hours} hours`),
  fork_from: (time: string) => `Compare from ${time} on`,
  fork_running: "Dispatching again. This takes seconds…",
  fork_stop: "Stop",
  fork_cost: (seconds: string) => `It took the server ${seconds} s of one processor.`,
  fork_of: (time: string, rides: number, placed: number) =>
    `From ${time} on. Rides: ${rides}. Shuttles that begin where they were: ${placed}.`,
  fork_as_planned:
    "Both columns on the right happen as planned: no traffic, no late riders. Compare them with each other.",
  fork_then: "Then",
  fork_again: "Again",
  fork_changed: "Changed",
  shuttles: "Shuttles",
  fork_served: "Rides served",
  fork_refused: "Rides refused",
  fork_wait_median: "Wait, median",
  fork_wait_p95: "Wait, 95 %",
  fork_on_board: "On board, mean",
  fork_driving: "Hours driven",
  fork_minutes: (minutes: string) => `${minutes} min`,
  fork_different: (count: number) =>
    count === 0
      ? "No ride is treated differently"
      : count === 1
        ? "1 ride is treated differently"
        : `${count} rides are treated differently`,
  fork_waits: (wait: string) => `waits ${wait}`,
  fork_ends: { refused: "refused", cancelled: "cancelled" } as Record<string, string>,
  fork_only_first: (count: number) => `The ${count} with the largest difference.`,
};
