import { afterEach, expect, test, vi } from "vitest";
import { api } from "../../shared/api/client";
import type { Trip } from "./timetable_draft";
import { TimetableDraft, withTrip } from "./timetable_draft";

const trip = (trip_id: string, ...times: readonly string[]): Trip => ({
  trip_id,
  service_id: "",
  calls: times.map((leaves, number) => ({ stop_id: `stop-${number}`, leaves })),
});

test("a trip takes the place of the one that was edited, in the order of the day", () => {
  const trips = [trip("a", "08:00", "08:10"), trip("b", "09:00", "09:10")];
  const ids = (changed: readonly Trip[]) => changed.map(({ trip_id }) => trip_id);
  expect(ids(withTrip(trips, trip("a2", "10:00", "10:10"), "a"))).toEqual(["b", "a2"]);
  expect(ids(withTrip(trips, trip("c", "08:30", "08:40"), null))).toEqual(["a", "c", "b"]);
  expect(ids(trips)).toEqual(["a", "b"]);
});

afterEach(() => {
  vi.restoreAllMocks();
});

/** A server whose answers are let go one by one; `asked` has what it was asked, with its revision. */
function slowServer() {
  const asked: string[] = [];
  const answers: ((data: unknown) => void)[] = [];
  for (const method of ["GET", "POST"] as const)
    vi.spyOn(api, method).mockImplementation(((path: string, init?: Init) => {
      asked.push(`${method} ${path} ${init?.params?.header?.["If-Match"] ?? ""}`.trim());
      return new Promise((resolve) =>
        answers.push((data) => resolve({ data, response: new Response() })),
      );
    }) as never);
  const answer = async (data: unknown) => {
    await vi.waitFor(() => expect(answers).not.toEqual([]));
    answers.shift()?.(data);
  };
  return { asked, answer };
}

interface Init {
  readonly params?: { readonly header?: { readonly "If-Match": number } };
}

const timetable = (revision: number) => ({
  revision,
  trips: [],
  versions: [],
  unserved: [],
  tight_legs: [],
});
const effect = { added: ["a"], changed: [], removed: [], withdrawn: [], kept: [], tight_legs: [] };

test("a preview waits for the other operator's version that was asked for before it", async () => {
  const server = slowServer();
  const draft = new TimetableDraft();
  const [kept, previewed] = [draft.keepMine(), draft.preview()];
  await server.answer(timetable(7));
  await kept;
  await server.answer(effect);
  await previewed;
  expect(server.asked).toEqual([
    "GET /api/v1/service/trips",
    "POST /api/v1/service/trips/previews 7",
  ]);
  expect(draft.effect.value).toEqual(effect);
});

test("a preview of trips that were edited meanwhile is not shown", async () => {
  const server = slowServer();
  const draft = new TimetableDraft();
  const previewed = draft.preview();
  await vi.waitFor(() => expect(server.asked).toHaveLength(1));
  draft.change([trip("a", "08:00", "08:10")]);
  await server.answer(effect);
  await previewed;
  expect(draft.effect.value).toBeNull();
});
