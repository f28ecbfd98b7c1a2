# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake from first to last: export each frame, run the baker on it, lay out the atlas. Ticked by a timer, or by a loop.

Its files have names of their own (core/baked_files.py); of a frame range, those that have not changed are linked from the bake
before.
"""
import os
import pathlib
import re

import bpy

from ..core import baked_files, graded, process, words
from ..core.program import BakerError
from ..export import collect, write
from ..properties import method_options, preferences
from . import samples

current = None      # the job that runs, or None: one at a time


def output_folder(settings):
    """Folder of baked volumes. Of a file that was never saved: the session's temporary one. Raises BakerError."""
    folder = settings.folder
    if folder.startswith("//") and not bpy.data.filepath:
        path = pathlib.Path(bpy.app.tempdir) / folder[2:]
    else:
        path = pathlib.Path(bpy.path.abspath(folder))
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BakerError(f"The folder '{path}' cannot be made ({error.strerror}); choose another under Output") from error
    if not os.access(path, os.W_OK):
        raise BakerError(f"The folder '{path}' cannot be written to; choose another under Output")
    return path


def file_stem(scene):
    """A file's name from the scene's, which may hold anything."""
    return re.sub(r"[^\w.-]+", "_", scene.name).strip("._") or "scene"


class Job:
    """Call tick() until it returns True; it raises BakerError with the words for the artist. Then the result is in `settings`."""

    def __init__(self, context, frames=None):
        self.scene = context.scene
        self.settings = context.scene.photic
        self.frames = list(range(frames[0], frames[1] + 1)) if frames else []
        self.program = preferences.baker()
        self.folder = output_folder(self.settings)
        self.stem = file_stem(self.scene)
        self.before = baked_files.of(bpy.path.abspath(self.settings.volume_file))
        self.bake = baked_files.following(self.folder, self.stem)
        self.is_done = False
        self.parts = self.folder / f"{self.stem}_scene"
        self.parts.mkdir(exist_ok=True)
        self.notes = []
        self.collected = None
        self.cancelled = False
        self.kept = 0                               # frames that had not changed
        self._frame_before = self.scene.frame_current
        self._steps = iter(self._all_steps())
        self._share = (0.0, 0.0)                    # where the current run begins and how much of the whole it is
        self.run = None
        self.volume = None                          # that is voxelised now, before the bake that reads it
        self.text = None
        self.reference = None
        self.light_errors = ""

    # Progress, for panels
    @property
    def fraction(self):
        return self._share[0] + self._share[1] * (self.run.fraction if self.run else 0.0)

    @property
    def words(self):
        if not self.run:
            return "Reading the scene"
        if self.volume:
            return f"Voxelising {self.volume.names}: {100 * self.run.stage_fraction:.0f} %"
        left = f", {self.run.eta_s:.0f} s left" if self.run.eta_s is not None and not self.frames else ""
        return f"{self.run.stage.capitalize()}: {100 * self.fraction:.0f} %{left}"

    def tick(self):
        """One step, or a look at the run; True at the end."""
        if self.run and not self.run.poll():
            return False
        if self.run:
            self._take_result()
            self.run = self.volume = None
        try:
            next(self._steps)
        except StopIteration:
            return True
        return False

    def cancel(self):
        if self.run:
            self.run.cancel()
        self.cancelled = True
        self._steps = iter(())

    def end(self):
        """Puts the scene's frame back, whatever happened; of a bake that was not done nothing stays."""
        if not self.is_done:
            self.bake.remove()
        if self.frames and self.scene.frame_current != self._frame_before:
            self.scene.frame_set(self._frame_before)

    def _all_steps(self):
        volumes = []
        beside = self.before and (self.before.folder, self.before.stem) == (self.bake.folder, self.bake.stem)
        if self.frames and beside and self.settings.sequence_count:
            baked_files.link_frames(self.before, self.bake)
        count = max(len(self.frames), 1)
        for number, frame in enumerate(self.frames or [None]):
            self._share = (0.9 * number / count, 0.9 / count)
            if frame is not None:
                self.scene.frame_set(frame)
            yield
            path, volume = self._export(frame)
            volumes.append(volume)
            for samples_of in samples.missing(self.text):
                self.volume, self.run = samples_of, samples.start(samples_of, self.program)
                yield
            arguments = ["bake", str(path), "-o", str(self._pattern("vdb"))]
            if frame is not None:
                arguments += ["--frames", f"{frame}-{frame}"]
            self.run = process.Run(self.program, *arguments, "--threads", str(preferences.threads()))
            yield
        self._share = (0.9, 0.1)
        self._check_references(volumes)
        as_before = self._as_before(volumes)
        if as_before:
            self.bake.remove()
            self.bake = self.before
            volumes = as_before
        else:
            self.run = process.Run(self.program, "export", *map(str, volumes), "-o", str(self._pattern("exr")))
            yield
        self.is_done = True
        graded.tidy(self.parts)
        self._keep(volumes)

    def _pattern(self, extension):
        return self.folder / (f"{self.bake.name}.####.{extension}" if self.frames else f"{self.bake.name}.{extension}")

    def _export(self, frame):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.collected = collect.collect(depsgraph)
        self.text = write.scene_text(self.settings, self.collected, self.parts, method_options.methods())
        self.notes += [note for note in self.collected.notes if note not in self.notes]
        number = "" if frame is None else f".{frame:04d}"
        return (write.write(self.text, self.parts, f"{self.stem}{number}"),
                self.folder / f"{self.bake.name}{number}.vdb")

    def _take_result(self):
        run = self.run
        if self.cancelled or run.cancelled:
            self.cancelled = True
            self._steps = iter(())
            return
        if run.error and self.volume:
            raise samples.error_of(self.volume, run.error)
        if run.error:
            owner = self.text.owner_of(run.error.where)
            said = words.plain(str(run.error))
            raise BakerError(f"{owner}: {said}" if owner else said, owner)
        for warning in map(words.plain, run.warnings):
            if ("", warning) not in self.notes:
                self.notes.append(("", warning))
        report = run.done["report"] if run.done else None
        if report:
            self.kept += bool(report["up_to_date"])
            self.light_errors = words.light_errors(report) or self.light_errors
            reference = report.get("reference_irradiance")
            if reference is not None:
                if self.reference is not None and abs(reference / self.reference - 1) > 1e-6:
                    raise BakerError("The sun's strength changes over the frames; a sequence has one reference. "
                                     "Keep the sun's strength, and animate Photic's Strength instead")
                self.reference = reference

    def _check_references(self, volumes):
        missing = [volume for volume in volumes if not volume.exists()]
        if missing:
            raise BakerError(f"The baker said that it was done, but '{missing[0]}' is not there")

    def _as_before(self, volumes):
        """The volumes of the bake before, when every frame was kept and they have their atlases; then nothing is to do."""
        if self.kept != len(volumes) or not self.frames:
            return []
        old = [volume.with_name(self.before.name + volume.name[len(self.bake.name):]) for volume in volumes]
        whole = all(path.exists() and path.stat().st_mtime >= volume.stat().st_mtime
                    for volume in old for path in (volume.with_suffix(".exr"), volume.with_suffix(".exr.json")))
        return old if whole else []

    def _keep(self, volumes):
        """Writes down in the scene what was baked."""
        s = self.settings
        relative = bpy.path.relpath if bpy.data.filepath else str
        s.volume_file = relative(str(volumes[0]))
        s.atlas_file = relative(str(volumes[0].with_suffix(".exr.json")))
        s.sequence_start, s.sequence_count = (self.frames[0], len(self.frames)) if self.frames else (0, 0)
        level = collect.still_level(self.collected)
        s.level = max(level, -1e30)
        refractors = [item.mean_ior() for item in self.collected.items if item.is_open()]
        s.ior = refractors[0] if refractors else 1.0
        medium = self.collected.medium
        s.has_density = write.has_density(self.collected)
        s.forms = self.collected.forms_words
        s.light_errors = self.light_errors
        s.baked_absorption, s.baked_scattering, s.baked_anisotropy = medium.absorption, medium.scattering, medium.anisotropy
