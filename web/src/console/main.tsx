import { render } from "preact";
import { loadCampus } from "../shared/campus/campus";
import "./console.css";
import "./texts/problem_texts";
import { App } from "./app";
import { restoreSession } from "./session";

void loadCampus();
void restoreSession();
render(<App />, document.getElementById("app")!);
