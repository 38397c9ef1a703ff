import { poseOf, type Pose, type Scene, type VehicleScene } from "./scene";

interface PoseSegment {
  readonly from: Pose;
  readonly to: Pose;
  readonly start_ms: number;
  readonly duration_ms: number;
}

const DURATION_MS_MIN = 50;
const DURATION_MS_MAX = 1000;
/** Less than this is the noise of a shuttle that stands: moving it would only draw the map again and again. */
const STILL_M = 0.1;
const STILL_RAD = 0.03;
/** A larger distance between two reports is a new position, not a drive. */
const JUMP_M = 15;

/**
 * Poses of shuttles between their reports: each shuttle moves to its newest pose within the time that lay
 * between its last two reports. Times are milliseconds of any monotonic clock.
 */
export class PoseInterpolator {
  private segments = new Map<string, PoseSegment>();
  private until_ms = 0;

  /**
   * interpolate: false lets every shuttle jump to its pose (replay seeks, reduced motion). Returns whether a
   * shuttle came, went or moved.
   */
  update(scene: Scene, now_ms: number, interpolate: boolean): boolean {
    let has_changed = false;
    const segments = new Map<string, PoseSegment>();
    for (const vehicle of scene.vehicles) {
      const pose = poseOf(vehicle);
      if (pose === null) continue;
      const last = interpolate ? this.segments.get(vehicle.vehicle_id) : undefined;
      const segment = nextSegment(last, pose, now_ms);
      segments.set(vehicle.vehicle_id, segment);
      if (segment !== this.segments.get(vehicle.vehicle_id)) has_changed = true;
      this.until_ms = Math.max(this.until_ms, segment.start_ms + segment.duration_ms);
    }
    if (segments.size !== this.segments.size) has_changed = true;
    this.segments = segments;
    return has_changed;
  }

  /** Null for a shuttle without a status. */
  pose(vehicle: VehicleScene, now_ms: number): Pose | null {
    const segment = this.segments.get(vehicle.vehicle_id);
    return segment === undefined ? poseOf(vehicle) : poseAt(segment, now_ms);
  }

  isMoving(now_ms: number): boolean {
    return now_ms < this.until_ms;
  }
}

function nextSegment(last: PoseSegment | undefined, to: Pose, now_ms: number): PoseSegment {
  const jump = { from: to, to, start_ms: now_ms, duration_ms: 0 };
  if (last === undefined) return jump;
  if (isStill(last.to, to)) return last;
  const from = poseAt(last, now_ms);
  if (Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m) > JUMP_M) return jump;
  const duration_ms = Math.min(Math.max(now_ms - last.start_ms, DURATION_MS_MIN), DURATION_MS_MAX);
  return { from, to, start_ms: now_ms, duration_ms };
}

function poseAt({ from, to, start_ms, duration_ms }: PoseSegment, now_ms: number): Pose {
  if (duration_ms === 0) return to;
  const ratio = Math.min(Math.max((now_ms - start_ms) / duration_ms, 0), 1);
  return {
    x_m: from.x_m + ratio * (to.x_m - from.x_m),
    y_m: from.y_m + ratio * (to.y_m - from.y_m),
    yaw_rad: from.yaw_rad + ratio * wrapAngle(to.yaw_rad - from.yaw_rad),
  };
}

/** It keeps the place that it came to, so that a slow drift adds up until it shows. */
function isStill(last: Pose, next: Pose): boolean {
  const way_m = Math.hypot(next.x_m - last.x_m, next.y_m - last.y_m);
  return way_m < STILL_M && Math.abs(wrapAngle(next.yaw_rad - last.yaw_rad)) < STILL_RAD;
}

/** An angle, wrapped into (-pi, pi]. */
export function wrapAngle(angle_rad: number): number {
  const wrapped = angle_rad % (2 * Math.PI);
  if (wrapped > Math.PI) return wrapped - 2 * Math.PI;
  return wrapped <= -Math.PI ? wrapped + 2 * Math.PI : wrapped;
}
