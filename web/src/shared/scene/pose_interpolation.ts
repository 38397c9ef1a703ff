import type { Scene, VehicleScene } from "./scene";

export interface Pose {
  readonly x_m: number;
  readonly y_m: number;
  readonly yaw_rad: number;
}

interface Track {
  readonly from: Pose;
  readonly to: Pose;
  readonly start_ms: number;
  readonly span_ms: number;
}

const SPAN_MS_MIN = 50;
const SPAN_MS_MAX = 1000;
/** Farther than this between two reports is no drive but a new position. */
const JUMP_M = 15;

/**
 * Draws shuttles between the reports of their position: each is shown gliding to its newest pose within the
 * time that lay between the last two. Times are the screen's own, any monotonic milliseconds.
 */
export class Motion {
  private tracks = new Map<string, Track>();
  private until_ms = 0;

  /** still: jump at once (replay seeks, people who prefer less motion). */
  accept(scene: Scene, now_ms: number, still: boolean): void {
    const tracks = new Map<string, Track>();
    for (const vehicle of scene.vehicles) {
      if (!vehicle.located) continue;
      const track = next(this.tracks.get(vehicle.vehicle_id), vehicle, now_ms, still);
      tracks.set(vehicle.vehicle_id, track);
      this.until_ms = Math.max(this.until_ms, track.start_ms + track.span_ms);
    }
    this.tracks = tracks;
  }

  pose(vehicle: VehicleScene, now_ms: number): Pose {
    const track = this.tracks.get(vehicle.vehicle_id);
    return track === undefined ? vehicle : poseOn(track, now_ms);
  }

  isMoving(now_ms: number): boolean {
    return now_ms < this.until_ms;
  }
}

function next(track: Track | undefined, vehicle: Pose, now_ms: number, still: boolean): Track {
  const to = { x_m: vehicle.x_m, y_m: vehicle.y_m, yaw_rad: vehicle.yaw_rad };
  if (track === undefined || still) return { from: to, to, start_ms: now_ms, span_ms: 0 };
  if (samePose(track.to, to)) return track;
  const from = poseOn(track, now_ms);
  const far = Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m) > JUMP_M;
  if (far) return { from: to, to, start_ms: now_ms, span_ms: 0 };
  const span_ms = Math.min(Math.max(now_ms - track.start_ms, SPAN_MS_MIN), SPAN_MS_MAX);
  return { from, to, start_ms: now_ms, span_ms };
}

function poseOn(track: Track, now_ms: number): Pose {
  if (track.span_ms === 0) return track.to;
  const share = Math.min(Math.max((now_ms - track.start_ms) / track.span_ms, 0), 1);
  const { from, to } = track;
  return {
    x_m: from.x_m + share * (to.x_m - from.x_m),
    y_m: from.y_m + share * (to.y_m - from.y_m),
    yaw_rad: from.yaw_rad + share * wrapAngle(to.yaw_rad - from.yaw_rad),
  };
}

function samePose(a: Pose, b: Pose): boolean {
  return a.x_m === b.x_m && a.y_m === b.y_m && a.yaw_rad === b.yaw_rad;
}

/** The same angle in (-pi, pi]. */
export function wrapAngle(angle_rad: number): number {
  const turned = angle_rad % (2 * Math.PI);
  if (turned > Math.PI) return turned - 2 * Math.PI;
  return turned <= -Math.PI ? turned + 2 * Math.PI : turned;
}
