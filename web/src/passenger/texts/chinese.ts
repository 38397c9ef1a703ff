import { zh as problems } from "../../shared/texts/problem_texts_zh";
import { zh as texts } from "./texts_zh";

/** All that a passenger reads in Chinese: one file, loaded by those who read it. */
export { problems, texts };
