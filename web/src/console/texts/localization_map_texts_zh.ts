import type { localizationMapEn } from "./localization_map_texts_en";

export const localizationMapZh: typeof localizationMapEn = {
  localization_maps: "定位地图",
  localization_maps_lead: "车辆把扫描数据与定位地图比对。车辆自动下载生效的版本，停稳后切换。",
  no_localization_maps: "尚未存储定位地图。请用 campusloop map upload 上传。",
  localization_map_kinds: {
    points: "表面地图，供激光雷达使用",
    occupancy: "占据栅格地图，供平面扫描仪使用",
  },
  localization_map_size: (tiles, megabytes) => `${tiles} 个分块，${megabytes} MB`,
  localization_map_published: (by, when, version) => `${by} 发布于 ${when} · ${version}`,
  localization_map_activated: (by, when) => `${by} 于 ${when} 使其生效`,
  localization_map_elsewhere: "其坐标系与生效的道路地图不同，车辆不会下载。",
  localization_map_used_by: (vehicles) => `正在使用：${vehicles}`,
  localization_map_awaited: (vehicle, change) => `${vehicle}：${change}`,
  localization_map_changes: {
    "": "尚未下载",
    stored: "已下载，停稳后切换",
    not_downloaded: "无法下载，将自动重试",
    damaged: "收到损坏的分块，将自动重试",
    unsound: "无法使用",
    elsewhere: "所用道路地图的坐标系不同",
    not_stored: "磁盘空间不足",
  },
  put_localization_map_text:
    "使用此类地图的车辆会自动下载，各自停稳后切换，并保留原有版本以便回退。",
  remove_localization_map: "删除",
  remove_localization_map_text: "服务器将删除此版本及其独有的分块，之后无法回退到此版本。",
};
