# SPDX-License-Identifier: GPL-3.0-or-later
"""What a node material makes of light: its closures, their shares, its refractive index and its medium."""
import dataclasses

from .. import compat
from ..core import roles
from ..nodes import graph

MAX_DEPTH = 64      # of nested shaders; deeper trees are loops
BUMPS = ("ShaderNodeBump", "ShaderNodeNormalMap", "ShaderNodeTexImage", "ShaderNodeTexNoise", "ShaderNodeTexWave",
         "ShaderNodeTexMusgrave", "ShaderNodeTexVoronoi")
WHITE = 0.95        # a smallest channel from which on nothing is said about a colour


@dataclasses.dataclass
class _Part:
    """A closure with its share of a material."""
    share: float
    kind: str                           # of roles.Optics' shares
    roughness: float = 1.0
    ior: float = 1.0
    colour: tuple = (1.0, 1.0, 1.0)
    node: str = ""
    colour_name: str = ""


def inspect(material):
    """Optics of a material; None for no material or one without nodes, which is plain white to every renderer."""
    tree = compat.shader_tree(material) if material is not None else None
    if tree is None:
        return None
    optics = roles.Optics()
    output = graph.active_output(tree)
    if output is None:
        return optics
    if graph.source(output.inputs["Displacement"]):
        optics.notes.append("has a Displacement, which is not baked: light is bent by the mesh alone. Move the mesh itself, by a "
                            "Displace or an Ocean modifier")
    parts = []
    _closures(graph.source(output.inputs["Surface"]), 1.0, parts, optics.notes, 0)
    _sum_up(parts, optics)
    optics.medium = _medium(graph.source(output.inputs["Volume"]), 1.0, optics.notes, 0)
    return optics


def _sum_up(parts, optics):
    by_channel = _dispersion(parts)
    for part in parts:
        setattr(optics, part.kind, getattr(optics, part.kind) + part.share)
    bending = [part for part in parts if part.kind == "refract"]
    smooth = bending or [part for part in parts if part.kind == "mirror"]
    if smooth:
        strongest = max(smooth, key=lambda part: part.share)
        optics.roughness = strongest.roughness
        optics.colour = strongest.colour if strongest.kind == "mirror" else optics.colour
    if by_channel:
        optics.ior = by_channel
        optics.refract, optics.mirror, optics.diffuse = min(1.0, optics.refract), 0.0, 0.0
    elif bending:
        optics.ior = max(bending, key=lambda part: part.share).ior
        _warn_of_tints(bending, optics.notes)
        if len({round(part.ior, 4) for part in bending}) > 1:
            optics.notes.append(f"mixes several refractive indices; {optics.ior:.4g} is baked")
    if bending:
        # Fresnel's share of a glass is its own: the baker computes it.
        optics.refract += optics.mirror
        optics.mirror = 0.0
    if smooth and roles.NOTED_ROUGHNESS < optics.roughness <= roles.SMOOTH_ROUGHNESS:
        optics.notes.append(f"has roughness {optics.roughness:.2g}, and is baked as if it were smooth")


def _dispersion(parts):
    """Three glasses of red, green and blue that are added, each with an index of its own: how artists part colours by hand.

    The indices of the three channels, or None.
    """
    bending = [part for part in parts if part.kind == "refract"]
    if len(bending) != 3 or len({round(part.ior, 6) for part in bending}) == 1:
        return None
    channels = [int(max(range(3), key=lambda c: part.colour[c])) for part in bending]
    pure = all(sum(part.colour) - part.colour[c] < 0.05 * part.colour[c] for part, c in zip(bending, channels))
    if not pure or sorted(channels) != [0, 1, 2]:
        return None
    return tuple(bending[channels.index(c)].ior for c in range(3))


def _number(node, notes, name, otherwise=0.0):
    """A socket's number; when something is linked to it, its default, which is said."""
    socket = compat.socket(node.inputs, name)
    if socket is None:
        return otherwise
    if graph.source(socket):
        constant = graph.constant(socket)
        if constant is not None:
            return constant
        notes.append(f"'{node.name}' has a textured {socket.name}; {socket.default_value:.3g} is baked")
    return float(socket.default_value)


def _colour(node, notes, name, otherwise=(1.0, 1.0, 1.0)):
    socket = compat.socket(node.inputs, name)
    if socket is None:
        return otherwise
    if graph.source(socket):
        notes.append(f"'{node.name}' has a textured {socket.name}, which is baked as its plain colour")
    return tuple(socket.default_value)[:3]


def _warn_of_tints(bending, notes):
    for part in bending:
        if min(part.colour) >= WHITE:
            continue
        level = " ".join(f"{c:.2g}" for c in part.colour)
        words = "is tinted" if max(part.colour) - min(part.colour) > 1e-3 else "is grey"
        notes.append(f"'{part.node}' {words}: its {part.colour_name} is {level}, and the light in the bake keeps its own colour; "
                     f"set {part.colour_name} to white, and for coloured water or glass give it a Volume Absorption")


def _warn_bump(node, notes):
    """Of a closure that bends light, or a group with one: normals that are not the mesh's."""
    found = graph.upstream(graph.source(node.inputs.get("Normal")), BUMPS)
    if found is not None:
        notes.append(f"'{node.name}' has a {found.bl_label}, which is not baked: light is bent by the mesh alone. Move the mesh "
                     "itself, by a Displace or an Ocean modifier")


