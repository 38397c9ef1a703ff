import { en as problems } from "../../shared/texts/problem_texts_en";
import { en as texts } from "./texts_en";

/** All that a passenger reads in English: one file, loaded by those who read it. */
export { problems, texts };
