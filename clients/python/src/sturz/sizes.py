"""Laws of the sizes of inserted particles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from ._proto.sturz.v1 import command_pb2 as pb


@dataclass(frozen=True)
class NormalScale:
    """Sizes of inserted particles relative to the shape: Gaussian by number, cut at both ends.

    Attributes:
        mean: before it is cut.
        standard_deviation: before it is cut.
        min: smallest size.
        max: largest size.
    """

    mean: float
    standard_deviation: float
    min: float
    max: float


@dataclass(frozen=True)
class LognormalScale:
    """Sizes of inserted particles relative to the shape: the logarithm is Gaussian by number; cut at both ends.

    Attributes:
        median: before it is cut.
        log_standard_deviation: of the natural logarithm, before it is cut.
        min: smallest size.
        max: largest size.
    """

    median: float
    log_standard_deviation: float
    min: float
    max: float


@dataclass(frozen=True)
class ScaleTable:
    """Sizes of inserted particles relative to the shape: one of several, with probabilities by number.

    Attributes:
        scales: sizes.
        weights: one for each; probabilities are weights over their sum.
    """

    scales: Sequence[float]
    weights: Sequence[float]


#: Size of inserted particles relative to the shape: one, (smallest, largest) for uniformly random ones, or a law.
Scale: TypeAlias = float | tuple[float, float] | NormalScale | LognormalScale | ScaleTable


def write_scale(request: pb.InsertRequest, scale: Scale) -> None:
    """Puts the sizes into a request."""
    if isinstance(scale, NormalScale):
        request.normal_scale.CopyFrom(
            pb.NormalScale(mean=scale.mean, standard_deviation=scale.standard_deviation, min=scale.min, max=scale.max)
        )
    elif isinstance(scale, LognormalScale):
        lognormal = pb.LognormalScale(
            median=scale.median, log_standard_deviation=scale.log_standard_deviation, min=scale.min, max=scale.max
        )
        request.lognormal_scale.CopyFrom(lognormal)
    elif isinstance(scale, ScaleTable):
        request.scale_table.CopyFrom(pb.ScaleTable(scales=list(scale.scales), weights=list(scale.weights)))
    else:
        request.scale.min, request.scale.max = scale if isinstance(scale, tuple) else (scale, scale)


__all__ = ["LognormalScale", "NormalScale", "Scale", "ScaleTable", "write_scale"]
