# SPDX-License-Identifier: GPL-3.0-or-later
"""Goes through a scene once and says what each thing is to the bake: bends light, receives it, blocks it, or sends it."""
import dataclasses
import math

import numpy

from ..core import regular_grid, roles
from ..nodes import graph
from ..properties import graded as graded_settings
from . import graded, lights, materials, meshes

SHAPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
WATER_IOR = 1.333


@dataclasses.dataclass
class Item:
    """A mesh with its part in the bake. `object_name` is the object to blame; instances share it."""
    name: str
    object_name: str
    role: str
    mesh: meshes.Mesh
    optics: roles.Optics
    keep_mesh: bool = False         # the artist's wish, of water
    grid: object = None             # regular_grid.Grid: baked as a height field
    abbe: float = 0.0               # number of a glass; 0: it parts no colours
    graded: object = None           # core.graded.Graded of glass whose index varies
    matrix: object = None           # 4 x 4, world

    def is_graded(self):
        return self.role == roles.REFRACTOR and self.graded is not None

    def is_body(self):
        """Closed, with faces: light goes in and comes out again."""
        return self.role == roles.REFRACTOR and self.mesh.closed and (self.graded is None or self.graded.faces)

    def is_open(self):
        """A surface with a medium behind it, as water is."""
        return self.role == roles.REFRACTOR and not self.mesh.closed and self.graded is None

    def is_creased(self):
        """A glass or mirror that is smooth but for some of its edges, which its light shows."""
        return self.role in (roles.REFRACTOR, roles.MIRROR) and self.mesh.closed and self.mesh.creased

    def mean_ior(self):
        return float(numpy.mean(self.optics.ior))


@dataclasses.dataclass
class Collected:
    items: list = dataclasses.field(default_factory=list)
    lights: list = dataclasses.field(default_factory=list)      # (object's name, table)
    medium: roles.Medium = dataclasses.field(default_factory=roles.Medium)
    notes: list = dataclasses.field(default_factory=list)       # (object's name, words): nothing is lost in silence
    rough: list = dataclasses.field(default_factory=list)       # (object's name, words): would bend light, were it smoother
    forms: list = dataclasses.field(default_factory=list)       # (object's name, words): what each water is baked as, and why

    @property
    def forms_words(self):
        return "\n".join(words for _, words in self.forms)

    def of(self, *wanted):
        return [item for item in self.items if item.role in wanted]


def optics_of(obj):
    """Optics of an object's materials: of the slots, that which does most with light."""
    found = [materials.inspect(slot.material) for slot in obj.material_slots]
    found = [optics for optics in found if optics is not None]
    return max(found, key=lambda o: (roles.role_of(o) != roles.RECEIVER, o.refract + o.mirror), default=None)


def is_water(obj):
    return any(modifier.type == "OCEAN" for modifier in obj.modifiers)


def role_of(obj):
    """The chosen role, or that which was found; IGNORE for what takes no part."""
    if obj.type not in SHAPES or graph.is_ours(obj):
        return roles.IGNORE
    chosen = obj.photic.role
    return roles.role_of(optics_of(obj), is_water(obj)) if chosen == "AUTO" else chosen


def collect(depsgraph):
    """Reads what the depsgraph's frame shows and the render would too."""
    scene = Collected()
    original_scene = depsgraph.scene.original
    seen = {}
    for instance in depsgraph.object_instances:
        obj = instance.object.original
        if instance.object.type == "LIGHT":
            _take_light(instance, scene)
            continue
        if not instance.show_self or obj.hide_render or (instance.parent and instance.parent.original.hide_render):
            continue
        role = role_of(obj)
        if role == roles.IGNORE:
            continue
        mesh = meshes.evaluated(instance.object, instance.matrix_world.copy(), depsgraph)
        if mesh is None:
            continue
        seen[obj.name] = seen.get(obj.name, 0) + 1
        name = obj.name if seen[obj.name] == 1 else f"{obj.name} #{seen[obj.name]}"
        item = _item(name, obj, role, mesh, scene, first=seen[obj.name] == 1)
        item.matrix = instance.matrix_world.copy()
        scene.items.append(item)
    _note_hidden(original_scene, depsgraph, scene)
    _turn_to_light(scene)
    _choose_forms(scene)
    scene.medium = _medium(original_scene, scene)
    return scene


def _take_light(instance, scene):
    lamp = instance.object
    if lamp.original.hide_render:
        return
    notes = []
    if lights.is_baked(lamp.original):
        scene.lights.append((lamp.original.name, lights.table(lamp, notes)))
    else:
        notes.append(f"the {lamp.data.type.lower()} light '{lamp.original.name}' is not baked")
    scene.notes += [(lamp.original.name, note) for note in notes]


