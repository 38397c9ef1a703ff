import type { VehicleScene } from "../../shared/scene/scene";
import { withNames } from "../texts/names";
import { texts } from "../texts/texts";
import { formatTimeWithSeconds } from "../texts/times";

/** The newest command to a shuttle and how it ended: why it was refused, or what came of it. */
export function LastCommand({ command }: { readonly command: VehicleScene["command"] }) {
  if (command === null) return null;
  const t = texts.value;
  const given = t.last_command(
    t.commands[command.kind],
    formatTimeWithSeconds(command.made_ms),
    command.by,
  );
  return (
    <p class={`last-command ${command.state}`}>
      {given} <strong>{t.command_states[command.state]}</strong>
      {command.detail !== "" && `: ${withNames(command.detail)}`}
    </p>
  );
}
