import { texts } from "../texts/texts";
import { DeveloperTokenList } from "./developer_tokens";
import { EnrolmentForm } from "./enrolment_form";

export function AccessPage() {
  return (
    <section class="sheet narrow">
      <header class="sheet-head">
        <h1>{texts.value.access}</h1>
      </header>
      <EnrolmentForm />
      <DeveloperTokenList />
    </section>
  );
}
