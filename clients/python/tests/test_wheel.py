"""The wheel with the daemon is the same package as the one without."""

import tomllib
from pathlib import Path

import sturz

CLIENT = Path(__file__).resolve().parents[1]
ROOT = CLIENT.parents[1]


def test_both_packages_ask_for_the_same() -> None:
    both, client = (tomllib.loads((folder / "pyproject.toml").read_text()) for folder in (ROOT, CLIENT))
    for key in ("name", "version", "requires-python", "license", "dependencies"):
        assert both["project"][key] == client["project"][key], key
    extras = both["project"]["optional-dependencies"]
    assert extras["plots"] == client["project"]["optional-dependencies"]["plots"]
    assert both["project"]["version"] == sturz.__version__
    assert (
        both["project"]["version"]
        == tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    )
    maturin = both["tool"]["maturin"]
    assert (ROOT / maturin["python-source"] / maturin["module-name"] / "__init__.py").is_file()
    service = tomllib.loads((ROOT / maturin["manifest-path"]).read_text())
    assert [program["name"] for program in service["bin"]] == ["sturz"]
