"""Training of the detector on one processor core, which can be stopped and taken up again."""

import pickle
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch

from vehicle_agent.perception.pillars.grid import STRIDE, PillarGrid
from workshop.detector.batches import Batch, batch_of
from workshop.detector.labeled_scans import LabeledScan, read_scan
from workshop.detector.losses import losses_of
from workshop.detector.network import PillarNetwork
from workshop.detector.training_params import TrainingParams

_WARMUP_SHARE = 0.1
_AHEAD = 1e-3


class CheckpointError(Exception):
    """The checkpoint is of another training, or cannot be read."""


@dataclass(slots=True)
class TrainingState:
    """What a checkpoint has. losses: means of each epoch by name, and those of the scans for tuning."""

    network: PillarNetwork
    optimizer: torch.optim.Optimizer
    rng: np.random.Generator
    epoch: int = 0
    cpu_s: float = 0.0
    losses: list[dict[str, float]] = field(default_factory=list)


def train(
    paths: Sequence[Path],
    tuning: Sequence[Path],
    grid: PillarGrid,
    params: TrainingParams,
    checkpoint: Path,
    advance: Callable[[int, dict[str, float]], None],
) -> TrainingState:
    """Trains, or goes on from the checkpoint of the same training; a checkpoint is written after each epoch.

    paths, tuning  files of labeled scans to learn from, and to say how well others are answered
    advance        is called after each step with 1 and the losses; at the start with the steps already done
    Raises CheckpointError, ScanFileError, OSError. The same seed, scans and machine give the same network.
    """
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    identity = {"params": asdict(params), "grid": grid._asdict(), "scans": [path.name for path in paths]}
    state = _resumed(checkpoint, identity, grid, params)
    steps = len(paths) // params.batch
    advance(state.epoch * steps, {})
    begun_s = time.process_time() - state.cpu_s
    while state.epoch < params.epochs:
        order = state.rng.permutation(len(paths))
        means: dict[str, float] = {}
        for step in range(steps):
            rate = _rate((state.epoch * steps + step) / (params.epochs * steps), params.rate_max)
            chosen = [read_scan(paths[index]) for index in order[step * params.batch :][: params.batch]]
            losses = _step(state, chosen, grid, rate)
            for name, value in losses.items():
                means[name] = means.get(name, 0.0) + value / steps
            advance(1, losses)
        state.epoch += 1
        means |= {
            f"tune_{name}": value for name, value in _losses_on(state.network, tuning, grid, params).items()
        }
        state.losses.append(means)
        state.cpu_s = time.process_time() - begun_s
        _write_checkpoint(checkpoint, identity, state)
    state.network.eval()
    return state


def _step(state: TrainingState, scans: list[LabeledScan], grid: PillarGrid, rate: float) -> dict[str, float]:
    state.network.train()
    for group in state.optimizer.param_groups:
        group["lr"] = rate
    batch = batch_of(scans, grid, state.rng)
    heat, boxes = state.network(
        torch.from_numpy(batch.features), torch.from_numpy(batch.cells), len(scans), _size_of(batch)
    )
    losses = losses_of(heat, boxes, batch.targets)
    total = torch.stack(list(losses.values())).sum()
    state.optimizer.zero_grad()
    total.backward()
    torch.nn.utils.clip_grad_norm_(state.network.parameters(), 10.0)
    state.optimizer.step()
    return {name: float(value.detach()) for name, value in losses.items()}


def _size_of(batch: Batch) -> tuple[int, int]:
    h, w = batch.targets.box_weight.shape[1:]
    return STRIDE * h, STRIDE * w


def _losses_on(
    network: PillarNetwork, paths: Sequence[Path], grid: PillarGrid, params: TrainingParams
) -> dict[str, float]:
    """Mean losses on scans as they are."""
    network.eval()
    means: dict[str, float] = {}
    with torch.no_grad():
        for first in range(0, len(paths), params.batch):
            chosen = [read_scan(path) for path in paths[first : first + params.batch]]
            batch = batch_of(chosen, grid)
            heat, boxes = network(
                torch.from_numpy(batch.features), torch.from_numpy(batch.cells), len(chosen)
            )
            for name, value in losses_of(heat, boxes, batch.targets).items():
                means[name] = means.get(name, 0.0) + float(value) * len(chosen) / len(paths)
    return means


def _rate(share: float, rate_max: float) -> float:
    """One cycle: up to the peak, then down to a thousandth by a cosine."""
    if share < _WARMUP_SHARE:
        return rate_max * (0.1 + 0.9 * share / _WARMUP_SHARE)
    down = (share - _WARMUP_SHARE) / (1.0 - _WARMUP_SHARE)
    return rate_max * (_AHEAD + (1.0 - _AHEAD) * 0.5 * (1.0 + float(np.cos(np.pi * down))))


def _resumed(
    checkpoint: Path, identity: dict[str, Any], grid: PillarGrid, params: TrainingParams
) -> TrainingState:
    torch.manual_seed(params.seed)
    network: PillarNetwork = PillarNetwork(grid).to(memory_format=torch.channels_last)
    optimizer = torch.optim.AdamW(network.parameters(), params.rate_max, weight_decay=params.weight_decay)
    state = TrainingState(network, optimizer, np.random.default_rng([params.seed, *b"training"]))
    if not checkpoint.exists():
        return state
    try:
        stored = torch.load(checkpoint, weights_only=True)
    except (OSError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        raise CheckpointError(f"{checkpoint} cannot be read: remove it to begin again") from error
    if stored.get("identity") != identity:
        raise CheckpointError(f"{checkpoint} is of another training: remove it, or give the same options")
    network.load_state_dict(stored["network"])
    optimizer.load_state_dict(stored["optimizer"])
    state.rng.bit_generator.state = stored["rng"]
    state.epoch, state.cpu_s, state.losses = stored["epoch"], stored["cpu_s"], stored["losses"]
    return state


def _write_checkpoint(checkpoint: Path, identity: dict[str, Any], state: TrainingState) -> None:
    part = checkpoint.with_suffix(".part")
    torch.save(
        {
            "identity": identity, "network": state.network.state_dict(),
            "optimizer": state.optimizer.state_dict(), "rng": state.rng.bit_generator.state,
            "epoch": state.epoch, "cpu_s": state.cpu_s, "losses": state.losses,
        },
        part,
    )  # fmt: skip
    part.replace(checkpoint)
