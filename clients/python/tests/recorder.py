"""Our own recorder, player and exporter as a user starts them."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import sturz
from sturz.daemon import find_binary

PATIENCE_S = 60


@contextmanager
def started(*arguments: str | os.PathLike[str]) -> Iterator[tuple[subprocess.Popen[str], dict[str, Any]]]:
    """A `sturz` that says `ready`; killed at the end if it still runs."""
    command = [str(find_binary()), *map(os.fspath, arguments), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            if not line.startswith("ready "):
                raise AssertionError(f"{line!r}, {process.communicate(timeout=PATIENCE_S)}")
            yield process, json.loads(line.removeprefix("ready "))
        finally:
            process.kill()


def sturz_run(*arguments: str | os.PathLike[str]) -> subprocess.CompletedProcess[str]:
    """`sturz` with these arguments, to its end."""
    command = [str(find_binary()), *map(os.fspath, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)


def record(simulation: sturz.Simulation, out: Path, windows: int, window_s: float, *more: str) -> dict[str, Any]:
    """Records a paused simulation over so many windows; what the recorder says of it."""
    until_s = simulation.info().time_s + windows * window_s
    where = [simulation.instance, "--endpoint", simulation.endpoint, "--out", str(out)]
    with started("record", *where, "--until-sim", repr(until_s - 1e-6 * window_s), *more) as (recorder, _):
        for _ in range(windows):
            simulation.advance(window_s=window_s)
        # The daemon repeats the state of a paused simulation, so the last one comes for sure.
        said, trouble = recorder.communicate(timeout=PATIENCE_S)
        assert recorder.returncode == 0, trouble
    return dict(json.loads(said))
