import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { useEffect } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import type { CampusGeometry } from "../../shared/campus/campus_geometry";
import { campusGeometry } from "../../shared/campus/campus_geometry";
import type { Campus } from "../campus/campus";
import { texts } from "../texts/texts";
import type { PassengerMapProps } from "./passenger_map";

interface Drawing {
  readonly Map: ComponentType<PassengerMapProps>;
  readonly geometry: CampusGeometry;
}

type State = "loading" | "failed" | Drawing;

const state = signal<State>("loading");

/** Draws the map when there is time for it: the form stands first, and works without it. */
export function MapArea({ campus }: { readonly campus: Campus }) {
  const { map_version, attribution } = campus.view;
  useEffect(() => {
    const drawn = state.peek();
    if (typeof drawn === "string" || drawn.geometry.map_version !== map_version) void load();
  }, [map_version]);
  const shown = state.value;
  if (typeof shown !== "string") return <shown.Map campus={campus} geometry={shown.geometry} />;
  const t = texts.value;
  return (
    <div class="map map-waiting" aria-busy={shown === "loading"}>
      <p>{shown === "loading" ? t.loading_map : t.map_failed}</p>
      {shown === "failed" && (
        <button type="button" class="button" onClick={() => void load()}>
          {t.try_again}
        </button>
      )}
      {/* In its place from the first paint on: it is the largest text, and does not come late with the map. */}
      {attribution !== "" && <p class="map-credit">{attribution}</p>}
    </div>
  );
}

/** The drawing code is a file of its own; it and the map's data may both fail to come. */
async function load(): Promise<void> {
  if (typeof state.peek() === "string") state.value = "loading";
  const [code, geometry] = await Promise.all([
    import("./passenger_map").catch((error: unknown) => {
      console.info("the map's code did not come", error);
      return null;
    }),
    resultOf(api.GET("/api/v1/campus/map")),
  ]);
  state.value =
    code === null || !geometry.ok
      ? "failed"
      : { Map: code.PassengerMap, geometry: campusGeometry(geometry.value) };
}
