# SPDX-License-Identifier: GPL-3.0-or-later
"""Validate: what is wrong, in words. Estimate: voxels, MB and seconds."""
import bpy

from ..core import program, roles
from ..core import words as plain_words
from ..core.program import BakerError
from ..export import collect, write
from ..properties import method_options, preferences
from . import bake, job, samples

SCALE_TOLERANCE = 1e-4


def complaints(context):
    """What is wrong with the scene, (object's name, words) each; empty when all is well. The baker has the last word."""
    found = []
    scene = collect.collect(context.evaluated_depsgraph_get())
    bending = scene.of(roles.REFRACTOR, roles.MIRROR)
    if not bending and scene.rough:
        found += [note for note in scene.rough if note not in scene.notes]
    elif not bending:
        found.append(("", "Nothing bends light: give the water a material with transmission, or choose a role"))
    if not scene.lights:
        found.append(("", "No light is baked: add a Sun, or a lamp"))
    if not scene.of(roles.RECEIVER, roles.MOVABLE):
        found.append(("", "Nothing receives light: the volume will show in the water only"))
    for item in bending:
        found += _of_surface(context, item)
    found += scene.notes
    context.scene.photic.forms = scene.forms_words
    if bending and scene.lights:
        try:
            estimate(context, scene)
        except BakerError as error:
            words = str(error)
            if words not in [w for _, w in found]:
                found.append((error.where, words))
        found += [note for note in scene.notes if note not in found]    # those that writing it brought up
    return found


def _of_surface(context, item):
    obj = context.scene.objects.get(item.object_name)
    if item.is_graded() and not item.is_body():
        return
    if item.mesh.smooth_share < 0.5 and len(item.mesh.triangles) > 2:
        yield item.object_name, f"'{item.name}' is shaded flat: its light breaks into facets; choose Shade Smooth"
    if obj is not None and any(abs(s - 1) > SCALE_TOLERANCE for s in obj.scale) and any(
            m.type in {"OCEAN", "DISPLACE", "WAVE"} for m in obj.modifiers):
        yield item.object_name, f"'{item.name}' has the scale {tuple(round(s, 3) for s in obj.scale)}, which stretches its waves; apply it"
    if item.role == roles.REFRACTOR:
        normal = item.mesh.mean_normal()
        share = sum(n * n for n in normal) ** 0.5 / max(item.mesh.area(), 1e-12)
        if share < 0.05 and not item.mesh.closed:
            yield item.object_name, f"'{item.name}' is glass with holes: close the mesh, or leave only the side that light enters"


def estimate(context, scene=None):
    """The baker's --dry-run of the scene as it is now. Raises BakerError with the object that is to blame."""
    settings = context.scene.photic
    scene = scene or collect.collect(context.evaluated_depsgraph_get())
    folder = job.output_folder(settings) / f"{job.file_stem(context.scene)}_scene"
    folder.mkdir(exist_ok=True)
    text = write.scene_text(settings, scene, folder, method_options.methods())
    path = write.write(text, folder, job.file_stem(context.scene))
    samples.make_all(text)
    try:
        return program.ask(preferences.baker(), "bake", str(path), "--dry-run", "--json", "--progress=json",
                           "-o", str(folder.parent / f"{job.file_stem(context.scene)}.vdb"))
    except BakerError as error:
        owner = text.owner_of(error.where)
        said = plain_words.plain(str(error))
        raise BakerError(f"{owner}: {said}" if owner else said, owner) from error


def in_words(answer):
    """"2.1 million voxels, 42 MB in memory, 17 MB on disk, about 3 s"."""
    voxels = answer["needed_voxels"]
    count = f"{voxels / 1e6:.1f} million" if voxels >= 1e6 else f"{voxels:,}"
    words = (f"{count} voxels, {answer['memory_bytes'] / 1e6:.0f} MB in memory, {answer['file_bytes'] / 1e6:.0f} MB on disk, "
             f"about {max(answer['seconds'], 0.1):.1f} s with {answer['method']}")
    return words if answer["fits"] else f"Too large: {words}; the machine has {answer['memory_limit_bytes'] / 1e6:.0f} MB"


class PHOTIC_OT_validate(bpy.types.Operator):
    """Say in words what is wrong with the scene"""
    bl_idname = "photic.validate"
    bl_label = "Validate"

    def execute(self, context):
        try:
            found = complaints(context)
        except BakerError as error:
            bake.show_error(self, context, error)
            return {"CANCELLED"}
        context.scene.photic.message = "\n".join(words for _, words in found)
        for _, words in found:
            self.report({"WARNING"}, words)
        for words in filter(None, context.scene.photic.forms.split("\n")):
            self.report({"INFO"}, words)
        if not found:
            self.report({"INFO"}, "Nothing is wrong")
        return {"FINISHED"}


class PHOTIC_OT_estimate(bpy.types.Operator):
    """Ask the baker how many voxels, megabytes and seconds a bake would take"""
    bl_idname = "photic.estimate"
    bl_label = "Estimate"

    def execute(self, context):
        try:
            context.scene.photic.estimate = in_words(estimate(context))
        except BakerError as error:
            bake.show_error(self, context, error)
            return {"CANCELLED"}
        self.report({"INFO"}, context.scene.photic.estimate)
        return {"FINISHED"}
