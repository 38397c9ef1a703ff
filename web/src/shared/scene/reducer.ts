import type { Scene, SceneMessage } from "./scene";

/** The scene after a message. A delta without a scene before it changes nothing. */
export function nextScene(scene: Scene | null, message: SceneMessage): Scene | null {
  if (message.type === "snapshot") return message.scene;
  if (scene === null) return null;
  return {
    ...scene,
    at_ms: message.at_ms,
    vehicles: merged(scene.vehicles, message.vehicles, message.vehicles_gone, (v) => v.vehicle_id),
    rides: merged(scene.rides, message.rides, message.rides_gone, (ride) => ride.ride_id),
    incidents: message.incidents ?? scene.incidents,
    areas: merged(scene.areas, message.areas, [], (area) => area.area_id),
  };
}

/** Items keep their place, so that lists on screen do not jump; new ones come last. */
function merged<T>(
  now: T[],
  changed: readonly T[],
  gone: readonly string[],
  idOf: (item: T) => string,
): T[] {
  if (changed.length === 0 && gone.length === 0) return now;
  const news = new Map(changed.map((item) => [idOf(item), item]));
  const lost = new Set(gone);
  const kept: T[] = [];
  for (const item of now) {
    const id = idOf(item);
    if (!lost.has(id)) kept.push(news.get(id) ?? item);
    news.delete(id);
  }
  for (const [id, item] of news) if (!lost.has(id)) kept.push(item);
  return kept;
}
