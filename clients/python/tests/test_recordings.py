"""`sturz record` writes what the ordinary MCAP tools read; `sturz play` shows it to ordinary clients."""

import signal
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from conftest import DRUM_REGION, fill, wait_until
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory
from recorder import PATIENCE_S, record, started, sturz_run

import sturz

WINDOWS, WINDOW_S = 6, 2e-3


def define_density(simulation: sturz.Simulation) -> None:
    """The field `f` of the whole drum."""
    low, high = (-0.02, 0, -0.02), (0.02, 0.012, 0.02)
    simulation.define_field(name="f", min_m=low, max_m=high, cells=(8, 1, 8), quantities=["density"], width_m=4e-3)


@pytest.fixture
def recording(drum: sturz.Simulation, tmp_path: Path) -> Path:
    """Some windows of a drum with particles and a field, which is left paused at the last recorded state."""
    fill(drum)
    define_density(drum)
    path = tmp_path / "drum.mcap"
    summary = record(drum, path, WINDOWS, WINDOW_S)
    assert summary["ended_by"] == "sim_time"
    assert summary["dropped_at_disk"] == 0
    assert summary["bytes"] == path.stat().st_size
    return path


def test_the_ordinary_tools_decode_every_message(drum: sturz.Simulation, recording: Path) -> None:
    now = drum.state()
    with recording.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        (facts,) = reader.iter_metadata()
        assert facts.metadata["instance"] == drum.instance
        decoded = list(reader.iter_decoded_messages())
    assert len(decoded) == summary.statistics.message_count
    root = f"sturz/v1/{drum.instance}/"
    topics = Counter(message.channel.topic.removeprefix(root) for message in decoded)
    assert {"info", "features", "plan", "shapes/latest", "state/frame", "field/f", "event/particles"} <= set(topics)
    assert topics["shapes/latest"] == 1
    for schema, channel, message, content in decoded:
        assert channel.message_encoding == schema.encoding == "protobuf"
        assert content.DESCRIPTOR.full_name == schema.name
        if channel.topic.endswith(("frame", "field/f", "report")):
            assert message.publish_time == content.header.wall_time_ns
            assert message.sequence == content.header.seq
            assert channel.metadata["simulated_time_s"] == "header.sim_time_s"
    *_, last = (entry.decoded_message for entry in decoded if entry.channel.topic == f"{root}state/frame")
    assert last.header.step == now.step
    columns = {column.name: column for column in last.columns}
    positions = np.frombuffer(columns["positions"].data, "<f8").reshape(-1, 3)
    np.testing.assert_array_equal(positions, now.positions_m)
    np.testing.assert_array_equal(np.frombuffer(columns["ids"].data, "<u8"), now.ids)


def test_topics_are_chosen_and_a_file_is_never_overwritten(drum: sturz.Simulation, tmp_path: Path) -> None:
    fill(drum, beads=3, crosses=0)
    path = tmp_path / "state.mcap"
    summary = record(drum, path, 1, WINDOW_S, "--topics", "state", "--uncompressed")
    assert set(summary["streams"]) == {"info", "features", "plan", "shapes/latest", "state/frame"}
    before = path.read_bytes()
    again = sturz_run("record", drum.instance, "--endpoint", drum.endpoint, "--out", path)
    assert again.returncode == 1
    assert "exists" in again.stderr
    assert path.read_bytes() == before


def test_new_particles_make_the_recorder_ask_again(drum: sturz.Simulation, tmp_path: Path) -> None:
    fill(drum, beads=3, crosses=0)
    path = tmp_path / "a.mcap"
    with started("record", drum.instance, "--endpoint", drum.endpoint, "--out", path) as (recorder, _):
        drum.insert_random(shape="bead", material="glass", region=DRUM_REGION, count=4)

        def infos() -> list[int]:
            return [content.particles for content in messages_up_to_cut(path, "info")]

        wait_until(lambda: infos()[-1:] == [7], what="an info with the new particles")
        recorder.send_signal(signal.SIGTERM)
        assert recorder.wait(PATIENCE_S) == 0


def messages_up_to_cut(path: Path, tail: str) -> list[object]:
    """Decoded messages of a file that may end anywhere, by the ordinary stream reader."""
    factory, found, schemas, channels = DecoderFactory(), [], {}, {}
    with path.open("rb") as file:
        try:
            for record_ in StreamReader(file).records:
                kind = type(record_).__name__
                if kind == "Schema":
                    schemas[record_.id] = record_
                elif kind == "Channel":
                    channels[record_.id] = record_
                elif isinstance(record_, Message) and channels[record_.channel_id].topic.endswith(f"/{tail}"):
                    schema = schemas[channels[record_.channel_id].schema_id]
                    decode = factory.decoder_for("protobuf", schema)
                    assert decode is not None
                    found.append(decode(record_.data))
        except EndOfFile:
            pass
    return found


def test_a_killed_recorder_leaves_a_readable_file(drum: sturz.Simulation, tmp_path: Path) -> None:
    fill(drum)
    path = tmp_path / "killed.mcap"
    with started("record", drum.instance, "--endpoint", drum.endpoint, "--out", path) as (recorder, _):
        step = drum.advance(window_s=WINDOW_S).step
        steps = lambda: [frame.header.step for frame in messages_up_to_cut(path, "state/frame")]  # noqa: E731
        wait_until(lambda: step in steps(), what="a flushed frame")
        recorder.kill()
        recorder.wait(PATIENCE_S)
    export = sturz_run("export", path, "--out", tmp_path / "out", "--what", "particles")
    assert export.returncode == 0, export.stderr
    assert "has no end" in export.stderr
    assert (tmp_path / "out" / "particles_000000.vtp").exists()


