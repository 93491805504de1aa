"""The example of the README runs as it stands, but for its first window: a tenth of it will do."""

import re
from pathlib import Path

import pytest
from matplotlib import image

README = Path(__file__).resolve().parents[1] / "README.md"


def test_the_example_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.DOTALL)
    assert len(example.splitlines()) <= 24
    monkeypatch.chdir(tmp_path)
    exec(compile(example.replace("window_s=0.1,", "window_s=0.01,"), str(README), "exec"), {})
    said = capfd.readouterr()
    assert "(60, 3)" in said.out
    assert " m/s" in said.out
    assert "100%" in said.err
    assert image.imread(tmp_path / "drum.png").std() > 0.03
