import { render } from "preact";
import { loadCampus } from "./campus/campus";
import "../shared/ui/theme.css";
import "../shared/ui/controls.css";
import "./passenger.css";
import { App } from "./app";
import { keepForOffline } from "./offline";
import { deliverKeptCancels } from "./ride/ride_tracker";

keepForOffline();
void loadCampus();
deliverKeptCancels();
render(<App />, document.getElementById("app")!);
