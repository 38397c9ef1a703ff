import { render } from "preact";
import { language } from "../shared/texts/language";
import "./board.css";
import { App } from "./app";
import { BoardTracker } from "./board_tracker";

// A screen has no one to choose its language: the address can.
const asked = new URLSearchParams(location.search).get("lang");
if (asked === "en") language.value = "en";
if (asked === "zh") language.value = "zh-CN";

const stop_id = decodeURIComponent(location.pathname.split("/")[2] ?? "");
render(<App tracker={new BoardTracker(stop_id)} />, document.getElementById("app")!);
