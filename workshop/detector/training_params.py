"""How the detector is trained; known without PyTorch."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TrainingParams:
    """epochs over all scans; batch: scans of a step; rate_max: the learning rate's peak; seed: of all."""

    epochs: int = 32
    batch: int = 4
    rate_max: float = 4e-3
    weight_decay: float = 0.01
    seed: int = 1
