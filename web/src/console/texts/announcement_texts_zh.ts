import type { announcementEn } from "./announcement_texts_en";

export const announcementZh: typeof announcementEn = {
  announcements: "面向乘客的公告",
  announcements_lead: "从开始到结束，显示在站牌、手机和车内屏幕上；车辆还会语音播报。",
  announcement_zh: "中文内容",
  announcement_en: "英文内容",
  announcement_length: (left) => `还可输入 ${left} 个字符。`,
  audience: "对象",
  audiences: {
    all: "全部：站牌、手机和车辆",
    stops: "站点：站牌，以及从该站出发或到达的乘客",
    shuttles: "车辆：车内播报并显示",
  },
  which_stops: "哪些站点",
  every_stop: "所有站点",
  every_shuttle: "所有车辆",
  announcement_from: "开始时间（留空：现在）",
  announcement_until: "结束时间（留空：直到手动结束）",
  announcement_preview: "预览",
  announcement_preview_title: "向乘客发布此公告？",
  on_a_board: "站牌和手机上的样子",
  publish_announcement: "向乘客发布",
  announcement_states: { scheduled: "未开始", current: "正在显示", over: "已结束" },
  end_announcement: "结束",
  announcement_until_ended: "直到手动结束",
  announcement_ended_by: (name, time) => `由 ${name} 于 ${time} 结束`,
  no_announcements: "没有公告。",
};
