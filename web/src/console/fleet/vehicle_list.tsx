import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { SelectField } from "../forms/select_field";
import { goTo } from "../navigation";
import { is_stale, knowledge } from "../session";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { ConditionChip } from "../vehicles/condition_chip";
import { batteryText } from "../vehicles/vehicle_status";
import type { FleetFilter } from "./fleet_order";
import { FLEET_FILTERS, inNaturalOrder, matchesQuery, passesFilter } from "./fleet_order";
import { VirtualRows } from "./virtual_rows";

/** A fleet that fits on a screen needs no search. */
const SEARCH_FROM = 8;

/** The fleet in natural order, with search and filter. */
export function VehicleList({ scene }: { readonly scene: Scene }) {
  const t = texts.value;
  const query = useSignal("");
  const filter = useSignal<FleetFilter>("all");
  const id = useId();
  const shown = inNaturalOrder(
    scene.vehicles.filter(
      (vehicle) =>
        passesFilter(vehicle, filter.value) &&
        matchesQuery(vehicle, query.value, (condition) => t.conditions[condition], stopName),
    ),
  );
  const is_large = scene.vehicles.length >= SEARCH_FROM;
  return (
    <section class="block" aria-label={t.vehicles}>
      <h2>{t.vehicles}</h2>
      {is_large && (
        <search class="fleet-search">
          <div class="field">
            <label for={id}>{t.search_vehicles}</label>
            <input
              id={id}
              type="search"
              class="input"
              value={query.value}
              onInput={(event) => {
                query.value = event.currentTarget.value;
              }}
            />
          </div>
          <SelectField
            label={t.filter_vehicles}
            value={filter.value}
            options={FLEET_FILTERS.map((each) => [each, t.fleet_filters[each]] as const)}
            onChange={(value) => {
              filter.value = value as FleetFilter;
            }}
          />
          <p class="hint" role="status">
            {t.vehicles_shown(shown.length, scene.vehicles.length)}
          </p>
        </search>
      )}
      {scene.vehicles.length === 0 && (
        <p class="empty">
          {t.no_vehicles}{" "}
          <button type="button" class="button small" onClick={() => goTo("access")}>
            {t.enrol_first}
          </button>
        </p>
      )}
      <VirtualRows items={shown} keyOf={(vehicle) => vehicle.vehicle_id}>
        {(vehicle) => <VehicleRow vehicle={vehicle} />}
      </VirtualRows>
    </section>
  );
}

function VehicleRow({ vehicle }: { readonly vehicle: VehicleScene }) {
  const t = texts.value;
  const { facts, status, task } = vehicle;
  return (
    <button type="button" class="row" onClick={() => goTo("live", vehicle.vehicle_id)}>
      <span class="row-head">
        <strong>{facts.name}</strong>
        <ConditionChip vehicle={vehicle} knowledge={knowledge.value} />
      </span>
      <span class="row-facts">
        {!facts.in_service && <span>{t.out_of_service}</span>}
        {status !== null && !is_stale.value && (
          <span>{t.kmh((status.speed_mps * 3.6).toFixed(0))}</span>
        )}
        <span>{t.seats_taken(task.people_aboard, facts.seats)}</span>
        {status !== null && (
          <span>{status.battery_ratio > 0 ? batteryText(status) : t.battery_unknown}</span>
        )}
        {task.next_stop !== "" && <span>→ {stopName(task.next_stop)}</span>}
      </span>
    </button>
  );
}
