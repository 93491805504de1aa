"""Prints the rows of the papers' scripts as Markdown tables: `python table.py [out/papers]`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any


def number(value: Any, error: Any = None) -> str:
    """Four digits, with the error where there is one."""
    if value is None:
        return ""
    return f"{value:.4g}" + (f" ± {error:.2g}" if error else "")


def table(file: Path) -> str:
    """The rows of one script."""
    lines = ["| case | what | value | reference | verdict |", "|---|---|---:|---:|---|"]
    for rows in json.loads(file.read_text()).values():
        for row in rows:
            unit = "" if row["unit"] == "1" else f" {row['unit']}"
            reference = number(row["reference"], row["tolerance"])
            value = number(row["value"], row["uncertainty"])
            reference += unit if reference else ""
            cells = [row["id"], row["metric"], value + unit, reference, row["verdict"]]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Command line."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/papers")
    files = sorted(folder.glob("*/rows.json"))
    if not files:
        sys.exit(f"no */rows.json in {folder}")
    for file in files:
        print(f"## {file.parent.name}\n\n{table(file)}\n")


if __name__ == "__main__":
    main()
