# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of the baker: started in a session of its own, read by a thread, polled by whoever waits, and ended on request."""
import collections
import json
import os
import queue
import signal
import subprocess
import threading
import time

from .program import BakerError, error_of

SECONDS_TO_END = 5.0    # after which a run that was asked to end is killed
LINES_KEPT = 50         # of what is no event: a crash's last words


class Run:
    """One process with --progress=json. Call poll() until `finished`; then `error`, `cancelled` and `done` tell how it went."""

    def __init__(self, program, *arguments):
        self.fraction = 0.0
        self.stage = "start"
        self.stage_fraction = 0.0   # of the stage alone
        self.eta_s = None
        self.warnings = []
        self.done = None            # the event of that name
        self.error = None           # BakerError
        self.cancelled = False
        self.finished = False
        self._lines = queue.SimpleQueue()
        self._last_words = collections.deque(maxlen=LINES_KEPT)
        self._asked_to_end = None
        session = {"start_new_session": True} if os.name == "posix" else {
            "creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        try:
            self._process = subprocess.Popen(
                [program, *arguments, "--progress=json"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace", **session)
        except OSError as error:
            raise BakerError(f"'{program}' could not be started: {error}") from error
        self._reader = threading.Thread(target=self._read, name="photic progress", daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._process.stderr:
            self._lines.put(line)

    def poll(self):
        """Takes in what the baker has said since; returns whether it has ended."""
        if self.finished:
            return True
        ended = self._process.poll() is not None
        if ended:
            self._reader.join()
        while not self._lines.empty():
            self._take(self._lines.get())
        if self._asked_to_end and not ended and time.monotonic() - self._asked_to_end > SECONDS_TO_END:
            self._process.kill()
        if ended:
            self._process.stderr.close()
            self.finished = True
            self._judge(self._process.returncode)
        return self.finished

    def wait(self, on_progress=None, interval=0.05):
        """Blocks until the run has ended. For background mode, where no timer fires."""
        while not self.poll():
            if on_progress:
                on_progress(self)
            time.sleep(interval)

    def cancel(self):
        """Asks the baker to end; it leaves nothing half-written."""
        if self.finished or self._asked_to_end:
            return
        self._asked_to_end = time.monotonic()
        if os.name == "posix":
            self._process.send_signal(signal.SIGTERM)
        else:
            self._process.terminate()

    def _take(self, line):
        try:
            event = json.loads(line)
            kind = event["event"]
        except (ValueError, KeyError, TypeError):
            self._last_words.append(line.rstrip())
            return
        if kind == "progress":
            self.stage = event.get("stage", self.stage)
            self.stage_fraction = event.get("fraction", self.stage_fraction)
            self.fraction = event.get("overall", self.fraction)
            self.eta_s = event.get("eta_s")
        elif kind == "warning":
            self.warnings.append(event["message"])
        elif kind == "done":
            self.done = event
            self.fraction = 1.0
        elif kind == "error":
            self.error = BakerError(event["message"], event.get("where", ""))

    def _judge(self, code):
        if self._asked_to_end and code != 0:
            self.cancelled = True
            self.error = None
        elif code != 0 and not self.error:
            self.error = error_of("\n".join(self._last_words), code)
