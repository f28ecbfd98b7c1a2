# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the baker and asks it things that take no time."""
import json
import os
import pathlib
import shutil
import stat
import subprocess

NAME = "photic.exe" if os.name == "nt" else "photic"
SECONDS_TO_ANSWER = 60.0


class BakerError(Exception):
    """What went wrong, in words for the artist. `where` is the baker's: file:line, option or path; it may be empty."""

    def __init__(self, message, where=""):
        super().__init__(message)
        self.where = where


def find(chosen=""):
    """Path of the baker: the chosen one, $PHOTIC_PROGRAM, the add-on's own bin folder, or the search path.

    Raises BakerError when there is none.
    """
    if chosen:
        path = pathlib.Path(chosen).expanduser()
        if path.is_dir():
            path /= NAME
        if path.is_file() and os.access(path, os.X_OK):
            return str(path)
        raise BakerError(f"The baker '{path}' is missing or not a program; choose another in the add-on's preferences")
    for candidate in (os.environ.get("PHOTIC_PROGRAM", ""), carried(), shutil.which(NAME) or ""):
        if candidate and os.access(candidate, os.X_OK) and os.path.isfile(candidate):
            return candidate
    raise BakerError("The program 'photic' was not found; install it, or say where it is in the add-on's preferences")


def carried():
    """Path of the baker that the add-on's zip brought along, made runnable: unzipping forgets what may be run. "" without one."""
    path = pathlib.Path(__file__).resolve().parents[1] / "bin" / NAME
    if not path.is_file():
        return ""
    if not os.access(path, os.X_OK):
        try:
            path.chmod(path.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
        except OSError:         # installed for all by somebody else, who has to do it
            return ""
    return str(path)


def ask(program, *arguments):
    """Runs the baker and returns the JSON that it prints. Raises BakerError with its own words when it refuses."""
    command = [program, *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", errors="replace",
                              timeout=SECONDS_TO_ANSWER, check=False)
    except (OSError, subprocess.SubprocessError) as error:
        raise BakerError(f"'{program}' could not be run: {error}") from error
    if done.returncode != 0:
        raise error_of(done.stderr, done.returncode)
    try:
        return json.loads(done.stdout)
    except ValueError as error:
        raise BakerError(f"'{program}' answered something other than JSON; is it Photic's baker?") from error


def error_of(stderr, code):
    """The error that a run with --progress=json or plain messages ended with."""
    for line in reversed(stderr.strip().splitlines()):
        try:
            event = json.loads(line)
        except ValueError:
            continue
        if isinstance(event, dict) and event.get("event") == "error":
            return BakerError(event["message"], event.get("where", ""))
    last = stderr.strip().splitlines()[-1:] or [f"the baker stopped with exit code {code}"]
    return BakerError(last[0])
