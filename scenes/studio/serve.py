"""`lce studio`: open the door, say where it is, and close it tidily."""

import asyncio
import os
import signal
import socket
import sys
import webbrowser
from importlib.util import find_spec
from pathlib import Path

from planner.errors import InputError
from scenes.studio.access import HOST, Access
from scenes.studio.workspace import Workspace

NEEDED = ("aiohttp", "trame", "trame_vtk", "trame_vuetify")


def run_studio(workspace: Path, *, port: int, at_once: int, browser: bool) -> None:
    """Serve the studio until Ctrl-C.

    Args:
        workspace: folder of jobs and uploaded files.
        port: to listen on; 0 for any free one.
        at_once: so many jobs run at the same time.
        browser: open the page in the user's browser.

    Raises:
        InputError: if packages are missing, the port is taken, or the workspace cannot be used.
    """
    absent = [name for name in NEEDED if find_spec(name) is None]
    if absent:
        raise InputError(
            f"studio: {', '.join(absent)} not found; install the extra `studio`, in a clone by: "
            "pip install -e '.[studio]'."
        )
    # The page's library reads the command line of its process, which is not its own.
    os.environ["TRAME_ARGS"] = ""
    place = Workspace(workspace)
    with place.locked(), _listening(port) as listener:
        asyncio.run(_serve(place, listener, at_once=at_once, browser=browser))


def _listening(port: int) -> socket.socket:
    """Return a socket that listens on the loopback interface only."""
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
    except OSError as error:
        listener.close()
        raise InputError(
            f"--port: cannot listen on {port} ({error.strerror}); name another, or leave it out for any free one."
        ) from error
    return listener


async def _serve(workspace: Workspace, listener: socket.socket, *, at_once: int, browser: bool) -> None:
    from aiohttp import web

    from scenes.studio.gateway import Gateway
    from scenes.studio.queue import JobQueue

    queue = JobQueue(workspace, at_once=at_once)
    access = Access(port=listener.getsockname()[1])
    # Pages hold their connection open for ever: they are not waited for.
    runner = web.AppRunner(Gateway(access, queue).app, shutdown_timeout=0.5, access_log=None)
    await runner.setup()
    await web.SockSite(runner, listener).start()
    over = asyncio.Event()
    for sign in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(sign, over.set)
    sys.stdout.write(
        f"studio: {access.url}\n"
        f"        open this address in a browser of this machine; the token in it is new at each start\n"
        f"        results are kept in {workspace.folder}; Ctrl-C ends the studio and the jobs that run\n"
    )
    sys.stdout.flush()
    if browser:
        webbrowser.open(access.url)
    await over.wait()
    await queue.close()
    await runner.cleanup()
    sys.stdout.write("studio closed\n")