def _item(name, obj, role, mesh, scene, first):
    optics = optics_of(obj) or roles.Optics()
    if is_water(obj) and optics.refract == 0:
        optics.ior = WATER_IOR
    if obj.photic.ior > 0:
        optics.ior = obj.photic.ior
    if first and obj.photic.role == "AUTO" and role == roles.RECEIVER and roles.too_rough(optics):
        refracts = optics.refract >= roles.MAJORITY
        does = "lets light through" if refracts else "is metal"
        words = (f"'{obj.name}' {does}, but with Roughness {optics.roughness:.2g} it makes no caustics: set the Roughness of its "
                 f"material to 0 (up to {roles.SMOOTH_ROUGHNESS} is baked as if smooth)")
        scene.rough.insert(0 if refracts else len(scene.rough), (obj.name, words))
        if refracts:        # rough metal is common, and nobody expects caustics of it
            scene.notes.append((obj.name, words))
    if first:
        bends = role in (roles.REFRACTOR, roles.MIRROR)
        scene.notes += [(obj.name, f"the material of '{obj.name}': {note}") for note in optics.notes if bends]
        if bends and 0 < mesh.smooth_share < 1 and not (mesh.closed and mesh.creased):
            scene.notes.append((obj.name, f"'{obj.name}' is shaded partly smooth and partly flat; "
                                          f"{'smooth' if mesh.smooth_share >= 0.5 else 'flat'} is baked"))
        ocean = next((m for m in obj.modifiers if m.type == "OCEAN"), None)
        if ocean and ocean.viewport_resolution != ocean.resolution:
            scene.notes.append((obj.name, f"the ocean of '{obj.name}' is baked at the viewport's resolution, "
                                          f"{ocean.viewport_resolution}; it is rendered at {ocean.resolution}"))
    return Item(name, obj.name, role, mesh, optics, keep_mesh=obj.photic.surface == "MESH", abbe=obj.photic.abbe,
                graded=graded_settings.of(obj))


def _note_hidden(scene_original, depsgraph, scene):
    """What the render would show and the viewport doesn't."""
    shown = {item.object_name for item in scene.items}
    for obj in scene_original.objects:
        if obj.type in SHAPES and not obj.hide_render and obj.name not in shown and not obj.visible_get() \
                and role_of(obj) != roles.IGNORE:
            scene.notes.append((obj.name, f"'{obj.name}' is hidden in the viewport, and not baked; the render shows it"))


def _turn_to_light(scene):
    """An open refractor's outside is where the light comes from."""
    if not scene.lights:
        return
    first = scene.lights[0][1]
    for item in scene.of(roles.REFRACTOR):
        normal = item.mesh.mean_normal()
        low, high = item.mesh.bounds()
        travel = (low + high) / 2 - place_of(first) if place_of(first) is not None else numpy.array(first["direction"])
        if numpy.linalg.norm(normal) > 0.05 * item.mesh.area() and normal @ travel > 0:
            item.mesh = item.mesh.turned()
            scene.notes.append((item.object_name, f"the normals of '{item.name}' point away from the light; "
                                                  "it is baked the other way round"))


def _choose_forms(scene):
    """Water whose mesh is a regular grid is baked as a smooth height field: far quicker, and without facets."""
    bending = scene.of(roles.REFRACTOR, roles.MIRROR)
    for item in scene.of(roles.REFRACTOR):
        if item.is_graded():
            scene.forms.append((item.object_name, graded.words(item)))
            continue
        try:
            item.grid = _grid_of(item, bending, scene.lights)
            sideways = ", with its movement sideways" if item.grid.moves else ""
            words = f"'{item.name}' is baked as a height field of {item.grid.shape_words} points{sideways}"
        except regular_grid.NotRegular as reason:
            words = f"'{item.name}' is baked as a mesh: {reason}"
        scene.forms.append((item.object_name, words))


def place_of(table):
    """Where a [[light]] stands [m]; None of a sun."""
    place = table.get("position", table.get("center"))
    return None if place is None else numpy.array(place)


def _is_from_below(table, mesh):
    place = place_of(table)
    return table["direction"][2] >= 0 if place is None else place[2] <= mesh.bounds()[1][2]


def _grid_of(item, bending, lamps):
    """Raises NotRegular with the reason."""
    if item.keep_mesh:
        raise regular_grid.NotRegular("as you chose")
    if len(bending) > 1:
        raise regular_grid.NotRegular("it is not alone in bending light")
    if item.mesh.smooth_share < 0.5:
        raise regular_grid.NotRegular("it is shaded flat, and a height field is smooth")
    if item.mesh.mean_normal()[2] <= 0 or any(_is_from_below(table, item.mesh) for _, table in lamps):
        raise regular_grid.NotRegular("light comes to it from below")
    return regular_grid.find(item.mesh.positions, item.mesh.triangles)


def _medium(scene_original, scene):
    """One medium below the open surfaces: the scene's own, or that of their materials. A closed body has its own."""
    settings = scene_original.photic
    if settings.medium_from == "SCENE":
        return roles.Medium(tuple(settings.absorption), tuple(settings.scattering), settings.anisotropy)
    found = [(item.object_name, item.optics.medium) for item in scene.of(roles.REFRACTOR)
             if item.optics.medium.present() and item.is_open()]
    if not found:
        return roles.Medium()
    if any(medium != found[0][1] for _, medium in found):
        scene.notes.append((found[0][0], f"several media are in the scene, and that of '{found[0][0]}' is baked for all"))
    return found[0][1]


def still_level(scene):
    """Mean height [m] of the open water, below which receivers are in it; -inf without."""
    water = [item for item in scene.items if item.is_open()]
    if not water:
        return -math.inf
    return float(numpy.mean([item.mesh.positions[:, 2].mean() for item in water]))
