"""The examples of the READMEs run as they stand, but for shorter windows and an endpoint of their own."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib import image

from sturz.daemon import find_binary

README = Path(__file__).resolve().parents[1] / "README.md"
ROOT_README = README.parents[2] / "README.md"


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


def test_the_lines_of_the_root_readme_steer_a_served_drum(tmp_path: Path) -> None:
    """`sturz serve drum-crosses` in one process, the lines in another one, as a newcomer would."""
    (example,) = re.findall(r"```python\n(.*?)```", ROOT_README.read_text(), flags=re.DOTALL)
    command = [str(find_binary()), "serve", "drum-crosses", "--listen", "auto", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as daemon:
        assert daemon.stdout is not None
        (endpoint,) = re.findall(r'"endpoint":"([^"]+)"', daemon.stdout.readline())
        shorter = example.replace("start_s + 0.3", "start_s + 0.02").replace("count=200", "count=60")
        assert shorter != example
        connect = f'sturz.connect("drum-crosses", endpoint={endpoint!r})'
        script = tmp_path / "steer.py"
        script.write_text(shorter.replace('sturz.connect("drum-crosses")', connect))
        done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=100)
        # The example ends with `stop`.
        assert daemon.wait(timeout=20) == 0
    assert done.returncode == 0, done.stderr
    assert "(60, 3)" in done.stdout
    for name in ("drum.png", "velocity.png"):
        assert image.imread(tmp_path / name).std() > 0.03
