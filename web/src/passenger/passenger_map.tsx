import { useComputed } from "@preact/signals";
import type { Campus } from "../shared/campus/campus";
import { CampusMap } from "../shared/map/campus_map";
import type { Look } from "../shared/map/map_view";
import { prefersStill } from "../shared/map/reduced_motion";
import type { Point } from "../shared/scene/scene";
import { language } from "../shared/texts/language";
import { destination, pickup, tapStop } from "./booking/ride_request";
import { followed } from "./ride/ride_tracker";
import { texts } from "./texts/texts";

/** The map: for choosing stops while booking, for watching the shuttle afterwards. */
export function Stage({ campus }: { readonly campus: Campus }) {
  const ride = followed.value;
  const ticket = ride?.ticket.value ?? null;
  const look = useComputed<Look>(() => {
    const shown = followed.value;
    const shown_ticket = shown?.ticket.value ?? null;
    const ended = shown?.story.value?.ended ?? false;
    return {
      scene: ended ? null : (shown?.link.scene.value ?? null),
      pickup: shown === null ? pickup.value : (shown_ticket?.from_stop ?? ""),
      destination: shown === null ? destination.value : (shown_ticket?.to_stop ?? ""),
      chosen_vehicle: shown?.vehicle.value?.vehicle_id ?? "",
      language: language.value,
      still: prefersStill.value,
    };
  });
  const focus = useComputed<readonly Point[]>(() => {
    const shown = followed.value;
    const shown_ticket = shown?.ticket.value ?? null;
    const ends = campus.shape.stops.filter(
      (stop) =>
        shown_ticket === null ||
        stop.stop_id === shown_ticket.from_stop ||
        stop.stop_id === shown_ticket.to_stop,
    );
    const points: Point[] = ends.map((stop) => [stop.x_m, stop.y_m]);
    const vehicle = shown?.story.value?.ended === false ? shown.vehicle.value : null;
    if (vehicle?.located === true) points.push([vehicle.x_m, vehicle.y_m]);
    return points;
  });
  return (
    <CampusMap
      shape={campus.shape}
      look={look.value}
      focus={focus.value}
      focus_key={ticket?.ride_id ?? ""}
      attribution={campus.view.attribution}
      texts={{
        map: texts.value.map,
        zoom_in: texts.value.zoom_in,
        zoom_out: texts.value.zoom_out,
        whole: texts.value.whole_map,
      }}
      onPick={(what) => {
        if (ride === null && what.kind === "stop") tapStop(what.id);
      }}
    />
  );
}
