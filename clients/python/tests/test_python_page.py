"""docs/python.md: its blocks run in order as they stand, and no public name is left out."""

import os
import re
from pathlib import Path

import pytest

import sturz
import sturz.aio

PAGE = Path(__file__).resolve().parents[3] / "docs" / "python.md"
README = Path(__file__).resolve().parents[1] / "README.md"


def test_every_block_runs(
    binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    page = PAGE.read_text()
    blocks = list(re.finditer(r"^```python\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE))
    assert len(blocks) == page.count("```python") > 20
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{binary.parent}{os.pathsep}{os.environ['PATH']}")
    names: dict[str, object] = {"__name__": "page"}
    try:
        for block in blocks:
            # Lines in tracebacks are those of the page.
            above = "\n" * page[: block.start(1)].count("\n")
            exec(compile(above + block[1], str(PAGE), "exec"), names)
    finally:
        simulation = names.get("simulation")
        if isinstance(simulation, sturz.Simulation):
            simulation.close()
    said = capfd.readouterr().out
    for expected in ("the role of this client does not allow it", "no column 'velocities'", "(20, 1, 20)", "paused at"):
        assert expected in said
    for file in ("drum.png", "solid_fraction.png", "run.mcap"):
        assert (tmp_path / file).stat().st_size > 1000


def test_every_public_name_is_on_the_page_or_in_the_readme() -> None:
    text = PAGE.read_text() + README.read_text()
    names = {*sturz.__all__, *sturz.aio.__all__} - {"AsyncStream", "Opening"}
    names |= {name for name in vars(sturz.Simulation) if not name.startswith("_")}
    assert not sorted(name for name in names if not re.search(rf"\b{name}\b", text))


def test_links_of_the_page_lead_somewhere() -> None:
    for link in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", PAGE.read_text()):
        assert (PAGE.parent / link).exists(), link
    assert "docs/python.md" in README.read_text()
