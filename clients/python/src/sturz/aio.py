"""The client for asyncio: the same names, awaited.

>>> import asyncio, sturz.aio
>>> async def main():  # doctest: +SKIP
...     async with sturz.aio.launch("drum-crosses") as simulation:
...         await simulation.advance(window_s=0.1)
...         print((await simulation.state()).positions_m.shape)
>>> asyncio.run(main())  # doctest: +SKIP

A call that blocks runs in one of a few threads of the simulation's own. Streams need none: the bus wakes the loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import threading
from collections.abc import AsyncIterator, Callable, Coroutine, Generator
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Any, Concatenate, Generic, ParamSpec, Self, TypeVar

from . import simulation as blocking
from .daemon import Daemon
from .errors import NotConnected, SturzError, Timeout
from .simulation import Simulation
from .stream import Stream

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")

# Calls under way at once; more wait for their turn. `pause`, `stop` and `close` have a thread of their own.
_CALLS = 8
# A pause may overtake the window that it is meant for: it is sent again until the window has ended.
_PAUSE_AGAIN_S = 0.2


async def _answer(
    pool: ThreadPoolExecutor,
    function: Callable[[], R],
    *,
    on_cancel: Callable[[asyncio.Future[R]], Coroutine[Any, Any, object]] | None = None,
    must_begin: bool = False,
) -> R:
    """Calls `function` on a thread. When cancelled it still waits for the end of what was begun (or `must_begin`);
    cancelled a second time it leaves that to the thread."""
    work = pool.submit(function)
    future = asyncio.wrap_future(work)
    try:
        return await asyncio.shield(future)
    except asyncio.CancelledError:
        if not must_begin and work.cancel():
            raise  # it had not begun
        future.add_done_callback(lambda done: done.cancelled() or done.exception())
        if on_cancel is not None:
            await on_cancel(future)
        await asyncio.wait([future])
        raise


def _awaited(
    method: Callable[Concatenate[Simulation, P], R],
) -> Callable[Concatenate[AsyncSimulation, P], Coroutine[Any, Any, R]]:
    """The twin of a method that is answered soon."""

    @functools.wraps(method)
    async def twin(self: AsyncSimulation, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return await self.call(method, self.blocking, *args, **kwargs)

    return twin


def _window(
    method: Callable[Concatenate[Simulation, P], R],
) -> Callable[Concatenate[AsyncSimulation, P], Coroutine[Any, Any, R]]:
    """The twin of a method that lets time go on: cancelling it pauses the simulation."""

    @functools.wraps(method)
    async def twin(self: AsyncSimulation, /, *args: P.args, **kwargs: P.kwargs) -> R:
        self._check()
        function = functools.partial(method, self.blocking, *args, **kwargs)
        return await _answer(self._calls, function, on_cancel=self._pause_until)

    return twin


def _urgent(
    method: Callable[Concatenate[Simulation, P], R],
) -> Callable[Concatenate[AsyncSimulation, P], Coroutine[Any, Any, R]]:
    """The twin of a method that must not wait for a free thread."""

    @functools.wraps(method)
    async def twin(self: AsyncSimulation, /, *args: P.args, **kwargs: P.kwargs) -> R:
        self._check()
        return await _answer(self._urgent_calls, functools.partial(method, self.blocking, *args, **kwargs))

    return twin


def _stream(
    method: Callable[Concatenate[Simulation, P], Stream[T]],
) -> Callable[Concatenate[AsyncSimulation, P], AsyncStream[T]]:
    """The twin of a method that opens a stream; opening one waits for nobody."""

    @functools.wraps(method)
    def twin(self: AsyncSimulation, /, *args: P.args, **kwargs: P.kwargs) -> AsyncStream[T]:
        self._check()
        return AsyncStream(method(self.blocking, *args, **kwargs))

    return twin


class AsyncStream(Generic[T]):
    """A `Stream` to iterate over with ``async for``; close it, or use it in an ``async with``.

    Attributes:
        blocking: the stream itself, with its counts.
    """

    def __init__(self, stream: Stream[T]) -> None:
        self.blocking = stream
        self._changed = asyncio.Event()
        loop = asyncio.get_running_loop()

        def wake() -> None:
            # A loop that has ended has nobody to wake.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._changed.set)

        stream.when_changed(wake)

    def __repr__(self) -> str:
        return f"Async{self.blocking!r}"

    async def next_frame(self, timeout_s: float | None = None) -> T | None:
        """The oldest frame that was not read; None when the stream has ended. A cancelled call takes none.

        Raises:
            Timeout: none came within `timeout_s`.
            DaemonGone: the daemon is lost, and all that came before was read.
        """
        try:
            async with asyncio.timeout(timeout_s):
                while True:
                    self._changed.clear()
                    try:
                        return self.blocking.next_frame(timeout_s=0.0)
                    except Timeout:
                        await self._changed.wait()
        except TimeoutError as error:
            raise Timeout(f"{self.blocking.name}: no frame within {timeout_s:g} s") from error

    def latest(self) -> T | None:
        """The newest frame that was not read, and none older; None when there is none."""
        return self.blocking.latest()

    async def __aiter__(self) -> AsyncIterator[T]:
        while (frame := await self.next_frame()) is not None:
            yield frame

    async def close(self) -> None:
        """Ends the stream."""
        self.blocking.close()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()


class AsyncSimulation:
    """A connected simulation. Its methods are those of `Simulation`, awaited; those that open a stream return an
    `AsyncStream` at once.

    A call that is cancelled raises `asyncio.CancelledError` when the daemon has answered what was sent, so that nothing
    is under way behind the program's back; `step`, `advance` and `run_to` pause the simulation for it. What was not
    sent yet is not sent. A second cancellation does not wait.

    Attributes:
        blocking: the simulation itself. Its streams and `timeout_s` may be used; its methods block the loop.
    """

    def __init__(self, simulation: Simulation) -> None:
        self.blocking = simulation
        self._calls = ThreadPoolExecutor(_CALLS, thread_name_prefix="sturz call")
        self._urgent_calls = ThreadPoolExecutor(1, thread_name_prefix="sturz urgent call")
        self._closed = False

    def __repr__(self) -> str:
        return f"Async{self.blocking!r}"

    @property
    def instance(self) -> str:
        """Name on the bus."""
        return self.blocking.instance

    @property
    def endpoint(self) -> str:
        """Where the daemon listens."""
        return self.blocking.endpoint

    @property
    def daemon(self) -> Daemon | None:
        """The daemon that `launch` started; None after `connect`."""
        return self.blocking.daemon

    def _check(self) -> None:
        if self._closed:
            raise NotConnected(f"the simulation {self.instance!r} was closed")

    async def call(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Calls any function that blocks on a thread of this simulation, such as a method of a `Participant` of
        `blocking`."""
        self._check()
        return await _answer(self._calls, functools.partial(function, *args, **kwargs))

    async def _pause_until(self, window: asyncio.Future[Any]) -> None:
        while not window.done() and not self._closed:
            with contextlib.suppress(SturzError):
                await _answer(self._urgent_calls, self.blocking.pause)
            await asyncio.wait([window], timeout=_PAUSE_AGAIN_S)

    async def later(
        self, at_time_s: float, function: Callable[..., Coroutine[Any, Any, R]], **arguments: Any
    ) -> asyncio.Future[R]:
        """Has a command take effect before the first step that starts at or after a simulated time: see
        `Simulation.later`. Returns when the command is on its way; awaiting what is returned waits for its effect.

        Args:
            at_time_s: not before now, s.
            function: method of this simulation: insert, remove, set something, define or drop a field.
            arguments: of the method.
        """
        method: Callable[..., R] = getattr(self.blocking, function.__name__)

        def send() -> Future[R]:
            return self.blocking.later(at_time_s, method, **arguments)

        future = await self.call(send)
        # Cancelling the waiting does not take the command back.
        return asyncio.shield(asyncio.wrap_future(future))

    info = _awaited(Simulation.info)
    features = _awaited(Simulation.features)
    plan = _awaited(Simulation.plan)
    shapes = _awaited(Simulation.shapes)
    report = _awaited(Simulation.report)
    state = _awaited(Simulation.state)
    contacts = _awaited(Simulation.contacts)
    exchange = _awaited(Simulation.exchange)
    field = _awaited(Simulation.field)
    command = _awaited(Simulation.command)
    insert_poses = _awaited(Simulation.insert_poses)
    insert_lattice = _awaited(Simulation.insert_lattice)
    insert_random = _awaited(Simulation.insert_random)
    insert_deposition = _awaited(Simulation.insert_deposition)
    remove = _awaited(Simulation.remove)
    set_gravity = _awaited(Simulation.set_gravity)
    set_rotation = _awaited(Simulation.set_rotation)
    set_translation = _awaited(Simulation.set_translation)
    set_oscillation = _awaited(Simulation.set_oscillation)
    set_rotation_oscillation = _awaited(Simulation.set_rotation_oscillation)
    set_table = _awaited(Simulation.set_table)
    set_servo = _awaited(Simulation.set_servo)
    set_fixed = _awaited(Simulation.set_fixed)
    set_loads = _awaited(Simulation.set_loads)
    set_fluid = _awaited(Simulation.set_fluid)
    resume = _awaited(Simulation.resume)
    define_field = _awaited(Simulation.define_field)
    drop_field = _awaited(Simulation.drop_field)
    define_output = _awaited(Simulation.define_output)
    checkpoint = _awaited(Simulation.checkpoint)
    restore = _awaited(Simulation.restore)
    checkpoints = _awaited(Simulation.checkpoints)
    drop_checkpoint = _awaited(Simulation.drop_checkpoint)
    acquire_lease = _awaited(Simulation.acquire_lease)
    release_lease = _awaited(Simulation.release_lease)
    reconnect = _awaited(Simulation.reconnect)

    pause = _urgent(Simulation.pause)

    step = _window(Simulation.step)
    advance = _window(Simulation.advance)
    run_to = _window(Simulation.run_to)

    states = _stream(Simulation.states)
    contact_networks = _stream(Simulation.contact_networks)
    fields = _stream(Simulation.fields)
    reports = _stream(Simulation.reports)
    events = _stream(Simulation.events)

    def new_request_id(self) -> str:
        """An id that no request of this client has had."""
        return self.blocking.new_request_id()

    async def stop(self) -> None:
        """Ends the daemon, whoever started it, and closes this simulation."""
        await self._end(self.blocking.stop)

    async def close(self) -> None:
        """Ends streams, connection and threads; also the daemon when `launch` started it. Twice is harmless."""
        await self._end(self.blocking.close)

    async def _end(self, function: Callable[[], None]) -> None:
        if self._closed:
            return
        self._closed = True
        ended = threading.Event()

        def end() -> None:
            try:
                function()
            finally:
                # Whoever still waits for an answer was told that there will be none.
                self._calls.shutdown()
                ended.set()

        try:
            await _answer(self._urgent_calls, end, must_begin=True)
        finally:
            self._urgent_calls.shutdown(wait=ended.is_set())

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            await self.close()
        except BaseException:
            if error is None:
                raise


