"""The studio's only door: every request passes the rules of access, then reaches its browser's own session."""

import re
import secrets
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from pathlib import Path
from typing import Any

from aiohttp import BodyPartReader, WSMsgType, web
from wslink.backends.generic.core import WsConnection

from planner.errors import InputError
from scenes.studio.access import (
    REPORT_POLICY,
    SECURITY_HEADERS,
    TOKEN_FIELD,
    Access,
    page_policy,
    read_cookie,
)
from scenes.studio.archives import ARCHIVES, pack
from scenes.studio.job import Job
from scenes.studio.queue import JobQueue
from scenes.studio.session import BrowserSession
from scenes.studio.workspace import LARGEST_UPLOAD_MB, owner_of, upload_suffixes
from scenes.whole_file import whole_file

BROWSER_COOKIE = "lce_studio_browser"
BROWSER_ID = re.compile(r"[A-Za-z0-9_-]{20,60}")
YEAR_S = 365 * 24 * 3600
SHOWN = (".html", ".png")
"""Files that open in the browser; others are saved."""
READ_ONLY = ("GET", "HEAD")
CHUNK_BYTES = 1 << 16

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

ENTERED = "<!doctype html><meta http-equiv=refresh content='0; url=/'><title>lce studio</title>"
REFUSED = (
    "<!doctype html><html lang=en><title>lce studio</title><body style='font: 16px/1.5 system-ui; margin: 3rem'>"
    "<h1>Refused</h1><p>{reason}. Open the address that <code>lce studio</code> printed when it started; each start "
    "has a new one.</p>"
)


