"""Streams keep the newest, count what was lost, and swallow no exception."""

import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

import sturz
from sturz._proto.sturz.v1 import data_pb2 as pb


def stream(keep: int = 4) -> sturz.Stream[int]:
    """A stream of frames that are read as their sequence numbers."""
    return sturz.Stream(name="state/frame", decode=pb.Frame.FromString, convert=lambda m: int(m.header.seq), keep=keep)


def frame(seq: int, run_id: str = "run") -> bytes:
    """One frame on the wire."""
    message = pb.Frame()
    message.header.seq, message.header.run_id = seq, run_id
    return bytes(message.SerializeToString())


@given(st.sets(st.integers(0, 200), min_size=1, max_size=60), st.integers(1, 10))
def test_a_slow_reader_gets_the_newest_and_knows_what_it_lost(numbers: set[int], keep: int) -> None:
    seqs = sorted(numbers)
    frames = stream(keep)
    for seq in seqs:
        frames.receive(frame(seq))
    frames.end(None)
    assert list(frames) == seqs[-keep:]
    assert frames.received == len(seqs)
    assert frames.dropped_here == max(len(seqs) - keep, 0)
    assert frames.dropped_on_the_way == seqs[-1] - seqs[0] + 1 - len(seqs)
    assert frames.dropped == frames.dropped_here + frames.dropped_on_the_way


def test_a_restarted_run_or_stream_is_no_gap() -> None:
    frames = stream()
    for payload in (frame(7), frame(90, "another"), frame(91, "another"), frame(0, "another"), frame(2, "another")):
        frames.receive(payload)
    assert frames.dropped_on_the_way == 1


def test_the_latest_is_the_newest_and_forgets_the_rest() -> None:
    frames = stream()
    assert frames.latest() is None
    for seq in range(3):
        frames.receive(frame(seq))
    assert frames.latest() == 2
    assert frames.dropped_here == 2
    assert frames.latest() is None


def test_waiting_ends_with_a_frame_a_timeout_or_the_end() -> None:
    frames = stream()
    with pytest.raises(sturz.Timeout, match=r"no frame within 0\.05 s"):
        frames.next_frame(timeout_s=0.05)
    threading.Timer(0.05, frames.receive, [frame(5)]).start()
    assert frames.next_frame(timeout_s=10.0) == 5
    threading.Timer(0.05, frames.close).start()
    assert frames.next_frame(timeout_s=10.0) is None


def test_a_lost_daemon_is_told_after_all_frames_were_read() -> None:
    frames = stream()
    frames.receive(frame(1))
    frames.end(sturz.DaemonGone("gone"))
    frames.receive(frame(2))
    assert frames.next_frame() == 1
    with pytest.raises(sturz.DaemonGone):
        frames.next_frame()


def test_bytes_that_are_no_frame_are_told_to_the_reader() -> None:
    frames = stream()
    frames.receive(b"\xff" * 20)
    with pytest.raises(sturz.ProtocolError, match="20 bytes are no such message"):
        next(iter(frames))


def test_for_each_gets_frames_and_ends_with_the_stream() -> None:
    seen: list[int] = []
    with stream(keep=100).for_each(seen.append) as frames:
        for seq in range(50):
            frames.receive(frame(seq))
        wait_until(lambda: len(seen) == 50)
    assert seen == list(range(50))


def test_an_exception_of_a_for_each_callback_is_raised_by_close() -> None:
    def broken(seq: int) -> None:
        raise ZeroDivisionError(f"frame {seq}")

    frames = stream().for_each(broken)
    frames.receive(frame(3))
    wait_until(lambda: frames._ended)
    with pytest.raises(ZeroDivisionError, match="frame 3"):
        frames.close()
    frames.close()  # once is enough


def test_an_exception_of_a_for_each_callback_is_raised_at_the_end_of_a_with() -> None:
    def broken(seq: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError), stream().for_each(broken) as frames:
        frames.receive(frame(1))
        wait_until(lambda: frames._ended)


def test_the_exception_of_the_with_says_more_than_that_of_the_callback() -> None:
    def broken(seq: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(KeyError, match="mine"), stream().for_each(broken) as frames:
        frames.receive(frame(1))
        wait_until(lambda: frames._ended)
        raise KeyError("mine")


def test_a_callback_may_close_its_own_stream() -> None:
    frames = stream()
    frames.for_each(lambda _: frames.close())
    frames.receive(frame(1))
    wait_until(lambda: frames._ended)
    assert frames.next_frame(timeout_s=1.0) is None


def test_only_one_callback_and_at_least_one_frame() -> None:
    frames = stream().for_each(print)
    with pytest.raises(RuntimeError, match="for_each was called before"):
        frames.for_each(print)
    frames.close()
    with pytest.raises(ValueError, match="keep is 0"):
        stream(keep=0)


def test_closing_undoes_the_subscription_once() -> None:
    undone: list[str] = []
    frames = stream()
    frames.at_close(lambda: undone.append("subscription"))
    frames.close()
    frames.close()
    assert undone == ["subscription"]


def wait_until(condition: object, timeout_s: float = 10.0) -> None:
    """Waits for another thread."""
    end = time.monotonic() + timeout_s
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end, "it never came true"
        time.sleep(0.005)
