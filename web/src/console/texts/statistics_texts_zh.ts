import type { statisticsEn } from "./statistics_texts_en";

export const statisticsZh: typeof statisticsEn = {
  statistics: "统计",
  figures_until: "最后一天",
  stretch: "显示",
  days_shown: (days) => (days === 1 ? "当天" : `${days} 天`),
  demand: "需求与服务",
  driving: "行驶",
  driving_is_of_a_day: "行驶数据仅显示最后一天。",
  figures_cut: "行程数量超出统计范围，请选择较少的天数。",
  events_cut: "事件数量超出统计范围，接管、停车和制动次数至少为所示数值。",
  no_rides_wanted: "这段时间没有行程需求。",
  nothing_driven: "当天没有车辆行驶。",
  rides_and_passengers: (rides, passengers) =>
    `共有 ${rides} 个行程需求，送达乘客 ${passengers} 人。`,
  waited: (half, most, nearly_all) =>
    `一半乘客等待不超过 ${half} 分钟，90% 不超过 ${most} 分钟，99% 不超过 ${nearly_all} 分钟。`,
  promises_kept: (percent) => `${percent}% 在承诺时间内上车。`,
  rides_by_hour: "各时段的行程",
  ride_outcomes: {
    completed: "已完成",
    under_way: "进行中",
    refused: "已拒绝",
    cancelled: "已取消",
    no_show: "无人上车",
    failed: "失败",
  },
  hour: "时段",
  passengers: "乘客",
  way_from: "起点",
  way_to: "终点",
  busiest_ways: "最繁忙的线路",
  numbers_of: (title) => `${title}：数据`,
  download_csv: "下载 CSV",
  driven: (km) => `约 ${km} 公里。`,
  interruptions: (takeovers, stops, brakings) =>
    `人工接管 ${takeovers} 次，最小风险停车 ${stops} 次，安全门制动 ${brakings} 次。`,
  km_per_takeover: (km) => `平均每次接管 ${km} 公里。`,
  speed_shares: "行驶速度分布（公里/时）",
  speed_from: "起始速度",
  share_percent: "占比（%）",
};