def test_the_recording_ends_well_with_the_daemon_and_on_request(tmp_path: Path) -> None:
    from conftest import DRUM

    for name, how in (("daemon.mcap", "daemon_ended"), ("asked.mcap", "asked")):
        path = tmp_path / name
        with sturz.launch(scene_text=DRUM) as drum:
            where = [drum.instance, "--endpoint", drum.endpoint, "--out", path]
            with started("record", *where) as (recorder, _):
                if how == "asked":
                    recorder.send_signal(signal.SIGINT)
                else:
                    drum.stop()
                said, trouble = recorder.communicate(timeout=PATIENCE_S)
                assert recorder.returncode == 0, trouble
                assert f'"ended_by": "{how}"' in said
        with path.open("rb") as file:
            assert make_reader(file).get_summary() is not None


def test_a_player_is_a_simulation_to_its_clients(drum: sturz.Simulation, recording: Path) -> None:
    now, recorded = drum.state(), drum.info()
    arguments = ["play", recording, "--name", "again", "--listen", "auto", "--speed", "max", "--paused"]
    with started(*arguments) as (player, ready), sturz.connect("again", endpoint=ready["endpoint"]) as again:
        info = again.info()
        assert (info.instance, info.state, info.scene) == ("again", sturz.RunState.PAUSED, recorded.scene)
        assert info.shapes == recorded.shapes
        assert again.features().commands == ("pause", "resume", "stop")
        assert again.plan() == drum.plan()
        assert [shape.name for shape in again.shapes()] == [shape.name for shape in drum.shapes()]
        first = again.state()
        assert first.step < now.step
        assert info.particles == len(first) == 40
        with again.states(keep=10_000) as states, again.fields("f", keep=10_000) as fields:
            # The paused player repeats what it shows.
            again.resume()
            frames = [states.next_frame(PATIENCE_S)]
            while frames[-1] is not None and frames[-1].step < now.step:
                frames.append(states.next_frame(PATIENCE_S))
            assert fields.next_frame(PATIENCE_S) is not None
            wait_until(lambda: again.info().state is sturz.RunState.PAUSED, what="the end")
        steps = [frame.step for frame in frames if frame is not None]
        assert steps == sorted(steps)
        last = again.state()
        np.testing.assert_array_equal(last.positions_m, now.positions_m)
        np.testing.assert_array_equal(last.orientations_wxyz, now.orientations_wxyz)
        narrow = again.state(["positions"], float_type="f32")
        np.testing.assert_array_equal(narrow.positions_m, now.positions_m.astype(np.float32))
        assert again.field("f").total_mass_kg == pytest.approx(drum.field("f").total_mass_kg)
        assert again.info().time_s == now.time_s
        again.stop()
        assert player.wait(PATIENCE_S) == 0


def test_a_recording_cannot_be_steered(recording: Path) -> None:
    with (
        started("play", recording, "--name", "again", "--listen", "auto", "--paused") as (_, ready),
        sturz.connect("again", endpoint=ready["endpoint"]) as again,
    ):
        commands = [
            lambda: again.set_gravity(gravity_m_per_s2=(0, 0, 1)),
            lambda: again.insert_random(shape="bead", material="glass", region=DRUM_REGION, count=1),
            lambda: again.advance(window_s=1e-3),
            lambda: again.checkpoint(token="a"),
        ]
        for command in commands:
            with pytest.raises(sturz.CommandError, match="recording") as refusal:
                command()
            assert refusal.value.code is sturz.ErrorCode.RECORDING
        with pytest.raises(sturz.CommandError, match="field/other"):
            again.field("other")
        twin = sturz_run("play", recording, "--name", "again", "--listen", "auto", "--connect", ready["endpoint"])
        assert twin.returncode == 5
        assert "again" in twin.stderr


def test_playing_at_the_pace_of_simulated_time_ends_when_told(recording: Path) -> None:
    """At this speed the next frame is hours away: an end that comes does not wait for it."""
    arguments = ["play", recording, "--name", "slow", "--listen", "auto", "--speed", "1e-8"]
    with started(*arguments) as (player, ready), sturz.connect("slow", endpoint=ready["endpoint"]) as slow:
        assert slow.info().state is sturz.RunState.RUNNING
        player.send_signal(signal.SIGTERM)
        assert player.wait(PATIENCE_S) == 0
    done = sturz_run("play", recording, "--name", "quick", "--listen", "auto", "--speed", "max", "--exit-at-end")
    assert done.returncode == 0, done.stderr


def test_cut_and_damaged_files_are_read_to_the_cut_and_refused_at_the_damage(recording: Path, tmp_path: Path) -> None:
    whole = recording.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) - 200])
    export = sturz_run("export", cut, "--out", tmp_path / "cut", "--what", "particles", "--json")
    assert export.returncode == 0, export.stderr
    assert "has no end" in export.stderr
    play = sturz_run("play", cut, "--listen", "auto", "--speed", "max", "--exit-at-end")
    assert play.returncode == 0, play.stderr
    assert "has no end" in play.stderr

    damaged = tmp_path / "damaged.mcap"
    # In the midst of the chunks, which are nearly all of the file.
    damaged.write_bytes(
        whole[: len(whole) // 2] + bytes([whole[len(whole) // 2] ^ 0x10]) + whole[len(whole) // 2 + 1 :]
    )
    export = sturz_run("export", damaged, "--out", tmp_path / "damaged")
    assert export.returncode == 1
    assert "damaged before byte" in export.stderr

    for name, content in (("empty", b""), ("text", b"[scene]\nname = 1\n"), ("magic", whole[:8])):
        path = tmp_path / f"{name}.mcap"
        path.write_bytes(content)
        refused = sturz_run("play", path, "--listen", "auto")
        assert refused.returncode == 1
        assert str(path) in refused.stderr
