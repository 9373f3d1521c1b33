"""The 3-D library that the page brings along: plotly.js, as the plotly package ships it."""

import base64
import gzip
from dataclasses import dataclass
from functools import lru_cache

from scenes.report.security import script_hash


@dataclass(frozen=True, kw_only=True)
class PackedScript:
    """A script that the page unpacks when it is opened."""

    gzip_base64: str
    hash: str
    """What the page's policy must allow."""


@lru_cache(maxsize=1)
def packed_plotly() -> PackedScript:
    """Read plotly.js and pack it to less than half of its size."""
    from plotly.offline import get_plotlyjs

    text = get_plotlyjs()
    packed = gzip.compress(text.encode(), mtime=0)
    return PackedScript(gzip_base64=base64.b64encode(packed).decode("ascii"), hash=script_hash(text))
