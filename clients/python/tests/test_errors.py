"""What errors say, and that every enumeration knows all of the schema."""

from enum import IntEnum
from typing import Any

import pytest

import sturz
from sturz import bus
from sturz._proto.sturz.v1 import command_pb2, data_pb2, status_pb2
from sturz.field import QUANTITIES


def test_a_refusal_says_what_was_refused_why_and_where() -> None:
    error = sturz.CommandError(
        code=sturz.ErrorCode.INVALID_INPUT,
        path="window_s",
        message="is -1, must be positive",
        command="advance",
        step=7,
    )
    assert str(error) == "advance refused (INVALID_INPUT at window_s): is -1, must be positive"
    assert (error.code, error.path, error.command, error.step) == (
        sturz.ErrorCode.INVALID_INPUT,
        "window_s",
        "advance",
        7,
    )


def test_a_refusal_without_a_path_names_none() -> None:
    error = sturz.CommandError(code=sturz.ErrorCode.BUSY, path="", message="try again", command="step")
    assert str(error) == "step refused (BUSY): try again"
    assert error.step is None


@pytest.mark.parametrize(
    ("mirror", "original", "prefix"),
    [
        (sturz.ErrorCode, command_pb2.ErrorCode, "ERROR_CODE_"),
        (sturz.RunState, status_pb2.RunState, "RUN_STATE_"),
        (sturz.EventKind, status_pb2.EventKind, "EVENT_KIND_"),
        (sturz.Severity, status_pb2.Severity, "SEVERITY_"),
    ],
)
def test_enumerations_mirror_the_schema(mirror: type[IntEnum], original: Any, prefix: str) -> None:
    assert {member.name: int(member) for member in mirror} == {
        name.removeprefix(prefix): number for name, number in original.items()
    }
    assert mirror(9999) is mirror(0), "a newer daemon may know more"


def test_quantities_mirror_the_schema() -> None:
    original = {name.removeprefix("FIELD_QUANTITY_").lower(): number for name, number in data_pb2.FieldQuantity.items()}
    assert original.pop("unspecified") == 0
    assert original == QUANTITIES


def test_stop_reasons_mirror_the_schema() -> None:
    from sturz.simulation import _STOP_REASONS

    original = [name.removeprefix("STOP_REASON_").lower() for name, _ in command_pb2.StopReason.items()]
    assert list(_STOP_REASONS) == original


def test_every_error_is_a_sturz_error_and_a_timeout_is_pythons_too() -> None:
    for name in ("CommandError", "DaemonGone", "LaunchFailed", "NoAnswer", "NotConnected", "ProtocolError", "Timeout"):
        assert issubclass(getattr(sturz, name), sturz.SturzError)
    assert issubclass(sturz.Timeout, TimeoutError)
    assert issubclass(sturz.ColumnMissing, KeyError)
    assert str(sturz.ColumnMissing("no column 'scales'")) == "no column 'scales'"


def test_error_replies_to_queries_become_refusals_and_zenohs_own_a_timeout() -> None:
    error = command_pb2.Error(code=command_pb2.ERROR_CODE_NOT_FOUND, path="columns", message="no such column")
    refusal = bus._refusal("state/latest", error.SerializeToString())
    assert isinstance(refusal, sturz.CommandError)
    assert str(refusal) == "state/latest refused (NOT_FOUND at columns): no such column"
    timeout = bus._refusal("info", b"Timeout")
    assert isinstance(timeout, sturz.Timeout)
    assert str(timeout) == "info: Timeout"
