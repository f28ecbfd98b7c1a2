# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of bodies whose index varies, made by `photic voxelise` before whatever reads the scene file; kept by their names,
which say what is in them."""
from ..core import process, words
from ..core.program import BakerError
from ..properties import preferences

BLOCKED_INTERVAL_SECONDS = 0.02


def missing(text):
    """Of a scene file, the Volumes that have to be made."""
    return [volume for volume in text.volumes if not volume.is_there()]


def start(volume, program):
    return process.Run(program, *volume.arguments, "--threads", str(preferences.threads()))


def error_of(volume, error):
    """The baker's error as one about the object."""
    return BakerError(f"{volume.names} can't be voxelised: {words.plain(str(error))}", volume.owners[0])


def make_all(text):
    """Blocks until all of them are there. Raises BakerError with the object that is to blame."""
    for volume in missing(text):
        run = start(volume, preferences.baker())
        run.wait(interval=BLOCKED_INTERVAL_SECONDS)
        if run.error:
            raise error_of(volume, run.error)
