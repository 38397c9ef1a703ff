import { texts } from "../texts/texts";
import { DeveloperTokens } from "./developer_tokens";
import { Enrolment } from "./enrolment_form";

export function AccessPage() {
  return (
    <section class="sheet narrow">
      <header class="sheet-head">
        <h1>{texts.value.access}</h1>
      </header>
      <Enrolment />
      <DeveloperTokens />
    </section>
  );
}
