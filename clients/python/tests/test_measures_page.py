"""docs/measures.md: its blocks run in order as they stand, and no public name is left out."""

import re
from pathlib import Path

import pytest

import sturz.measures

PAGE = Path(__file__).resolve().parents[3] / "docs" / "measures.md"


def test_every_block_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = PAGE.read_text()
    blocks = list(re.finditer(r"^```python\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE))
    assert len(blocks) == page.count("```python") >= 9
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    try:
        for block in blocks:
            above = "\n" * page[: block.start(1)].count("\n")
            exec(compile(above + block[1], str(PAGE), "exec"), names)
    finally:
        simulation = names.get("simulation")
        if isinstance(simulation, sturz.Simulation):
            simulation.close()


def test_every_function_is_on_the_page() -> None:
    text = PAGE.read_text()
    inner = {"autocorrelation_function", "enclosed_volume_m3", "is_inside", "isotropic_order", "neighbour_pairs"}
    inner |= {"integrated_autocorrelation", "particle_contact_moments_j", "rotation_moments_j", "wall_neighbours"}
    functions = {name for name in sturz.measures.__all__ if name[0].islower()} - inner
    assert not sorted(name for name in functions if not re.search(rf"\b{name}\b", text))
