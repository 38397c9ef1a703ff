import { describe, expect, test } from "vitest";
import { aDrivingView, aStatus } from "../shared/scene/scene_builders";
import type { CabinView, CabinVisit, ScreenScene } from "./screen_scene";
import { currentView, drivingState, mapScene, minutesTo, peopleSeen } from "./screen_scene";

const VISIT: CabinVisit = {
  visit_id: "v1",
  kind: "stop",
  stop_id: "library",
  name: "图书馆",
  name_en: "Library",
  distance_m: 200,
  least_s: 61,
  boarding: 0,
  alighting: 1,
};

function aView(changes: Partial<CabinView> = {}): CabinView {
  return {
    status: aStatus(),
    has_position: true,
    connected: true,
    utc_ns: 0,
    visits: [VISIT],
    aboard: 1,
    parties: 1,
    early_stop: false,
    serving: false,
    limited_by: "speed_limit",
    shown: null,
    ...changes,
  };
}

function aScene(view: CabinView | null, view_age_s: number | null): ScreenScene {
  return {
    vehicle_id: "shuttle-1",
    seats: 6,
    view,
    view_age_s,
    announcements: [],
    answers: [],
    help_age_s: null,
  };
}

describe("what the screen knows", () => {
  test("an old view says nothing about now", () => {
    const view = aView();
    expect(currentView(aScene(view, 0.1), 0.5)).toBe(view);
    expect(currentView(aScene(view, 0.1), 3)).toBeNull();
    expect(currentView(aScene(view, 5), 0)).toBeNull();
    expect(currentView(aScene(null, null), 0)).toBeNull();
    expect(drivingState(null)).toBe("unknown");
  });

  test("a shuttle without a position is not on the map", () => {
    expect(mapScene("shuttle-1", aView({ has_position: false }))).toBeNull();
    expect(mapScene("shuttle-1", aView())?.vehicles[0]?.vehicle_id).toBe("shuttle-1");
  });

  test("minutes are rounded up, and not known while the shuttle waits or is held", () => {
    expect(minutesTo(VISIT, aView())).toBe(2);
    expect(minutesTo({ ...VISIT, least_s: null }, aView())).toBeNull();
    expect(minutesTo(VISIT, aView({ status: aStatus({ mode: "held" }) }))).toBeNull();
    expect(minutesTo(VISIT, aView({ status: aStatus({ waiting_for: "s1" }) }))).toBeNull();
  });

  test("the headline names what keeps people in or lets them out first", () => {
    const of = (status: object, changes: Partial<CabinView> = {}) =>
      drivingState(aView({ status: aStatus(status), ...changes }));
    expect(of({ mode: "fault", doors_open: true })).toBe("safety_stop");
    expect(of({ doors_open: true })).toBe("doors");
    expect(of({ mode: "held", speed_mps: 0 })).toBe("held");
    expect(of({ speed_mps: 2 }, { early_stop: true })).toBe("early_stop");
    expect(of({ speed_mps: 2 })).toBe("driving");
    expect(of({ speed_mps: 0, waiting_for: "s1" })).toBe("waiting");
    expect(of({ speed_mps: 0 })).toBe("standing");
  });

  test("people are counted, other shuttles are not", () => {
    const driving = aDrivingView({
      tracks: [
        [1, "pedestrian", 0, 0, 0, 0.5, 0.5, true, []],
        [2, "cyclist", 0, 0, 0, 1.8, 0.6, false, []],
        [3, "vehicle", 0, 0, 0, 4, 2, true, []],
      ],
    });
    expect(peopleSeen(aView({ status: aStatus({ driving }) }))).toEqual({ seen: 2, yielded_to: 1 });
    expect(peopleSeen(aView())).toBeNull();
  });
});
