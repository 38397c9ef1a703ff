// Stands in for the live websocket of the console: a fleet that drives to and fro on the lanes of the campus,
// reported whole five times a second. Messages are made before the measurement; the page parses each anew.
((vehicles, hz, cycle_s) => {
  const Real = window.WebSocket;
  const TO_AND_FRO_M = 12;

  class FleetSocket {
    onopen = null;
    onmessage = null;
    onclose = null;
    timer = 0;

    constructor() {
      void this.begin();
    }

    async begin() {
      const map = await (await fetch("/api/v1/campus/map")).json();
      const messages = messagesOf(map);
      this.deltas = messages.deltas;
      window.__fleet_socket = this;
      this.onopen?.();
      this.say(JSON.stringify(snapshotOf(map, messages.first)));
      let number = 0;
      this.timer = setInterval(() => {
        number = (number + 1) % messages.deltas.length;
        this.say(messages.deltas[number].replace('"AT_MS"', String(Date.now())));
      }, 1000 / hz);
    }

    // So many messages, as fast as the page takes them, each 1/hz later than the one before by its own time.
    async play(count, at_once) {
      clearInterval(this.timer);
      this.at_ms ??= Date.now();
      for (let number = 0; number < count; number += 1) {
        this.at_ms += 1000 / hz;
        this.say(this.deltas[number % this.deltas.length].replace('"AT_MS"', String(this.at_ms)));
        if (number % at_once === 0) await new Promise((resolve) => setTimeout(resolve));
      }
    }

    say(data) {
      this.onmessage?.({ data });
    }

    send() {}

    close() {
      clearInterval(this.timer);
    }
  }

  function messagesOf(map) {
    const roads = map.lanes.filter((lane) => lane.kind === "road" && lengthOf(lane.xy) > 2 * TO_AND_FRO_M);
    const count = Math.round(cycle_s * hz);
    const deltas = [];
    let first = null;
    for (let step = 0; step < count; step += 1) {
      const phase = Math.abs(1 - (2 * step) / count);
      const fleet = Array.from({ length: vehicles }, (_, index) => vehicleAt(map, roads, index, phase));
      first ??= fleet;
      deltas.push(
        JSON.stringify({ type: "delta", at_ms: "AT_MS", vehicles: fleet, vehicles_gone: [], rides: [],
          rides_gone: [], incidents: null, areas: [] }),
      );
    }
    return { first, deltas };
  }

  function snapshotOf(map, fleet) {
    const incidents = { open: 0, unacknowledged: 0, help_calls: 0, serial: 0 };
    const scene = { at_ms: Date.now(), campus_id: "campus", map_version: map.map_version, vehicles: fleet,
      rides: [], incidents, areas: [] };
    return { type: "snapshot", scene };
  }

  function vehicleAt(map, roads, index, phase) {
    const road = roads[index % roads.length];
    const start_m = (index * 37) % Math.max(1, lengthOf(road.xy) - 2 * TO_AND_FRO_M);
    const [x_m, y_m, yaw_rad] = poseAt(road.xy, start_m + TO_AND_FRO_M * phase);
    const stop = map.stops[index % map.stops.length];
    const route = Array.from({ length: Math.min(20, road.xy.length / 2) }, (_, i) => [road.xy[2 * i], road.xy[2 * i + 1]]);
    const id = `shuttle-${index + 1}`;
    const visit = { visit_id: `visit-${index}`, kind: "stop", stop_id: stop.stop_id, state: "pending", why: "",
      eta_ms: 0, boarding: 1, alighting: 0 };
    return {
      vehicle_id: id,
      facts: { name: `Shuttle ${index + 1}`, seats: 6, wheelchair_places: 1, connected: true,
        held: index % 17 === 0, in_service: true, charging: false, mode: "autonomous" },
      task: { next_stop: stop.stop_id, people_aboard: index % 5, at_charger: false, route, visits: [visit],
        order_waits: false, hold_ends_ms: 0, charged_at_ms: 0 },
      status: { type: "status", epoch: 1, stamp_ns: 0, pose_map: [x_m, y_m, yaw_rad], speed_mps: 3, accel_mps2: 0,
        steer_rad: 0, mode: "autonomous", battery_ratio: 0.3 + (index % 60) / 100, doors_open: false,
        lane_id: road.lane_id, s_m: start_m, order_id: `order-${index}`, revision: 1, visit_id: `visit-${index}`,
        aboard: [], screen: "→ " + stop.name_en, spoken: "", obstacle_m: null, waiting_for: "", faults: [],
        hold_reason: null, hold_detail: "", driving: null },
      heard_ms: Date.now(),
      command: null,
    };
  }

  function lengthOf(xy) {
    let sum = 0;
    for (let i = 2; i < xy.length; i += 2) sum += Math.hypot(xy[i] - xy[i - 2], xy[i + 1] - xy[i - 1]);
    return sum;
  }

  function poseAt(xy, s_m) {
    let left = s_m;
    for (let i = 2; i < xy.length; i += 2) {
      const [dx, dy] = [xy[i] - xy[i - 2], xy[i + 1] - xy[i - 1]];
      const piece = Math.hypot(dx, dy);
      if (left <= piece || i + 2 >= xy.length) {
        const part = piece === 0 ? 0 : Math.min(1, left / piece);
        return [xy[i - 2] + part * dx, xy[i - 1] + part * dy, Math.atan2(dy, dx)];
      }
      left -= piece;
    }
    return [xy[0], xy[1], 0];
  }

  window.WebSocket = new Proxy(Real, {
    construct: (target, [url, ...rest]) =>
      String(url).endsWith("/ws/live") ? new FleetSocket() : new target(url, ...rest),
  });
})
