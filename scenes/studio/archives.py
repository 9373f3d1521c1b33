"""What `lce export` writes of a job, packed into one file to fetch."""

import asyncio
import io
import zipfile
from contextlib import suppress

from planner.errors import InputError
from scenes.exports import export_into
from scenes.studio.job import Job
from scenes.studio.request import HOT, PLAN

EXPORT = "export"
"""Folder of a job that exports are written into when they are first asked for."""
ARCHIVES = {"gcode.zip": "*.gcode", "exports.zip": "*"}
"""Which files are in an archive, by its name in the address."""

_one_by_one = asyncio.Lock()


async def pack(job: Job, name: str) -> bytes | None:
    """Return an archive of a job's exports, None if there is nothing to export yet."""
    async with _one_by_one:
        return await asyncio.to_thread(_pack, job, ARCHIVES[name])


def _pack(job: Job, pattern: str) -> bytes | None:
    # A prediction may have been added since the plan was exported.
    folder, sources = job.folder / EXPORT, [job.folder / PLAN, job.folder / HOT]
    for source in filter(lambda path: path.is_dir(), sources):
        with suppress(InputError):  # a prediction's folder is empty until it is whole
            export_into(folder, source)
    paths = sorted(folder.glob(pattern)) if folder.is_dir() else []
    if not paths:
        return None
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in paths:
            archive.write(path, path.name)
    return packed.getvalue()