def _closures(origin, share, parts, notes, depth):
    """Adds the closures behind an output socket to `parts`."""
    if origin is None or share <= 0 or depth > MAX_DEPTH:
        return
    node = origin.node
    kind = node.bl_idname
    if graph.is_ours(node):
        _closures(graph.source(node.inputs.get("Shader")), share, parts, notes, depth + 1)
    elif kind == "ShaderNodeMixShader":
        factor = _number(node, notes, "Factor") if not _is_fresnel(node.inputs[0]) else 0.0
        _closures(graph.source(node.inputs[1]), share * (1 - factor), parts, notes, depth + 1)
        if _is_fresnel(node.inputs[0]):     # glass by hand: refraction below, its reflection above
            factor = 0.1
        _closures(graph.source(node.inputs[2]), share * factor, parts, notes, depth + 1)
    elif kind == "ShaderNodeAddShader":
        for socket in node.inputs:
            _closures(graph.source(socket), share, parts, notes, depth + 1)
    elif kind == "ShaderNodeGroup" and node.node_tree:
        _warn_bump(node, notes)
        inner = graph.group_source(node, origin)
        _closures(inner, share, parts, notes, depth + 1)
    elif kind == "ShaderNodeBsdfPrincipled":
        _principled(node, share, parts, notes)
    elif kind in ("ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction"):
        _warn_bump(node, notes)
        parts.append(_Part(share, "refract", _number(node, notes, "Roughness"), _number(node, notes, "IOR", otherwise=1.45),
                           _colour(node, [], "Color"), node.name, "Color"))
    elif kind in ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfMetallic"):
        _warn_bump(node, notes)
        colour = _colour(node, notes, "Base Color" if kind == "ShaderNodeBsdfMetallic" else "Color")
        parts.append(_Part(share, "mirror", _roughness_of_glossy(node, notes), colour=colour))
    elif kind in ("ShaderNodeBsdfDiffuse", "ShaderNodeSubsurfaceScattering", "ShaderNodeBsdfTranslucent",
                  "ShaderNodeBsdfVelvet", "ShaderNodeBsdfSheen", "ShaderNodeBsdfToon"):
        parts.append(_Part(share, "diffuse"))
    elif kind not in ("ShaderNodeEmission", "ShaderNodeBsdfTransparent", "ShaderNodeHoldout", "ShaderNodeBackground"):
        notes.append(f"'{node.name}' ({node.bl_label}) is not understood, and counts as diffuse")
        parts.append(_Part(share, "diffuse"))


def _roughness_of_glossy(node, notes):
    sharp = getattr(node, "distribution", "") == "SHARP"
    return 0.0 if sharp else _number(node, notes, "Roughness")


def _is_fresnel(socket):
    origin = graph.source(socket)
    return origin is not None and origin.node.bl_idname in ("ShaderNodeFresnel", "ShaderNodeLayerWeight")


def _principled(node, share, parts, notes):
    metallic = _number(node, notes, "Metallic")
    transmission = _number(node, notes, "Transmission") * (1 - metallic)
    roughness = _number(node, notes, "Roughness")
    if transmission > 0 or metallic > 0:
        _warn_bump(node, notes)
    if transmission > 0:
        parts.append(_Part(share * transmission, "refract", roughness, _number(node, notes, "IOR", otherwise=1.45),
                           _colour(node, [], "Base Color"), node.name, "Base Color"))
    if metallic > 0:
        parts.append(_Part(share * metallic, "mirror", roughness, colour=_colour(node, notes, "Base Color")))
    parts.append(_Part(share * (1 - transmission) * (1 - metallic), "diffuse"))


def _medium(origin, share, notes, depth):
    """Absorption and scattering [1/m] behind a Volume socket."""
    medium = roles.Medium()
    if origin is None or depth > MAX_DEPTH:
        return medium
    node = origin.node
    kind = node.bl_idname
    if kind == "ShaderNodeAddShader":
        first, second = (_medium(graph.source(socket), share, notes, depth + 1) for socket in node.inputs)
        return _together(first, second)
    if kind == "ShaderNodeMixShader":
        factor = _number(node, notes, "Factor")
        return _together(_medium(graph.source(node.inputs[1]), share * (1 - factor), notes, depth + 1),
                         _medium(graph.source(node.inputs[2]), share * factor, notes, depth + 1))
    if kind == "ShaderNodeGroup" and node.node_tree:
        return _medium(graph.group_source(node, origin), share, notes, depth + 1)
    if kind not in ("ShaderNodeVolumeAbsorption", "ShaderNodeVolumeScatter", "ShaderNodeVolumePrincipled"):
        if kind != "ShaderNodeEmission":
            notes.append(f"the volume node '{node.name}' ({node.bl_label}) is not understood, and not baked")
        return medium
    density = share * _number(node, notes, "Density")
    colour = _colour(node, notes, "Color")
    inverse = tuple(density * (1 - c) for c in colour)
    if kind == "ShaderNodeVolumeAbsorption":
        medium.absorption = inverse
        return medium
    medium.scattering = tuple(density * c for c in colour)
    medium.anisotropy = _number(node, notes, "Anisotropy")
    if kind == "ShaderNodeVolumePrincipled":
        # Cycles: absorption is density (1 - colour) (1 - sqrt(absorption colour)).
        tint = _colour(node, notes, "Absorption Color", otherwise=(0.0, 0.0, 0.0))
        medium.absorption = tuple(a * (1 - max(t, 0.0) ** 0.5) for a, t in zip(inverse, tint))
    return medium


def _together(first, second):
    """Both media in one place; g is weighted by scattering."""
    weights = [sum(m.scattering) for m in (first, second)]
    total = sum(weights)
    g = sum(w * m.anisotropy for w, m in zip(weights, (first, second))) / total if total else 0.0
    return roles.Medium(tuple(a + b for a, b in zip(first.absorption, second.absorption)),
                        tuple(a + b for a, b in zip(first.scattering, second.scattering)), g)
