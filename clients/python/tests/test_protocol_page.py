"""docs/protocol.md is complete, and the client that it shows runs."""

import importlib.util
import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

from conftest import SPACE

import sturz
from sturz._proto.sturz.v1 import command_pb2, data_pb2, status_pb2

REPOSITORY = Path(__file__).resolve().parents[3]
PAGE = (REPOSITORY / "docs" / "protocol.md").read_text()
RAW_CLIENT = REPOSITORY / "clients" / "python" / "examples" / "raw_client.py"


def between(begin: str, end: str) -> str:
    """What the page has there."""
    return PAGE.split(begin)[1].split(end)[0]


def test_the_reference_is_that_of_the_schema() -> None:
    path = REPOSITORY / "clients" / "python" / "scripts" / "generate_protocol_reference.py"
    spec = importlib.util.spec_from_file_location("generate_protocol_reference", path)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = script
    spec.loader.exec_module(script)
    assert script.page(PAGE) == PAGE, "run clients/python/scripts/generate_protocol_reference.py"


def test_every_message_field_and_value_is_on_the_page() -> None:
    # against the compiled schema, in case the script reads the text wrongly
    sections = {}
    for section in re.split(r"^#### ", between("<!-- reference: begin -->", "<!-- reference: end -->"), flags=re.M)[1:]:
        kind, name = section.split("\n", 1)[0].split()
        sections[kind, name] = section
    wanted = 0
    for file in (data_pb2, command_pb2, status_pb2):
        for name, message in file.DESCRIPTOR.message_types_by_name.items():
            for field in message.fields:
                assert f"| {field.number} | `{field.name}` | " in sections["message", name], (name, field.name)
                wanted += 1
        for name, kind in file.DESCRIPTOR.enum_types_by_name.items():
            for value in kind.values:
                assert f"| {value.number} | `{value.name}` | " in sections["enum", name], (name, value.name)
                wanted += 1
    assert wanted > 300


def test_every_key_and_verb_is_on_the_page() -> None:
    keys = (REPOSITORY / "protocol" / "src" / "keys.rs").read_text()
    tails = re.findall(r'self\.key\((?:&format!\()?"([^"]+)"', keys)
    assert len(tails) > 15
    for tail in tails:
        if "*" in tail or tail in ("cmd/{}", "event/{topic}"):
            continue
        shown = tail.replace("{name}", "<name>").replace("{epoch}", "<epoch>").replace("{client_id}", "<client_id>")
        assert re.search(rf"`{re.escape(shown)}[`?]", PAGE), shown
    events = (REPOSITORY / "service" / "src" / "events.rs").read_text()
    topics = re.findall(r'"(\w+)"', events.split("TOPICS: [&str;")[1].split("\n", 1)[0])
    assert len(topics) == 7
    assert all(f"`event/{topic}`" in PAGE for topic in topics)


def test_every_command_column_and_error_is_on_the_page(space: sturz.Simulation) -> None:
    features = space.features()
    rows = between("## Commands", "### Errors")
    for command in features.commands:
        request = "".join(word.capitalize() for word in command.split("_")) + "Request"
        assert f"| `{command}` | `{request}` | " in rows, command
    columns = between("## Columns", "## Streams")
    for column in (*features.columns, *features.contact_columns, *features.field_quantities):
        assert f"`{column}`" in columns, column
    errors = between("### Errors", "## Columns")
    for code in sturz.ErrorCode:
        assert code is sturz.ErrorCode.UNSPECIFIED or f"`{code.name}`" in errors, code


def test_every_kind_of_event_is_on_the_page_and_in_the_client() -> None:
    events = between("## Events", "## Quality of service")
    for name, number in status_pb2.EventKind.items():
        plain = name.removeprefix("EVENT_KIND_")
        assert sturz.EventKind(number).name == plain
        assert number == 0 or f"`{plain}`" in events, plain
    for python, schema in ((sturz.WarningKind, status_pb2.WarningKind), (sturz.LeaseChange, status_pb2.LeaseChange)):
        assert [each.value for each in python] == schema.values()
    assert [each.value for each in sturz.ContactKind] == data_pb2.ContactKind.values()


