"""How wrong the network's answer to a batch is."""

import torch
from torch import Tensor
from torch.nn import functional

from workshop.detector.targets import Targets


def losses_of(heat: Tensor, boxes: Tensor, targets: Targets) -> dict[str, Tensor]:
    """Losses by name; their sum is what training lessens. Targets are stacked over the batch.

    heat as logits: the focal loss of middles (Law and Deng 2018, equation 1); boxes: absolute errors, and
    the cross-entropy of the direction.
    """
    wanted, weight = torch.from_numpy(targets.heat), torch.from_numpy(targets.heat_weight)
    is_middle = (wanted > 0.999).float()
    count = is_middle.sum().clamp(min=1.0)
    found = torch.sigmoid(heat)
    hit = is_middle * (1.0 - found) ** 2 * functional.logsigmoid(heat)
    miss = (1.0 - is_middle) * (1.0 - wanted) ** 4 * found**2 * functional.logsigmoid(-heat)
    box_weight = torch.from_numpy(targets.box_weight)[:, None]
    turned = torch.from_numpy(targets.turned_weight)[:, None]
    true_boxes = torch.from_numpy(targets.boxes)
    total = box_weight.sum().clamp(min=1.0)
    apart = functional.smooth_l1_loss(boxes[:, :9], true_boxes[:, :9], reduction="none", beta=0.05)
    direction = functional.binary_cross_entropy_with_logits(boxes[:, 9:], true_boxes[:, 9:], reduction="none")
    return {
        "heat": -((hit + miss) * weight).sum() / count,
        "offset": 2.0 * (apart[:, :2] * box_weight).sum() / total,
        "size": (apart[:, 2:5] * box_weight).sum() / total,
        "yaw": (apart[:, 5:7] * turned).sum() / turned.sum().clamp(min=1.0),
        "velocity": 0.7 * (apart[:, 7:9] * box_weight).sum() / total,
        "direction": 0.2 * (direction * turned).sum() / turned.sum().clamp(min=1.0),
    }
