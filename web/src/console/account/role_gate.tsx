import type { ComponentChildren } from "preact";
import type { Role } from "../session";
import { may } from "../session";
import { texts } from "../texts/texts";

interface RoleGateProps {
  /** One of them suffices. */
  readonly roles: readonly Role[];
  readonly children: ComponentChildren;
}

/** Shows its children to operators with one of these roles, and tells the others which role it takes. */
export function RoleGate({ roles, children }: RoleGateProps) {
  const t = texts.value;
  if (may(...roles)) return <>{children}</>;
  return <p class="hint">{t.needs_role(roles.map((role) => t.roles[role]).join(" / "))}</p>;
}
