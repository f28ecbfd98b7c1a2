# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sample group: looks flux up in a slice atlas at the shaded point, trilinearly, in both engines.

Eight taps without the engines' own filter: a filtered look-up bleeds into the neighbouring slice, and EEVEE takes the wrong
level of detail where the slice changes.
"""
import itertools

import bpy

from .. import compat
from . import build, graph, groups

INSIDE = 0.25       # half a texel would be exact; less absorbs rounding on whole numbers


def build_group(volume_object, atlas, late=(0.0, 0.0, 0.0), frames=None):
    """(Re)builds the group of a volume. `frames` is (first frame, count) of a sequence; `late` [m] is where the light's own
    (0, 0, 0) is in the object's frame.

    Outputs, in the light's frame: Flux [W/m2] by the mean of the channels, Colour (flux's channels over their mean), both for the
    second lobe too where there is one (Flux 2, Colour 2: light that opposes the rest), and Position [m].
    """
    lobes = _lobes(volume_object, atlas, frames)
    sockets = [socket for suffix, _ in lobes
               for socket in (("NodeSocketVector", "Flux" + suffix, None), ("NodeSocketColor", "Colour" + suffix, None))]
    tree = groups.fresh(groups.named("Sample", volume_object), [], [*sockets, ("NodeSocketVector", "Position", None)])
    b = build.Builder(tree)
    in_object = b.node("ShaderNodeTexCoord", "Position in the volume", object=volume_object).outputs["Object"]
    place = b.vector("SUBTRACT", in_object, late)
    voxel = b.vector("DIVIDE", b.vector("SUBTRACT", place, atlas.origin), atlas.voxel_size)
    below = b.vector("FLOOR", voxel)
    share = b.split(b.vector("SUBTRACT", voxel, below))
    sizes = (atlas.slice_width, atlas.slice_height, atlas.slices)
    axes = [_taps_along(b, index, part, size) for index, part, size in zip(b.split(below), share, sizes)]

    corners = []
    for i, j, k in itertools.product((0, 1), repeat=3):
        weight = b.math("MULTIPLY", b.math("MULTIPLY", axes[0][i][1], axes[1][j][1]), axes[2][k][1])
        corners.append((_texel(b, atlas, axes[0][i][0], axes[1][j][0], axes[2][k][0]), weight))
    out = b.node("NodeGroupOutput")
    scale = b.value("Scale", atlas.scale)
    for suffix, images in lobes:
        flux, colour = _looked_up(b, images, corners, frames)
        b.plug(b.vector("SCALE", flux, scale=scale), out.inputs["Flux" + suffix])
        b.plug(colour, out.inputs["Colour" + suffix])
    b.plug(place, out.inputs["Position"])
    return tree


def _lobes(volume_object, atlas, frames):
    """(suffix of the outputs' names, images) of each lobe."""
    lobes = []
    for suffix, image, rgb_image in (("", atlas.image, atlas.rgb_image), (" 2", atlas.image_2, atlas.rgb_image_2)):
        if not image:
            continue
        images = [_image(groups.named("Atlas" + suffix, volume_object), image, frames)]
        if rgb_image:
            images.append(_image(groups.named("Colours" + suffix, volume_object), rgb_image, frames))
        lobes.append((suffix, images))
    return lobes


def _looked_up(b, images, corners, frames):
    """Flux over the reference, and the channels over their mean, mixed from the eight voxels around."""
    flux, mean, colour = None, None, None
    for texel, weight in corners:
        taps = [_tap(b, image, texel, frames) for image in images]
        flux = _add(b, flux, taps[0].outputs["Color"], weight)
        if len(taps) > 1:
            colour = _add(b, colour, taps[1].outputs["Color"], weight)
            product = b.math("MULTIPLY", taps[0].outputs["Alpha"], weight)
            mean = b.math("ADD", mean, product) if mean else product
    if not colour:
        return flux, (1.0, 1.0, 1.0, 1.0)
    least = b.math("MAXIMUM", mean, 1e-6)     # E_c = rgb_c / mean * max(0, -n . flux)
    return flux, b.vector("DIVIDE", colour, b.join(least, least, least))


def _taps_along(b, index, part, size):
    """Both voxels along an axis: (index kept inside, weight; 0 outside the atlas, where it is dark)."""
    after = b.math("ADD", index, 1.0)
    before_share = b.math("SUBTRACT", 1.0, part)
    taps = []
    for place, weight in ((index, before_share), (after, part)):
        inside = b.between(place, -INSIDE, size - 1 + INSIDE)
        kept = b.math("MINIMUM", b.math("MAXIMUM", place, 0.0), size - 1.0)
        taps.append((kept, b.math("MULTIPLY", weight, inside)))
    return taps


def _texel(b, atlas, i, j, k):
    """Image coordinates of a voxel's texel centre: u from the left, v from the bottom; row 0 is at the top."""
    row = b.math("FLOOR", b.math("DIVIDE", b.math("ADD", k, 0.5), float(atlas.columns)))
    column = b.math("MULTIPLY_ADD", row, -float(atlas.columns), k)
    x = b.math("ADD", b.math("MULTIPLY_ADD", column, float(atlas.slice_width), i), 0.5)
    y = b.math("ADD", b.math("MULTIPLY_ADD", row, float(atlas.slice_height), j), 0.5)
    u = b.math("DIVIDE", x, float(atlas.width))
    v = b.math("SUBTRACT", 1.0, b.math("DIVIDE", y, float(atlas.height)))
    return b.join(u, v, 0.0)


def _tap(b, image, texel, frames):
    node = b.node("ShaderNodeTexImage", image=image, interpolation="Closest", extension="CLIP")
    if frames:
        user = node.image_user
        user.frame_start, user.frame_duration = frames[0], frames[1]
        user.frame_offset = frames[0] - 1
        user.use_auto_refresh = True
    b.plug(texel, node.inputs["Vector"])
    return node


def _add(b, total, colour, weight):
    scaled = b.vector("SCALE", colour, scale=weight)
    return b.vector("ADD", total, scaled) if total else scaled


def _image(name, path, frames):
    """The data block of an atlas, the same one for each bake of a volume; never treated as a colour."""
    image = bpy.data.images.get(name)
    if image is None or not graph.is_ours(image):
        image = bpy.data.images.load(path)
        image.name = name
        compat.mark(image)
    elif bpy.path.abspath(image.filepath) != bpy.path.abspath(path):
        image.filepath = path
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    image.use_half_precision = True
    image.source = "SEQUENCE" if frames else "FILE"
    image.reload()
    return image
