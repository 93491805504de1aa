"""What a fluid solver must be to march with the particles."""

from __future__ import annotations

import os
from typing import Any, Protocol, runtime_checkable

from ..fluid import Exchange, FluidFields, Mesh


@runtime_checkable
class FluidSolver(Protocol):
    """A partner of the particles. `docs/coupling.md` shows how to write one.

    Attributes:
        mesh: where its values are.
        time_s: where it stands.
    """

    mesh: Mesh
    time_s: float

    def fields(self) -> FluidFields:
        """The fluid now."""

    def advance(self, window_s: float, before: Exchange, after: Exchange) -> FluidFields:
        """Goes on by `window_s`, and returns the fluid there.

        The void fraction goes from that of `before` to that of `after` over the window; the sources are those of
        `after`: interaction(u) = `after.interaction_n_per_m3` + `after.drag_kg_per_m3_s` (u_seen - u), with u_seen =
        `after.seen_velocity_m_per_s`. Taking that at the new u keeps a large drag stable.
        """

    def save(self) -> Any:
        """A token to go back to, in memory."""

    def restore(self, token: Any) -> None:
        """Goes back."""

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """Writes all that decides its future: what a run that lost its solver goes on from."""

    def from_file(self, path: str | os.PathLike[str]) -> None:
        """Takes over what `to_file` wrote."""
