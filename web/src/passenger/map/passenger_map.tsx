import { useComputed } from "@preact/signals";
import type { CampusGeometry } from "../../shared/campus/campus_geometry";
import { CampusMap } from "../../shared/map/campus_map";
import type { MapContent } from "../../shared/map/map_content";
import { prefersReducedMotion } from "../../shared/map/reduced_motion";
import { poseOf, type Point } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { destination, pickup, tapStop } from "../booking/ride_request";
import type { Campus } from "../campus/campus";
import { trackedRide } from "../ride/tracked_ride";
import { texts } from "../texts/texts";

export interface PassengerMapProps {
  readonly campus: Campus;
  readonly geometry: CampusGeometry;
}

/** The map: a passenger chooses stops on it, and later follows the shuttle. */
export function PassengerMap({ campus, geometry }: PassengerMapProps) {
  const ride = trackedRide.value;
  const ticket = ride?.ticket.value ?? null;
  const content = useComputed<MapContent>(() => {
    const shown = trackedRide.value;
    const shown_ticket = shown?.ticket.value ?? null;
    const ended = shown?.progress.value?.ended ?? false;
    return {
      scene: ended ? null : (shown?.link.scene.value ?? null),
      pickup: shown === null ? pickup.value : (shown_ticket?.from_stop ?? ""),
      destination: shown === null ? destination.value : (shown_ticket?.to_stop ?? ""),
      selected_vehicle: shown?.vehicle.value?.vehicle_id ?? "",
      language: language.value,
      interpolate: !prefersReducedMotion.value,
    };
  });
  const focus = useComputed<readonly Point[]>(() => {
    const shown = trackedRide.value;
    const shown_ticket = shown?.ticket.value ?? null;
    const ends = campus.stops.filter(
      (stop) =>
        shown_ticket === null ||
        stop.stop_id === shown_ticket.from_stop ||
        stop.stop_id === shown_ticket.to_stop,
    );
    const points: Point[] = ends.map((stop) => [stop.x_m, stop.y_m]);
    const vehicle = shown?.progress.value?.ended === false ? shown.vehicle.value : null;
    const pose = vehicle === null ? null : poseOf(vehicle);
    if (pose !== null) points.push([pose.x_m, pose.y_m]);
    return points;
  });
  return (
    <CampusMap
      geometry={geometry}
      content={content.value}
      focus={focus.value}
      focus_key={ticket?.ride_id ?? ""}
      attribution={campus.view.attribution}
      texts={{
        map: texts.value.map,
        zoom_in: texts.value.zoom_in,
        zoom_out: texts.value.zoom_out,
        show_all: texts.value.whole_map,
      }}
      onSelect={(selection) => {
        if (ride === null && selection.kind === "stop") tapStop(selection.id);
      }}
    />
  );
}
