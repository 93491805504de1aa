"""Writes the protobuf stubs of the package from the schema: `python scripts/generate_stubs.py [FOLDER]`.

Needs grpcio-tools 1.64.3 (`pip install 'grpcio-tools==1.64.3'`, Python up to 3.12): its stubs work with every protobuf
from 5.26 on, because they do not yet ask the runtime for its version.
"""

import re
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
SCHEMA = PACKAGE.parents[1] / "protocol" / "proto"
STUBS = PACKAGE / "src" / "sturz" / "_proto"


def generate(folder: Path) -> list[Path]:
    """Writes the stubs below `folder`, and returns the files."""
    from grpc_tools import protoc

    folder.mkdir(parents=True, exist_ok=True)
    sources = sorted(str(path.relative_to(SCHEMA)) for path in SCHEMA.rglob("*.proto"))
    status = protoc.main(["protoc", f"-I{SCHEMA}", f"--python_out={folder}", f"--pyi_out={folder}", *sources])
    if status != 0:
        raise SystemExit(f"protoc failed with status {status}")
    written = []
    for package in (folder, folder / "sturz", folder / "sturz" / "v1"):
        initial = package / "__init__.py"
        initial.write_text("")
        written.append(initial)
    for path in sorted([*folder.rglob("*_pb2.py"), *folder.rglob("*_pb2.pyi")]):
        # protoc imports from the root of the schema, which is no root of Python packages here.
        path.write_text(re.sub(r"^from sturz\.v1 import", "from . import", path.read_text(), flags=re.MULTILINE))
        written.append(path)
    return written


if __name__ == "__main__":
    for path in generate(Path(sys.argv[1]) if len(sys.argv) > 1 else STUBS):
        print(path)
