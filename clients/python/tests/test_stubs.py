"""The committed protobuf stubs are those of the schema: `python scripts/generate_stubs.py` makes them."""

import importlib.metadata
import runpy
from pathlib import Path

from google.protobuf import descriptor_pb2

from sturz._proto.sturz.v1 import command_pb2, data_pb2, status_pb2

PACKAGE = Path(__file__).resolve().parents[1]
# As in pyproject.toml, for Pythons that it exists for; others generate other text from the same schema.
GENERATOR = "1.64.3"


def test_the_stubs_are_fresh(tmp_path: Path) -> None:
    script = runpy.run_path(str(PACKAGE / "scripts" / "generate_stubs.py"))
    written = {path.relative_to(tmp_path): path.read_text() for path in script["generate"](tmp_path)}
    committed = {
        path.relative_to(script["STUBS"]): path.read_text()
        for path in sorted(script["STUBS"].rglob("*"))
        if path.suffix in (".py", ".pyi")
    }
    assert sorted(written) == sorted(committed)
    if importlib.metadata.version("grpcio-tools") == GENERATOR:
        stale = [str(path) for path, text in written.items() if committed[path] != text]
        assert not stale, f"run scripts/generate_stubs.py: {stale} are not what the schema gives"


def test_the_stubs_hold_the_schema_whatever_generator_is_installed(tmp_path: Path) -> None:
    from grpc_tools import protoc

    script = runpy.run_path(str(PACKAGE / "scripts" / "generate_stubs.py"))
    files = [f"sturz/v1/{name}.proto" for name in ("command", "data", "status")]
    out = tmp_path / "descriptors.binpb"
    assert protoc.main(["protoc", f"-I{script['SCHEMA']}", f"--descriptor_set_out={out}", *files]) == 0
    schema = descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes())
    assert {file.name for file in schema.file} == set(files)
    modules = {module.DESCRIPTOR.name: module.DESCRIPTOR for module in (command_pb2, data_pb2, status_pb2)}
    for file in schema.file:
        loaded = descriptor_pb2.FileDescriptorProto.FromString(modules[file.name].serialized_pb)
        _forget_json_names(file)
        _forget_json_names(loaded)
        assert loaded == file, f"{file.name}: the stubs are not those of the schema"


def _forget_json_names(file: descriptor_pb2.FileDescriptorProto) -> None:
    for message in file.message_type:
        for field in message.field:
            field.ClearField("json_name")
