"""docs/fields.md: its block runs as it stands, and every quantity is on it."""

import os
import re
from pathlib import Path

import pytest

from sturz.field import QUANTITIES

PAGE = Path(__file__).resolve().parents[3] / "docs" / "fields.md"


def test_the_block_runs(binary: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), flags=re.DOTALL | re.MULTILINE)
    assert len(blocks) == 1
    monkeypatch.setenv("PATH", f"{binary.parent}{os.pathsep}{os.environ['PATH']}")
    exec(compile(blocks[0], str(PAGE), "exec"), {"__name__": "page"})
    said = capfd.readouterr().out
    assert said.count("sigma_zz") == 30
    assert re.search(r"[1-9]\d* samples in [1-9]\d* blocks, widths \(0.004, 0.006\)", said), said


def test_every_quantity_is_on_the_page() -> None:
    page = PAGE.read_text()
    assert not [name for name in QUANTITIES if f"`{name}`" not in page]