class Opening:
    """A simulation on its way: await it, or use it in an ``async with``."""

    def __init__(self, function: Callable[[], Simulation]) -> None:
        self._function = function
        self._simulation: AsyncSimulation | None = None

    async def _open(self) -> AsyncSimulation:
        pool = ThreadPoolExecutor(1, thread_name_prefix="sturz opening")

        opened: list[Simulation] = []
        idle = threading.Event()
        idle.set()

        def work() -> Simulation:
            idle.clear()
            try:
                opened.append(self._function())
            finally:
                idle.set()
            return opened[0]

        def close_opened() -> None:
            idle.clear()
            for each in opened:
                each.close()
            idle.set()

        async def close(_: asyncio.Future[Simulation]) -> None:
            # Nobody will have it, so nobody else would close it. The one thread comes to this when it is there.
            await asyncio.shield(asyncio.wrap_future(pool.submit(close_opened)))

        try:
            return AsyncSimulation(await _answer(pool, work, on_cancel=close))
        finally:
            pool.shutdown(wait=idle.is_set())

    def __await__(self) -> Generator[Any, None, AsyncSimulation]:
        return self._open().__await__()

    async def __aenter__(self) -> AsyncSimulation:
        self._simulation = await self._open()
        return self._simulation

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._simulation is not None
        await self._simulation.__aexit__(kind, error, trace)


def _opening(function: Callable[P, Simulation]) -> Callable[P, Opening]:
    @functools.wraps(function)
    def twin(*args: P.args, **kwargs: P.kwargs) -> Opening:
        return Opening(functools.partial(function, *args, **kwargs))

    return twin


connect = _opening(blocking.connect)
launch = _opening(blocking.launch)

__all__ = ["AsyncSimulation", "AsyncStream", "Opening", "connect", "launch"]
