import { render } from "preact";
import "./onboard.css";
import { App } from "./app";
import { ScreenLink } from "./screen_link";

const vehicle_id = decodeURIComponent(location.pathname.split("/")[2] ?? "");
const base = `/onboard/${encodeURIComponent(vehicle_id)}`;
const link = new ScreenLink(`ws://${location.host}${base}/live`);
render(
  <App link={link} vehicle_id={vehicle_id} map_url={`${base}/map.json`} />,
  document.getElementById("app")!,
);
