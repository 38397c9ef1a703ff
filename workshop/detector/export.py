"""A trained network as a file that the vehicle runs, checked against the network itself."""

import hashlib
import io
import math
import warnings
from datetime import UTC, datetime
from pathlib import Path

import msgspec
import numpy as np
import onnx
import onnxruntime
import torch

from vehicle_agent.perception.pillars.detector_file import VERSION, DetectorRecord, record_path
from vehicle_agent.perception.pillars.grid import FEATURES, Pillars
from workshop.detector.network import PillarNetwork
from workshop.detector.training import TrainingState
from workshop.detector.training_params import TrainingParams

LICENSE = "Apache-2.0"
_AGREE = 1e-4
_ZEROS_MIN = 10_000


class ExportError(Exception):
    """The file does not answer as the network does."""


def exported(network: PillarNetwork, samples: list[Pillars]) -> bytes:
    """The ONNX file. Raises ExportError if it answers any of the samples otherwise by more than 1e-4."""
    network.eval()
    first = samples[0]
    inputs = (torch.from_numpy(first.features), torch.from_numpy(first.cells))
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        # The exporter without further packages is the older one, which says so.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            _OneScan(network).eval(), inputs, buffer, dynamo=False, opset_version=17,
            input_names=["features", "cells"], output_names=["heat", "boxes"],
            dynamic_axes={"features": {0: "pillars"}, "cells": {0: "pillars"}},
        )  # fmt: skip
    model = _without_zeros(buffer.getvalue())
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    for sample in samples:
        heat, boxes = session.run(["heat", "boxes"], {"features": sample.features, "cells": sample.cells})
        with torch.no_grad():
            wanted = network(torch.from_numpy(sample.features), torch.from_numpy(sample.cells))
        for name, answer, true in (("heat", heat, wanted[0]), ("boxes", boxes, wanted[1])):
            apart = np.abs(answer - true.numpy()) / np.maximum(1.0, np.abs(true.numpy()))
            if not apart.max() <= _AGREE:
                raise ExportError(f"{name} of the file and of the network differ by {apart.max():.2g}")
    return model


def _without_zeros(model: bytes) -> bytes:
    """The same model; the empty ground is made when it runs, not stored as the greatest part of the file."""
    graph = onnx.load_model_from_string(model)
    nodes = []
    for node in graph.graph.node:
        stored = node.attribute[0].t if node.op_type == "Constant" and node.attribute else None
        if stored is None or math.prod(stored.dims) < _ZEROS_MIN or onnx.numpy_helper.to_array(stored).any():
            nodes.append(node)
            continue
        shape = onnx.numpy_helper.from_array(np.array(stored.dims, dtype=np.int64))
        name = f"{node.output[0]}_shape"
        nodes.append(onnx.helper.make_node("Constant", [], [name], value=shape))
        nodes.append(onnx.helper.make_node("ConstantOfShape", [name], [node.output[0]]))
    del graph.graph.node[:]
    graph.graph.node.extend(nodes)
    smaller: bytes = graph.SerializeToString()
    return smaller


class _OneScan(torch.nn.Module):  # type: ignore[misc]
    """The network on one scan; the exporter would make an input of the number of scans."""

    def __init__(self, network: PillarNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, features: torch.Tensor, cells: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        heat, boxes = self.network(features, cells, 1)
        return heat, boxes


def write_detector(
    path: Path,
    model: bytes,
    state: TrainingState,
    params: TrainingParams,
    scans: int,
    trained_on: str,
    cpu: str,
) -> DetectorRecord:
    """Writes the ONNX file and its record. Raises OSError."""
    record = DetectorRecord(
        version=VERSION, sha256=hashlib.sha256(model).hexdigest(), features=FEATURES, grid=state.network.grid,
        date=datetime.now(UTC).date().isoformat(),
        license=LICENSE, trained_on=trained_on, seed=params.seed, scans=scans,
        epochs=params.epochs, batch=params.batch, train_cpu_min=round(state.cpu_s / 60.0, 1), cpu=cpu,
        torch=str(torch.__version__),
        losses=tuple({name: round(value, 4) for name, value in means.items()} for means in state.losses),
    )  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(model)
    record_path(path).write_bytes(msgspec.json.format(msgspec.json.encode(record)) + b"\n")
    return record
