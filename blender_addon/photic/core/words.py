# SPDX-License-Identifier: GPL-3.0-or-later
"""The baker's words as an artist's: it speaks of scene files and their keys, and the artist sees objects and panels."""
import re

_SAID_AS = (
    # Files that the add-on has written itself, named by what is in them.
    (re.compile(r"'?(?:[^\s']*/)?[0-9a-f]{16}\.ply'?"), "its mesh"),
    (re.compile(r"'?(?:[^\s']*/)?[0-9a-f]{16}\.exr'?"), "its heights"),
    (re.compile(r'set event = "reflect"'), "choose the role Mirror"),
    (re.compile(r"\bvoxel_size = "), "Voxel size "),
    (re.compile(r"\bvoxel_size\b"), "Voxel size"),
    (re.compile(r"\[domain\]"), "the Domain"),
    (re.compile(r"\bangular_diameter = 0\b"), "the sun's Angle 0"),
    (re.compile(r"\bangular_diameter\b"), "the sun's Angle"),
    (re.compile(r"\bbeams\.disc ?= ?\"?off\"?"), "Method > Disc > Off"),
    (re.compile(r'\bwhere = "receivers"'), "Where: At receivers"),
    (re.compile(r"\(--max-memory\)"), ""),
)


def plain(message):
    """A message with what only the command line knows said as the panels say it."""
    for pattern, words in _SAID_AS:
        message = pattern.sub(words, message)
    return message


def light_errors(report):
    """How far the light on receivers is off, and what would halve that, as a bake's report says it; "" where it does not."""
    receivers = report.get("receivers", [])
    if not receivers:
        return ""
    worst = max(receivers, key=lambda receiver: receiver["relative_l1"])
    said = f"Light on '{worst['name']}' is off by {100 * worst['relative_l1']:.2g} % at {1000 * worst['detail']:.2g} mm"
    narrower = re.search(r"voxels of ([0-9.e+-]+) mm", report.get("advice", ""))
    return said + (f"; half of it with voxels of {narrower[1]} mm" if narrower else "")
