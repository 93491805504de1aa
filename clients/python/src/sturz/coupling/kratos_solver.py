"""Kratos in this process, as a `FluidSolver`."""

from __future__ import annotations

import os

from ..fluid import Exchange, FluidFields, PointMesh
from .kratos_case import KratosCase, KratosState
from .kratos_core import KratosCore


class KratosSolver(KratosCore):
    """A `FluidSolver` of Kratos' elements for flow through particles ("model A"), in this process.

    Args:
        case: mesh, boundaries, fluid and time stepping.

    Raises:
        KratosMissing: Kratos is not installed here.
        KratosFailed, GridError: a case that cannot be run.
    """

    def __init__(self, case: KratosCase) -> None:
        super().__init__(case)
        self.mesh = PointMesh(self.points_m, self.grid.volumes_m3)

    def fields(self) -> FluidFields:
        """The fluid now, at the points of `mesh`."""
        return FluidFields(**self.arrays())

    def advance(self, window_s: float, before: Exchange, after: Exchange) -> FluidFields:
        """One window: the void fraction goes linearly from `before`'s to `after`'s, sources are `after`'s.

        Without `after.seen_velocity_m_per_s` drag is explicit, which a dense bed makes unstable.

        Raises:
            KratosFailed: unusable input, or a step that does not converge.
        """
        self.march(
            window_s,
            before.void_fraction,
            after.void_fraction,
            after.interaction_n_per_m3,
            after.drag_kg_per_m3_s,
            after.seen_velocity_m_per_s,
        )
        return self.fields()

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """All that decides its future, for `from_file` of a solver of the same case."""
        self.save().write(path)

    def from_file(self, path: str | os.PathLike[str]) -> None:
        """Goes on from a file of `to_file`.

        Raises:
            KratosFailed: not such a file, or of another mesh.
        """
        self.restore(KratosState.read(path))
