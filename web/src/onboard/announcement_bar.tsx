import { language } from "../shared/texts/language";
import type { ScreenLink } from "./screen_link";
import type { Answer, CabinView } from "./screen_scene";
import { texts } from "./texts/texts";

const ANSWER_SHOWN_S = 12;
const ANNOUNCEMENT_SHOWN_S = 60;
const HELP_SHOWN_S = 600;

/** What is announced, what the shuttle answered to the last touch, and whether help is on its way. */
export function AnnouncementBar({
  link,
  view,
}: {
  readonly link: ScreenLink;
  readonly view: CabinView | null;
}) {
  const t = texts.value;
  const scene = link.scene.value;
  const said = scene?.announcements.at(-1);
  const answer = scene?.answers.at(-1);
  const is_current = said !== undefined && said.age_s <= ANNOUNCEMENT_SHOWN_S;
  const help_age_s = scene?.help_age_s ?? null;
  return (
    <footer aria-label={t.announcements}>
      {view?.shown != null && (
        <p class="standing" role="status">
          {language.value === "en" ? view.shown.text : view.shown.text_zh}
        </p>
      )}
      <p class="said" role="status">
        {!is_current
          ? t.no_announcement
          : language.value === "en"
            ? said.text || said.text_zh
            : said.text_zh || said.text}
      </p>
      <p class="answer" role="status">
        {link.refused.value
          ? t.too_many
          : answer !== undefined && answer.age_s <= ANSWER_SHOWN_S
            ? answerText(answer)
            : help_age_s !== null && help_age_s <= HELP_SHOWN_S
              ? view?.connected === true
                ? t.help_sent
                : t.help_waits
              : ""}
      </p>
    </footer>
  );
}

function answerText({ body }: Answer): string {
  const t = texts.value;
  if (body.event === "seat_button_pressed" && body.accepted === false) return t.stop_refused;
  return t.answers[body.event];
}
