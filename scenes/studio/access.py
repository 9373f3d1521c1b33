"""Who may talk to the studio: the user's own browser, from the studio's own page, with the token of this start.

The studio listens on the loopback interface only, yet any page that is open in any browser of the machine can send
requests there, and a name of an attacker's can be made to point there (DNS rebinding). So a request must name the
studio's own host, come from its own page, and carry the token that only the printed address has.
"""

import hmac
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

HOST = "127.0.0.1"
NAMES = (HOST, "localhost")
"""What the studio's host may be called in an address."""
TOKEN_FIELD = "token"
OWN_FETCH = ("same-origin", "none")
"""Values of Sec-Fetch-Site of a request by the page itself, or by the user in the address bar."""

SECURITY_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    # "no-referrer" would take the origin out of the page's own uploads.
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Sent with every answer."""
REPORT_POLICY = (
    "sandbox allow-scripts allow-modals allow-downloads; default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' "
    "data: blob:; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:; "
    "worker-src data: blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
"""For results: their scripts run without an origin, and reach neither the studio nor any other address."""


def page_policy(port: int) -> str:
    """Return the content security policy of the studio's page: nothing from elsewhere, nothing to elsewhere.

    Vue compiles templates in the browser, which needs eval.
    """
    sockets = " ".join(f"ws://{name}:{port}" for name in NAMES)
    return (
        "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        f"img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' {sockets}; worker-src 'self' blob:; "
        "frame-ancestors 'self'; base-uri 'self'; form-action 'self'; object-src 'none'"
    )


def new_token() -> str:
    """Return a token that nobody can guess."""
    return secrets.token_urlsafe(24)


@dataclass(frozen=True, kw_only=True)
class Access:
    """The rules of one start of the studio."""

    port: int
    token: str = field(default_factory=new_token, repr=False)

    @property
    def cookie_name(self) -> str:
        """Name of the cookie that carries the token: cookies do not tell ports apart, so the name must."""
        return f"lce_studio_{self.port}"

    @property
    def url(self) -> str:
        """The address to open, with the token."""
        return f"http://{HOST}:{self.port}/?{TOKEN_FIELD}={self.token}"

    def is_token(self, given: str | None) -> bool:
        """Say whether this is the token, in a time that tells nothing of where it differs."""
        return hmac.compare_digest((given or "").encode(), self.token.encode())

    def refusal(
        self, headers: Mapping[str, str], *, query_token: str | None = None, origin_needed: bool = False
    ) -> str | None:
        """Return why a request is refused, None if it is not.

        Args:
            headers: of the request, by names in any case if the mapping looks them up so.
            query_token: the token in the address, where there is one.
            origin_needed: for what changes something or opens a WebSocket, where browsers always send an origin.
        """
        hosts = [f"{name}:{self.port}" for name in NAMES]
        if headers.get("Host", "").lower() not in hosts:
            return "the host in the address is not this studio's"
        origin = headers.get("Origin")
        if (origin is None and origin_needed) or (origin is not None and not self._is_own(origin, hosts)):
            return "the request comes from another page"
        if query_token is not None:
            # The address of the start may be opened from anywhere, a terminal in a browser for one.
            return None if self.is_token(query_token) else "the token is wrong"
        if headers.get("Sec-Fetch-Site", "none") not in OWN_FETCH:
            return "the request comes from another page"
        return None if self.is_token(self._cookie(headers)) else "the token is missing or wrong"

    def _cookie(self, headers: Mapping[str, str]) -> str | None:
        return read_cookie(headers, self.cookie_name)

    @staticmethod
    def _is_own(origin: str, hosts: list[str]) -> bool:
        parts = urlsplit(origin)
        return parts.scheme == "http" and parts.netloc.lower() in hosts


def read_cookie(headers: Mapping[str, str], name: str) -> str | None:
    """Return the value of a cookie, None if there is none or they cannot be read."""
    try:
        cookies = SimpleCookie(headers.get("Cookie", ""))
    except CookieError:
        return None
    return cookies[name].value if name in cookies else None
