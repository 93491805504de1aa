"""The process that runs Kratos for a `KratosProcess`: `python -m sturz.coupling.kratos_worker FD`.

It reads requests from the socket that it inherited as file descriptor FD, answers each, and ends when the other side
closes. Started as a file it needs nothing but numpy and Kratos: not the other dependencies of `sturz`.
"""

from __future__ import annotations

import sys
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType
from typing import Any

if not __package__:
    # Started by its path, from an interpreter without sturz: its packages are named without running their __init__.
    sys.path[:] = [place for place in sys.path if Path(place or ".").resolve() != Path(__file__).resolve().parent]
    for _name, _folder in (("sturz", Path(__file__).parents[1]), ("sturz.coupling", Path(__file__).parent)):
        _module = ModuleType(_name)
        _module.__path__ = [str(_folder)]
        sys.modules[_name] = _module

from sturz.coupling.kratos_case import KratosCase, KratosState
from sturz.coupling.kratos_core import KratosCore
from sturz.coupling.kratos_wire import decode, encode
from sturz.errors import SturzError


def serve(connection: Connection) -> None:
    """Answers requests until the other side closes."""
    solver: KratosCore | None = None
    while True:
        try:
            header, arrays = decode(connection.recv_bytes())
        except EOFError:
            return
        try:
            if header["call"] == "start":
                solver = KratosCore(KratosCase.from_json(header["case"]))
                answer = encode({}, {"points_m": solver.points_m, "volumes_m3": solver.grid.volumes_m3})
            elif solver is None:
                raise RuntimeError(f"{header['call']!r} before 'start'")
            else:
                answer = _answer(solver, header, arrays)
        except SturzError as error:
            answer = encode({"error": str(error), "kind": type(error).__name__})
        except Exception:
            answer = encode({"error": traceback.format_exc(), "kind": "Exception"})
        connection.send_bytes(answer)


def _answer(solver: KratosCore, header: dict[str, Any], arrays: dict[str, Any]) -> bytes:
    """Does one request."""
    call = header["call"]
    if call == "advance":
        solver.march(header["window_s"], **{"seen_velocity_m_per_s": None, **arrays})
        return encode({"time_s": solver.time_s}, solver.arrays())
    if call == "fields":
        return encode({"time_s": solver.time_s}, solver.arrays())
    if call == "save":
        state = solver.save()
        return encode({"time_s": state.time_s, "last_step_s": state.last_step_s}, state.arrays)
    if call == "restore":
        solver.restore(KratosState(header["time_s"], header["last_step_s"], arrays))
    elif call == "set_inlet":
        solver.set_inlet(header["side"], header["superficial_velocity_m_per_s"])
    elif call == "pressure":
        return encode({}, {"pressure_pa": solver.pressure_pa})
    elif call in ("fluxes_m3_per_s", "statistics"):
        return encode({"result": getattr(solver, call)()})
    else:
        raise RuntimeError(f"no such request: {call!r}")
    return encode({"time_s": solver.time_s})


if __name__ == "__main__":
    if len(sys.argv) != 2 or not sys.argv[1].isdigit():
        sys.exit("kratos_worker FD: the file descriptor of an inherited socket; a KratosProcess starts this")
    serve(Connection(int(sys.argv[1])))
