import type { OnboardScene } from "../../shared/scene/onboard_scene";
import type { Point } from "../../shared/scene/scene";

export type ShownTrack = NonNullable<OnboardScene["tracks"]>[number];
export type ShownSign = NonNullable<OnboardScene["signs"]>[number];
export type ShownScan = NonNullable<OnboardScene["scan"]>;

/** Kinds that are told apart; whatever else a shuttle may name is "other". */
export const TRACK_KINDS = ["pedestrian", "cyclist", "vehicle", "other"] as const;
export type TrackKind = (typeof TRACK_KINDS)[number];

/** What stands is drawn without an arrow. */
const MOVING_MPS = 0.2;

export function kindOf([, kind]: ShownTrack): TrackKind {
  return TRACK_KINDS.find((known) => known === kind) ?? "other";
}

export function speedOf([, , , , , , , x_mps, y_mps]: ShownTrack): number {
  return Math.hypot(x_mps, y_mps);
}

/** Corners of a track's outline, or of a square of `size_m_min` around its middle if that is larger. */
export function cornersOf(
  [, , x, y, yaw_rad, length_m, width_m]: ShownTrack,
  size_m_min: number,
): Point[] {
  const [cos, sin] = [Math.cos(yaw_rad) / 2, Math.sin(yaw_rad) / 2];
  const [length, width] = [Math.max(length_m, size_m_min), Math.max(width_m, size_m_min)];
  return (
    [
      [1, 1],
      [-1, 1],
      [-1, -1],
      [1, -1],
    ] as const
  ).map(([u, v]) => [
    x + u * length * cos - v * width * sin,
    y + u * length * sin + v * width * cos,
  ]);
}

/** The way of the next second; null for what stands. */
export function arrowOf(track: ShownTrack): readonly [Point, Point] | null {
  const [, , x, y, , , , x_mps, y_mps] = track;
  if (speedOf(track) <= MOVING_MPS) return null;
  return [
    [x, y],
    [x + x_mps, y + y_mps],
  ];
}

/** The two ends of an arrow's barbs, `size_m` long. */
export function barbsOf([from, to]: readonly [Point, Point], size_m: number): [Point, Point] {
  const back = Math.atan2(from[1] - to[1], from[0] - to[0]);
  const barb = (turn: number): Point => [
    to[0] + size_m * Math.cos(back + turn),
    to[1] + size_m * Math.sin(back + turn),
  ];
  return [barb(0.5), barb(-0.5)];
}

/** Corners of a sign's symbol on the screen, y downwards: an octagon, a triangle on its tip, or a square. */
export function signOutline(kind: ShownSign[1], radius: number): Point[] {
  const [corners, first] = { stop: [8, 22.5], yield: [3, 90], board: [4, 45], other: [4, 45] }[
    kind
  ] as [number, number];
  return Array.from({ length: corners }, (_, k) => {
    const angle = ((first + (360 / corners) * k) * Math.PI) / 180;
    return [radius * Math.cos(angle), radius * Math.sin(angle)];
  });
}

/** Tops of the lower bands of height, in metres: a kerb or a bumper, and a person. */
export const BANDS_M = [0.5, 2] as const;

/** The band of height that a point is drawn in: 0, 1 or 2. */
export function heightBand(z_m: number): number {
  return z_m < BANDS_M[0] ? 0 : z_m < BANDS_M[1] ? 1 : 2;
}

/** x0, y0, z0, x1, ... of a scan's points: map frame, heights above the ground under the rear axle. */
export function scanPoints({ x_m, y_m, offsets_cm }: ShownScan): Float64Array {
  const bytes = Uint8Array.from(atob(offsets_cm), (sign) => sign.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  const points = new Float64Array(3 * Math.floor(bytes.length / 6));
  for (let k = 0; k < points.length; k += 1)
    points[k] = view.getInt16(2 * k, true) / 100 + [x_m, y_m, 0][k % 3]!;
  return points;
}
