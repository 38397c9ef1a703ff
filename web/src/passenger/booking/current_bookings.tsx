import { Alert } from "../../shared/ui/alerts";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { lastRideToken, lastSeriesToken } from "../token_storage";

export function CurrentRideAlert() {
  const token = lastRideToken();
  if (token === null) return null;
  return (
    <Alert>
      <p>{texts.value.current_ride}</p>
      <button type="button" class="button small" onClick={() => goTo({ view: "ride", token })}>
        {texts.value.show_ride}
      </button>
    </Alert>
  );
}

export function CurrentSeriesButton() {
  const token = lastSeriesToken();
  if (token === null) return null;
  return (
    <button
      type="button"
      class="button quiet small"
      onClick={() => goTo({ view: "series", token })}
    >
      {texts.value.my_series}
    </button>
  );
}
