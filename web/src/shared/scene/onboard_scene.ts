import type { components } from "../api/schema";

type Schemas = components["schemas"];

/** What one shuttle sees and plans in detail, live on request or of a run. Path and tracks are in its status. */
export type OnboardScene = Readonly<Schemas["OnboardScene"]>;
export type PathTimes = NonNullable<OnboardScene["path_times"]>;
export type TickTimes = NonNullable<OnboardScene["tick_times"]>;
