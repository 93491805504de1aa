"""What the daemon's streams hold, and when."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from ._proto.sturz.v1 import data_pb2 as pb

FloatType = Literal["f64", "f32"]
_FLOATS: dict[FloatType, pb.DataType] = {"f64": pb.DATA_TYPE_F64, "f32": pb.DATA_TYPE_F32}


def output_message(
    *,
    stream: str,
    columns: Iterable[str],
    float_type: FloatType | None,
    every_steps: int | None,
    every_wall_s: float | None,
    every_sim_s: float | None,
) -> pb.OutputDefinition:
    """The definition for the wire.

    Raises:
        ValueError: more than one pace.
    """
    paces = {"every_steps": every_steps, "every_wall_s": every_wall_s, "every_sim_s": every_sim_s}
    given = {name: pace for name, pace in paces.items() if pace is not None}
    if len(given) > 1:
        raise ValueError(f"give one pace, not {' and '.join(given)}")
    message = pb.OutputDefinition(stream=stream, columns=list(columns))
    if float_type is not None:
        message.float_type = _FLOATS[float_type]
    for name, pace in given.items():
        setattr(message, name, pace)
    return message


@dataclass(frozen=True)
class Output:
    """What a stream holds now, and when.

    Attributes:
        stream: ``state``, ``contacts``, ``report`` or ``field/<name>``.
        columns: names; none for reports.
        float_type: of floating-point columns.
        every_steps: at every step whose number is a multiple; None at another pace.
        every_wall_s: at most one in so much wall time; None at another pace.
        every_sim_s: at the first step at or after every multiple of this simulated time; None at another pace.
    """

    stream: str
    columns: tuple[str, ...]
    float_type: FloatType
    every_steps: int | None
    every_wall_s: float | None
    every_sim_s: float | None

    @classmethod
    def from_message(cls, message: pb.OutputDefinition) -> Output:
        pace = message.WhichOneof("pace")
        return cls(
            stream=message.stream,
            columns=tuple(message.columns),
            float_type="f32" if message.float_type == pb.DATA_TYPE_F32 else "f64",
            every_steps=message.every_steps if pace == "every_steps" else None,
            every_wall_s=message.every_wall_s if pace == "every_wall_s" else None,
            every_sim_s=message.every_sim_s if pace == "every_sim_s" else None,
        )
