# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake, Cancel, Load and Export."""
import bpy

from ..core.program import BakerError
from ..export import collect, write
from ..properties import method_options
from . import job, kept_bakes, preview_state, samples

TICK_SECONDS = 0.1
BLOCKED_INTERVAL_SECONDS = 0.02


def stop():
    """Ends the bake that runs, for when the add-on goes."""
    if job.current:
        job.current.cancel()
        job.current.end()
        job.current = None


def redraw(context):
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "PROPERTIES"}:
                area.tag_redraw()


def show_error(operator, context, error):
    """Says what went wrong, and selects the object that it is about."""
    context.scene.photic.message = str(error)
    obj = context.view_layer.objects.get(getattr(error, "where", "") or "")
    if obj is not None and context.mode == "OBJECT":
        for other in context.selected_objects:
            other.select_set(False)
        obj.select_set(True)
        context.view_layer.objects.active = obj
    operator.report({"ERROR"}, str(error))


class PHOTIC_OT_bake(bpy.types.Operator):
    """Bake the light of the scene into a volume"""
    bl_idname = "photic.bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    animation: bpy.props.BoolProperty(name="Animation", description="Every frame of the scene's range; those that did not "
                                                                    "change are kept", options={"SKIP_SAVE"})

    _timer = None
    _job = None

    @classmethod
    def poll(cls, _context):
        return job.current is None

    def _start(self, context):
        if not bpy.data.filepath and context.scene.photic.folder.startswith("//"):
            self.report({"WARNING"}, "The file was never saved: the volume is in a temporary folder, and goes with Blender")
        frames = (context.scene.frame_start, context.scene.frame_end) if self.animation else None
        self._job = job.current = job.Job(context, frames)

    def execute(self, context):
        """Blocks: for scripts and background mode, where no timer fires."""
        try:
            self._start(context)
            while not self._job.tick():
                if self._job.run:
                    self._job.run.wait(interval=BLOCKED_INTERVAL_SECONDS)
            return self._finish(context)
        except BakerError as error:
            show_error(self, context, error)
            return {"CANCELLED"}
        finally:
            self._end(context)

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self._start(context)
        except BakerError as error:
            self._end(context)
            show_error(self, context, error)
            return {"CANCELLED"}
        context.window_manager.progress_begin(0, 100)
        self._timer = context.window_manager.event_timer_add(TICK_SECONDS, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if job.current is not self._job:    # the add-on was disabled, or another file was opened
            self._end(context)
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            self._job.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            done = self._job.tick()
        except BakerError as error:
            self._end(context)
            show_error(self, context, error)
            return {"CANCELLED"}
        context.window_manager.progress_update(100 * self._job.fraction)
        redraw(context)
        if not done:
            return {"PASS_THROUGH"}
        try:
            return self._finish(context)
        finally:
            self._end(context)

    def _finish(self, context):
        settings = context.scene.photic
        if self._job.cancelled:
            settings.message = "The bake was cancelled"
            self.report({"WARNING"}, settings.message)
            return {"CANCELLED"}
        notes = [words for _, words in self._job.notes]
        for words in notes:
            self.report({"WARNING"}, words)
        settings.message = ""
        try:
            preview_state.load(context)
            if settings.preview_after_bake:
                skipped = preview_state.show(context)
                for words in skipped:
                    self.report({"WARNING"}, words)
        except BakerError as error:
            show_error(self, context, error)
            return {"CANCELLED"}
        kept_bakes.made(self._job.bake, self._job.before)
        kept = f", {self._job.kept} of them had not changed" if self._job.kept else ""
        self.report({"INFO"}, f"Baked {max(len(self._job.frames), 1)} frame{'s' if len(self._job.frames) > 1 else ''}{kept}")
        return {"FINISHED"}

    def _end(self, context):
        if self._job:
            self._job.end()
        if job.current is self._job:
            job.current = None
        if self._timer:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
        redraw(context)

    def cancel(self, context):
        """Blender closes."""
        if self._job:
            self._job.cancel()
        self._end(context)


class PHOTIC_OT_cancel(bpy.types.Operator):
    """End the bake; files that are there stay as they were"""
    bl_idname = "photic.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, _context):
        return job.current is not None

    def execute(self, _context):
        job.current.cancel()
        return {"FINISHED"}


class PHOTIC_OT_load(bpy.types.Operator):
    """Load the baked volume again, for instance after the file has moved"""
    bl_idname = "photic.load"
    bl_label = "Load"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            preview_state.load(context)
            if context.scene.photic.previewing:
                preview_state.show(context)
        except BakerError as error:
            show_error(self, context, error)
            return {"CANCELLED"}
        return {"FINISHED"}


class PHOTIC_OT_export(bpy.types.Operator):
    """Write the scene file and its meshes, for the command line"""
    bl_idname = "photic.export"
    bl_label = "Write scene file"

    def execute(self, context):
        settings = context.scene.photic
        try:
            folder = job.output_folder(settings) / f"{job.file_stem(context.scene)}_scene"
            folder.mkdir(exist_ok=True)
            collected = collect.collect(context.evaluated_depsgraph_get())
            text = write.scene_text(settings, collected, folder, method_options.methods())
            path = write.write(text, folder, job.file_stem(context.scene))
            samples.make_all(text)
        except BakerError as error:
            show_error(self, context, error)
            return {"CANCELLED"}
        for _, words in collected.notes:
            self.report({"INFO"}, words)
        self.report({"INFO"}, f"Wrote {path}")
        return {"FINISHED"}
