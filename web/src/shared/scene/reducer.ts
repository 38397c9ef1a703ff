import type { Scene, SceneMessage } from "./scene";

/** The scene after a message. A delta without a scene before it changes nothing. */
export function nextScene(scene: Scene | null, message: SceneMessage): Scene | null {
  if (message.type === "snapshot") return message.scene;
  if (scene === null) return null;
  return {
    ...scene,
    at_ms: message.at_ms,
    vehicles: mergeById(
      scene.vehicles,
      message.vehicles,
      message.vehicles_gone,
      (v) => v.vehicle_id,
    ),
    rides: mergeById(scene.rides, message.rides, message.rides_gone, (ride) => ride.ride_id),
    incidents: message.incidents ?? scene.incidents,
    areas: mergeById(scene.areas, message.areas, [], (area) => area.area_id),
  };
}

/** Items keep their order, so that lists on the screen do not jump; new items come last. */
function mergeById<T>(
  items: T[],
  changed: readonly T[],
  removed_ids: readonly string[],
  idOf: (item: T) => string,
): T[] {
  if (changed.length === 0 && removed_ids.length === 0) return items;
  const updates = new Map(changed.map((item) => [idOf(item), item]));
  const removed = new Set(removed_ids);
  const merged: T[] = [];
  for (const item of items) {
    const id = idOf(item);
    if (!removed.has(id)) merged.push(updates.get(id) ?? item);
    updates.delete(id);
  }
  for (const [id, item] of updates) if (!removed.has(id)) merged.push(item);
  return merged;
}
