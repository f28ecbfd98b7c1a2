# SPDX-License-Identifier: GPL-3.0-or-later
"""The baker's methods and their options, as `photic methods --json` lists them (docs/schemas/methods.md)."""
import dataclasses
import json
import pathlib

from . import program

SCHEMA = "photic-methods-1"


@dataclasses.dataclass(frozen=True)
class Option:
    name: str
    type: str               # flag, integer, number or choice
    unit: str
    default: object
    help: str
    min: float = None
    max: float = None
    choices: tuple = ()


@dataclasses.dataclass(frozen=True)
class Method:
    name: str
    summary: str
    grids: tuple
    options: tuple


def parse(document):
    """Methods of a catalogue's JSON. Raises BakerError when it is of a schema that this add-on does not know."""
    if document.get("schema") != SCHEMA:
        raise program.BakerError(f"The baker's catalogue is '{document.get('schema')}', and this add-on reads '{SCHEMA}'; "
                                 "install the add-on and the baker of one release")
    known = {field.name for field in dataclasses.fields(Option)}

    def option(row):
        row = {key: value for key, value in row.items() if key in known}
        return Option(**{**row, "choices": tuple(row.get("choices", ()))})

    return tuple(Method(row["name"], row["summary"], tuple(row["grids"]), tuple(option(o) for o in row["options"]))
                 for row in document["methods"])


def load(chosen, cache):
    """The catalogue of the baker at hand, kept in the file `cache` for when there is none; empty without either."""
    cache = pathlib.Path(cache)
    try:
        document = program.ask(program.find(chosen), "methods", "--json")
        methods = parse(document)
    except program.BakerError:
        try:
            return parse(json.loads(cache.read_text(encoding="utf-8")))
        except (OSError, ValueError, KeyError, program.BakerError):
            return ()
    try:
        cache.parent.mkdir(parents=True, exist_ok=True)
        cache.write_text(json.dumps(document), encoding="utf-8")
    except OSError:
        pass    # a read-only configuration folder: ask again next time
    return methods
