import { Account } from "../account/account";
import { RoleGate } from "../account/role_gate";
import { texts } from "../texts/texts";
import { DeveloperTokenList } from "./developer_tokens";
import { EnrolmentForm } from "./enrolment_form";
import { OperatorList } from "./operator_list";

export function AccessPage() {
  return (
    <section class="sheet narrow">
      <header class="sheet-head">
        <h1>{texts.value.access}</h1>
      </header>
      <Account />
      <RoleGate roles={["admin"]}>
        <OperatorList />
        <EnrolmentForm />
        <DeveloperTokenList />
      </RoleGate>
    </section>
  );
}