class Gateway:
    """The web application of a studio."""

    def __init__(self, access: Access, queue: JobQueue) -> None:
        self._access, self._queue = access, queue
        self._sessions: dict[str, BrowserSession] = {}
        self.app = web.Application(middlewares=[self._guard], client_max_size=CHUNK_BYTES)
        self.app.on_response_prepare.append(self._set_headers)
        self.app.add_routes(
            [
                web.get("/", self._index),
                # Browsers ask for it on every page that names no icon, as the one that lets them in.
                web.get("/favicon.ico", self._icon),
                web.get("/ws", self._socket),
                # The page's client asks a launcher for its session before it opens the WebSocket.
                web.post("/paraview/", self._launch),
                web.post("/upload", self._upload),
                web.get(f"/runs/{{job}}/{{archive:{'|'.join(ARCHIVES)}}}", self._archive),
                web.get("/runs/{job}/{name}", self._file),
            ]
        )
        self._add_static(BrowserSession(owner_of(""), queue))

    def _add_static(self, pattern: BrowserSession) -> None:
        """Serve what pages are made of; it is the same for all sessions."""
        self._www = Path(pattern.server._www)
        for route, folder in pattern.server.serve.items():
            self.app.router.add_static(f"/{route}", folder)
        self.app.router.add_static("/", self._www)

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse what does not come from the studio's own page, before anything else looks at it."""
        entering = request.path == "/" and TOKEN_FIELD in request.query
        reason = self._access.refusal(
            request.headers,
            query_token=request.query[TOKEN_FIELD] if entering else None,
            origin_needed=request.method not in READ_ONLY or request.path == "/ws",
        )
        if reason is None:
            return await handler(request)
        text = REFUSED.format(reason=reason.capitalize())
        return web.Response(status=HTTPStatus.FORBIDDEN, text=text, content_type="text/html")

    async def _set_headers(self, request: web.Request, response: web.StreamResponse) -> None:
        for name, value in SECURITY_HEADERS.items():
            response.headers[name] = value
        response.headers.setdefault("Content-Security-Policy", page_policy(self._access.port))

    async def _index(self, request: web.Request) -> web.StreamResponse:
        """Let a browser in that has the token, and take the token out of its address; then show the page."""
        if TOKEN_FIELD not in request.query:
            return web.FileResponse(self._www / "index.html")
        known = read_cookie(request.headers, BROWSER_COOKIE) or ""
        browser = known if BROWSER_ID.fullmatch(known) else secrets.token_urlsafe(24)
        # A page that goes on by itself, no redirect: after one from elsewhere, browsers hold strict cookies back.
        answer = web.Response(text=ENTERED, content_type="text/html")
        kept: dict[str, Any] = {"httponly": True, "samesite": "Strict", "path": "/"}
        answer.set_cookie(self._access.cookie_name, self._access.token, **kept)
        answer.set_cookie(BROWSER_COOKIE, browser, max_age=YEAR_S, **kept)
        return answer

    async def _icon(self, _: web.Request) -> web.StreamResponse:
        return web.FileResponse(self._www / "logo.png")

    def _session(self, request: web.Request) -> BrowserSession:
        """Return the session of the browser that asks."""
        browser = read_cookie(request.headers, BROWSER_COOKIE) or ""
        if not BROWSER_ID.fullmatch(browser):
            raise web.HTTPForbidden(text="the browser is unknown; open the printed address again")
        owner = owner_of(browser)
        if owner not in self._sessions:
            self._sessions[owner] = BrowserSession(owner, self._queue)
        return self._sessions[owner]

    async def _launch(self, request: web.Request) -> web.StreamResponse:
        self._session(request)
        return web.json_response({"sessionURL": f"ws://{request.host}/ws"})

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        """Join the page's WebSocket with its session's server."""
        session = self._session(request)
        socket = web.WebSocketResponse(max_msg_size=16 << 20, heartbeat=30.0)
        await socket.prepare(request)
        endpoint = session.server._server["ws"]
        connection = WsConnection()

        async def send(_is_binary: bool, message: Any) -> None:
            if not socket.closed:
                await socket.send_bytes(message)

        connection.on_message(send)
        endpoint.connections[connection.client_id] = connection
        await connection.on_connect(endpoint)
        session.page_opened()
        try:
            async for message in socket:
                if message.type == WSMsgType.BINARY:
                    await connection.send(True, message)
        finally:
            session.page_closed()
            await endpoint.onClose(connection.client_id)
            endpoint.connections.pop(connection.client_id, None)
            connection.closed = True
        return socket

    async def _upload(self, request: web.Request) -> web.StreamResponse:
        """Store a file that the page sends, and tell its session."""
        session = self._session(request)
        kind = "calibration" if request.query.get("kind") == "calibration" else "target"
        try:
            path = await self._store(request, kind)
        except InputError as error:
            session.refused(error.problems)
            return web.Response(status=HTTPStatus.BAD_REQUEST, text="\n".join(error.problems))
        session.uploaded(kind, path)
        return web.Response(text="stored")

    async def _store(self, request: web.Request, kind: str) -> Path:
        """Write an uploaded file, whole or not at all.

        Raises:
            InputError: if there is none, or it is too large or of a wrong kind.
        """
        part = await (await request.multipart()).next()
        if not isinstance(part, BodyPartReader) or not part.filename:
            raise InputError("upload: there is no file in it; choose one.")
        path = self._queue.workspace.new_upload(part.filename, upload_suffixes(kind))
        try:
            with whole_file(path) as scratch, scratch.open("wb") as file:
                size = 0
                while chunk := await part.read_chunk(CHUNK_BYTES):
                    size += len(chunk)
                    if size > LARGEST_UPLOAD_MB << 20:
                        raise InputError(
                            f"upload: {path.name} is larger than {LARGEST_UPLOAD_MB} MB, the most that is taken; "
                            "coarsen the surface, or use the command line."
                        )
                    file.write(chunk)
        except BaseException:
            path.parent.rmdir()
            raise
        return path

    def _job(self, request: web.Request) -> Job:
        job = self._queue.jobs.get(request.match_info["job"])
        if job is None:
            raise web.HTTPNotFound
        return job

    async def _file(self, request: web.Request) -> web.StreamResponse:
        """Send a file of a job; what opens in the browser has no way to the studio."""
        job, name = self._job(request), request.match_info["name"]
        path = job.download(name)
        if path is None:
            raise web.HTTPNotFound
        headers = {"Content-Security-Policy": REPORT_POLICY}
        if path.suffix not in SHOWN:
            headers["Content-Disposition"] = f'attachment; filename="{_file_name(job, name)}"'
        return web.FileResponse(path, headers=headers)

    async def _archive(self, request: web.Request) -> web.StreamResponse:
        """Send exports of a job in one archive."""
        job, name = self._job(request), request.match_info["archive"]
        packed = await pack(job, name)
        if packed is None:
            raise web.HTTPNotFound
        headers = {"Content-Disposition": f'attachment; filename="{_file_name(job, name)}"'}
        return web.Response(body=packed, content_type="application/zip", headers=headers)


def _file_name(job: Job, name: str) -> str:
    """Return a name that tells downloads of several jobs apart."""
    return f"{job.request.target_name}-{job.request.method}-{name}"
