"""A daemon of one's own: found, started, and surely ended."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import shutil
import subprocess
import sysconfig
import tempfile
import threading
import time
import weakref
from collections import deque
from pathlib import Path
from typing import IO, Any

from .errors import LaunchFailed

_REPOSITORY = Path(__file__).resolve().parents[4]


def find_binary(binary: str | os.PathLike[str] | None = None) -> Path:
    """The daemon: the argument, the environment's STURZ_BINARY, the repository's release build, the one beside this
    interpreter (where the wheel puts it), or the PATH.

    Raises:
        LaunchFailed: it is nowhere.
    """
    asked = binary or os.environ.get("STURZ_BINARY")
    if asked:
        path = Path(asked)
        if not path.is_file():
            raise LaunchFailed(f"the daemon {path} does not exist")
        return path.resolve()
    built = _REPOSITORY / "target" / "release" / "sturz"
    if built.is_file():
        return built
    found = shutil.which("sturz", path=sysconfig.get_path("scripts")) or shutil.which("sturz")
    if found is None:
        raise LaunchFailed(
            "no daemon found: build it with `cargo build --release -p sturz-service`, put `sturz` on the PATH, "
            "or name it in the environment variable STURZ_BINARY"
        )
    return Path(found)


def _end(process: subprocess.Popen[str], patience_s: float) -> None:
    """Ends the process: asks, insists, kills; always waits for it."""
    if process.stdin is not None:
        # The daemon ends when its standard input does.
        with contextlib.suppress(OSError):
            process.stdin.close()
    for insist in (None, process.terminate, process.kill):
        if insist is not None:
            insist()
        try:
            process.wait(timeout=patience_s)
            return
        except subprocess.TimeoutExpired:
            continue
    process.wait()


class Daemon:
    """A running `sturz serve` of ours.

    Attributes:
        process: the operating system's.
        endpoint: where it listens.
        instance: its name on the bus.
    """

    def __init__(
        self,
        *,
        scene: str | os.PathLike[str] | None,
        scene_text: str | None,
        name: str,
        threads: int | None,
        paused: bool,
        checkpoints: str | os.PathLike[str] | None,
        journal: str | os.PathLike[str] | None,
        resume: str | os.PathLike[str] | None,
        timeout_s: float,
        binary: str | os.PathLike[str] | None,
    ) -> None:
        if [scene, scene_text, resume].count(None) != 2:
            raise ValueError("give one of scene, scene_text and resume")
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        if scene_text is not None:
            self._folder = tempfile.TemporaryDirectory(prefix="sturz-")
            path = Path(self._folder.name) / "scene.toml"
            path.write_text(scene_text)
            scene = path
        command = [str(find_binary(binary)), "serve", "--name", name]
        command += [os.fspath(scene)] if scene is not None else []
        command += ["--journal", os.fspath(journal)] if journal is not None else []
        command += ["--resume", os.fspath(resume)] if resume is not None else []
        command += ["--listen", "tcp/127.0.0.1:0", "--stop-on-stdin-eof", "--json"]
        command += ["--paused"] if paused else []
        command += ["--threads", str(threads)] if threads is not None else []
        command += ["--checkpoints", os.fspath(checkpoints)] if checkpoints is not None else []
        # A session of its own: Ctrl-C belongs to the Python program, which then ends the daemon in its own time.
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            start_new_session=True,
        )
        self._finalizer = weakref.finalize(self, _end, self.process, 2.0)
        self.said: deque[str] = deque(maxlen=200)
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        for stream, lines in ((self.process.stdout, self._lines), (self.process.stderr, None)):
            threading.Thread(target=_drain, args=(stream, self.said, lines), daemon=True).start()
        try:
            ready = self._wait(timeout_s)
            self.endpoint = str(ready["endpoint"])
            self.instance = str(ready.get("instance", name))
        except BaseException:
            self.close()
            raise

    def _wait(self, timeout_s: float) -> dict[str, Any]:
        deadline = time.monotonic() + timeout_s
        while True:
            try:
                line = self._lines.get(timeout=max(deadline - time.monotonic(), 0.0))
            except queue.Empty:
                raise LaunchFailed(f"the daemon was not ready within {timeout_s:g} s:\n{self.last_words()}") from None
            if line is None:
                status = self.process.wait()
                time.sleep(0.05)  # let the other pipe be drained
                raise LaunchFailed(f"the daemon ended with status {status}:\n{self.last_words()}")
            if line.startswith("ready "):
                answer: dict[str, Any] = json.loads(line.removeprefix("ready "))
                return answer

    def last_words(self) -> str:
        """The end of what it wrote."""
        return "\n".join(list(self.said)[-20:]) or "(it said nothing)"

    def close(self, patience_s: float = 5.0) -> int:
        """Ends the process, waits for it, and returns its status."""
        if self._finalizer.detach() is not None:
            _end(self.process, patience_s)
        if self._folder is not None:
            self._folder.cleanup()
        return self.process.wait()


def _drain(stream: IO[str], said: deque[str], lines: queue.SimpleQueue[str | None] | None) -> None:
    """Reads a pipe to its end: a full one would block the daemon."""
    with stream:
        for line in stream:
            said.append(line.rstrip("\n"))
            if lines is not None:
                lines.put(line)
    if lines is not None:
        lines.put(None)
