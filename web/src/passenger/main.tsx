import { render } from "preact";
import { loadCampus } from "../shared/campus/campus";
import "../shared/ui/theme.css";
import "../shared/ui/controls.css";
import "./passenger.css";
import { App } from "./app";

void loadCampus();
render(<App />, document.getElementById("app")!);
