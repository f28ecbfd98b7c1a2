# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material makes of light, and the role in a bake that follows from it."""
import dataclasses

MAJORITY = 0.5              # share of a material's closures that decides
SMOOTH_ROUGHNESS = 0.2      # rougher glass or metal makes no caustic worth baking
NOTED_ROUGHNESS = 0.02      # rougher than this is baked as if it were smooth, and said

REFRACTOR, MIRROR, RECEIVER, MOVABLE, BLOCKER, IGNORE = "REFRACTOR", "MIRROR", "RECEIVER", "MOVABLE", "BLOCKER", "IGNORE"


@dataclasses.dataclass
class Medium:
    """Per channel [1/m]; Henyey-Greenstein's g."""
    absorption: tuple = (0.0, 0.0, 0.0)
    scattering: tuple = (0.0, 0.0, 0.0)
    anisotropy: float = 0.0

    def present(self):
        return any(self.absorption) or any(self.scattering)

    def extinction(self):
        return tuple(a + s for a, s in zip(self.absorption, self.scattering))


@dataclasses.dataclass
class Optics:
    """Shares of one material, which sum to at most 1, and what is said about them."""
    refract: float = 0.0
    mirror: float = 0.0
    diffuse: float = 0.0
    ior: object = 1.45              # a number, or one each for red, green and blue
    colour: tuple = (1.0, 1.0, 1.0)     # share that a mirror reflects
    roughness: float = 0.0          # of the refracting or reflecting part
    medium: Medium = dataclasses.field(default_factory=Medium)
    notes: list = dataclasses.field(default_factory=list)


def too_rough(optics):
    """The roughness by which a material that would bend or mirror light does not, or 0."""
    bends = optics is not None and max(optics.refract, optics.mirror) >= MAJORITY
    return optics.roughness if bends and optics.roughness > SMOOTH_ROUGHNESS else 0.0


def role_of(optics, is_water=False):
    """The role found by itself. `is_water`: an Ocean modifier says so, whatever the material."""
    if is_water:
        return REFRACTOR
    if optics is None or optics.roughness > SMOOTH_ROUGHNESS:
        return RECEIVER
    if optics.refract >= MAJORITY:
        return REFRACTOR
    if optics.mirror >= MAJORITY:
        return MIRROR
    return RECEIVER
