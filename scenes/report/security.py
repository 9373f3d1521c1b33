"""What the page may do: run its own scripts and show its own pictures; never speak to anything outside."""

import base64
import hashlib
from collections.abc import Sequence


def script_hash(text: str) -> str:
    """Return the hash by which a policy names a script."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode('ascii')}'"


def content_policy(script_hashes: Sequence[str]) -> str:
    """Return the page's content security policy: with it a browser refuses every other script and every request."""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {' '.join(script_hashes)}",
            "style-src 'unsafe-inline'",
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
