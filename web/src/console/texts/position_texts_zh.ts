import type { positionEn } from "./position_texts_en";

export const positionZh: typeof positionEn = {
  localization: "定位",
  localization_phases: {
    waiting: "等待卫星信号，或由您指定位置",
    tracking: "扫描与地图一致",
    doubtful: "定位存疑，低速行驶",
    lost: "定位丢失，停车搜索",
    recovered: "已重新定位",
    gnss_only: "仅卫星定位",
  },
  position_deviation: (phase, deviation) => `${phase}，± ${deviation}`,
  named_position: "指定车辆位置",
  named_position_hint:
    "用于已停车但不知道自身位置的车辆。车辆会将激光雷达所见与该处 10 米内的地图比对。",
  name_position: "在地图上选择",
  click_place: "请在地图上点击车辆所在位置。",
  click_direction: "再点击车头所指的方向。",
  position_chosen: (x_m, y_m) => `已选择：东 ${x_m} 米，北 ${y_m} 米。再次点击将重新选择。`,
  confirm_position: "车辆在此处",
  position_sent: "已发送。车辆将在 20 秒内答复，结果显示在最近指令处。",
};
