import { render } from "preact";
import { loadCampus } from "./campus/campus";
import "./passenger.css";
import { language } from "../shared/texts/language";
import { App } from "./app";
import { loadLaterViews } from "./later/later_views";
import { address } from "./navigation";
import { keepForOffline } from "./offline";
import { PageMissing } from "./page_missing";
import { showLanguage } from "./texts/texts";

keepForOffline();
const campus = loadCampus();
if (address.value.view !== "book") void loadLaterViews();
const root = document.getElementById("app")!;
const has_texts = await showLanguage(language.value);
render(has_texts ? <App /> : <PageMissing />, root);
await campus;
await loadLaterViews();
