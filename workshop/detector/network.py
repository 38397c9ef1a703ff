"""The detector's network: features of pillars, a bird's-eye convolution net, and a head of heat and boxes.

After VoxelNet (Zhou and Tuzel 2018, sections 2.1.1 to 2.1.3), with pillars for voxels (Lang et al. 2019) and
middles for anchors (Yin et al. 2021). Small, so that one processor core runs and trains it.
"""

import torch
from torch import Tensor, nn

from vehicle_agent.perception.pillars.grid import FEATURES, PillarGrid
from workshop.detector.targets import BOX_CHANNELS, KINDS

_PILLAR_CHANNELS = 16
_WIDTHS = (24, 48, 80)
_SHARED = 32


class PillarNetwork(nn.Module):  # type: ignore[misc]
    """features (p, points_max, FEATURES), cells (p,) -> heat (b, kinds, h, w) logits, boxes (b, 10, h, w)."""

    def __init__(self, grid: PillarGrid) -> None:
        super().__init__()
        self.grid = grid
        self.points = nn.Linear(FEATURES, 32)
        self.pillars = nn.Linear(32, _PILLAR_CHANNELS)
        one, two, three = _WIDTHS
        # The older turn's squares are channels of their own, so that motion shows as a shift between both.
        self.first = nn.Sequential(_block(2 * _PILLAR_CHANNELS, one, 2), _block(one, one))
        self.second = nn.Sequential(_block(one, two, 2), _block(two, two), _block(two, two))
        self.third = nn.Sequential(_block(two, three, 2), _block(three, three), _block(three, three))
        self.from_second, self.from_third = nn.Conv2d(two, one, 1), nn.Conv2d(three, one, 1)
        self.shared = _block(one, _SHARED)
        self.heat = nn.Conv2d(_SHARED, len(KINDS), 1)
        self.boxes = nn.Conv2d(_SHARED, BOX_CHANNELS, 1)
        # One cell in a hundred is a middle at first.
        nn.init.constant_(self.heat.bias, -4.6)

    def forward(
        self, features: Tensor, cells: Tensor, scans: int = 1, size: tuple[int, int] | None = None
    ) -> tuple[Tensor, Tensor]:
        """size: pillars along y and x; None for those of the grid."""
        ny, nx = size or (self.grid.ny, self.grid.nx)
        of_points = torch.relu(self.points(features))
        of_pillars = torch.relu(self.pillars(of_points.max(dim=1).values))
        canvas = torch.zeros(scans * 2 * nx * ny, _PILLAR_CHANNELS, dtype=features.dtype)
        canvas = canvas.index_put((cells,), of_pillars)
        canvas = canvas.reshape(scans, 2, ny, nx, _PILLAR_CHANNELS).permute(0, 1, 4, 2, 3)
        one = self.first(canvas.reshape(scans, 2 * _PILLAR_CHANNELS, ny, nx))
        two = self.second(one)
        three = self.third(two)
        size = (ny // 2, nx // 2)
        merged = one + _enlarged(self.from_second(two), size) + _enlarged(self.from_third(three), size)
        shared = self.shared(torch.relu(merged))
        return self.heat(shared), self.boxes(shared)


def _enlarged(picture: Tensor, size: tuple[int, int]) -> Tensor:
    return nn.functional.interpolate(picture, size=size, mode="nearest")


def _block(channels_in: int, channels_out: int, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(channels_in, channels_out, 3, stride, 1, bias=False),
        nn.BatchNorm2d(channels_out),
        nn.ReLU(inplace=True),
    )
