import { campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";

export function stopTitle(stop_id: string): string {
  return nameOfStop(campus.value?.shape.stops ?? [], stop_id, language.value);
}
