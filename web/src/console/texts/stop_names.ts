import { campus } from "../../shared/campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";

/** The stop's name in the user's language. */
export function stopName(stop_id: string): string {
  return stopNameById(campus.value?.geometry.stops ?? [], stop_id, language.value);
}
