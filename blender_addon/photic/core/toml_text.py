# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes scene files (docs/scene.md), and remembers which line speaks of what."""
import json
import math
import numbers


def value_text(value):
    """A TOML value. Raises ValueError for what TOML's readers refuse: infinities and NaN."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        if not math.isfinite(value):
            raise ValueError(f"{value} is no number that a scene can hold")
        return repr(float(value))       # numpy's own numbers say their type since its version 2
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")  # JSON's escapes are TOML's
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {value_text(item)}" for key, item in value.items()) + " }"
    return "[" + ", ".join(value_text(item) for item in value) + "]"


class SceneText:
    """Tables in the order in which they are added. `owner` names the Blender object that a table was made from."""

    def __init__(self):
        self._lines = ["photic = 1"]
        self._owners = []       # (first line, owner), both growing
        self.volumes = []       # core.graded.Volume: files that the scene names, and that are to be made before a bake

    def add(self, heading, table, owner=""):
        """`heading` with its brackets: "[domain]" or "[[light]]". Keys whose value is None are left out."""
        self._lines += ["", heading]
        self._owners.append((len(self._lines), owner))
        self._lines += [f"{key} = {value_text(value)}" for key, value in table.items() if value is not None]

    def owner_of(self, where):
        """The object that the baker's `where` ("scene.toml:12:5") is about, or ""."""
        for part in where.rsplit(".toml:", 1)[1:]:
            digits = part.split(":", 1)[0]
            if digits.isdigit():
                owners = [owner for first, owner in self._owners if first <= int(digits)]
                return owners[-1] if owners else ""
        return ""

    def __str__(self):
        return "\n".join(self._lines) + "\n"