def flags() -> dict[str, tuple[bool, bool]]:
    """By command: whether the page says that it may wait for a time, and that it is the lease holder's alone."""
    rows = re.findall(r"^\| `(\w+)` \| `\w+` \| `\w+` \|(.*)\|(.*)\|$", PAGE, flags=re.M)
    return {command: (wait.strip() == "yes", lease.strip() == "yes") for command, wait, lease in rows}


def test_what_may_wait_is_what_the_daemon_lets_wait(space: sturz.Simulation) -> None:
    told = flags()
    assert len(told) == len(space.features().commands)
    for command, (may_wait, _) in told.items():
        request = getattr(command_pb2, "".join(word.capitalize() for word in command.split("_")) + "Request")()
        request.header.at_time_s = 0.0  # now: whatever may wait is done, or refused for another reason
        try:
            space.command(command, request, timeout_s=20.0)
            path = ""
        except sturz.CommandError as error:
            path = error.path
        assert may_wait == (path != "header.at_time_s"), command


def test_what_the_lease_guards_is_what_the_page_says(space: sturz.Simulation) -> None:
    space.checkpoint(token="a")
    bodies = {
        "step": command_pb2.StepRequest(steps=1),
        "advance": command_pb2.AdvanceRequest(from_step=0, window_s=1e-5),
        "set_loads": command_pb2.SetLoadsRequest(loads=command_pb2.Loads()),
        "restore": command_pb2.RestoreRequest(token="a"),
    }
    with sturz.connect(space.instance, endpoint=space.endpoint) as holder:
        holder.acquire_lease()
        for command, (_, is_guarded) in flags().items():
            if command in ("acquire_lease", "release_lease", "stop"):
                continue
            name = "".join(word.capitalize() for word in command.split("_")) + "Request"
            try:
                space.command(command, bodies.get(command, getattr(command_pb2, name)()), timeout_s=20.0)
                code = None
            except sturz.CommandError as error:
                code = error.code
            assert is_guarded == (code is sturz.ErrorCode.LEASE), command


def test_the_page_shows_the_client_and_it_has_at_most_60_lines() -> None:
    source = RAW_CLIENT.read_text()
    assert between("<!-- raw_client.py: begin -->", "<!-- raw_client.py: end -->") == f"\n\n```python\n{source}```\n\n"
    assert len(source.splitlines()) <= 60
    assert "import sturz" not in source


def test_the_client_of_the_page_runs(tmp_path: Path) -> None:
    # Without `site`, the package of this repository is not there, which is installed by a .pth file; all others are.
    bare = {**os.environ, "PYTHONPATH": sysconfig.get_path("purelib")}
    python = [sys.executable, "-S"]
    hidden = subprocess.run([*python, "-c", "import sturz"], env=bare, capture_output=True, text=True, check=False)
    assert "No module named 'sturz'" in hidden.stderr
    source = re.search(r"```python\n(.*?)```", between("<!-- raw_client.py: begin", "raw_client.py: end -->"), re.S)
    assert source is not None
    script = tmp_path / "client.py"
    script.write_text(source[1])
    with sturz.launch(scene_text=SPACE) as simulation:
        arguments = [simulation.endpoint, simulation.instance, str(REPOSITORY / "protocol" / "proto")]
        command = [*python, str(script), *arguments]
        done = subprocess.run(command, env=bare, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        info = simulation.info()
        assert (info.particles, info.step) == (2, 1000)
        positions = simulation.state().positions_m
    lines = done.stdout.splitlines()
    assert lines[0] == "schema 1, space: step 0, 0.0 s"
    assert lines[1] == "inserted from id 0"
    assert lines[2] == "at 0.01 s after 1000 steps: ['ids', 'velocities']"
    assert lines[3:5] == [f"position {tuple(row)}" for row in positions.tolist()]
    assert lines[5] == "refused: ERROR_CODE_INVALID_INPUT ids[0]: particle 99 does not exist"
