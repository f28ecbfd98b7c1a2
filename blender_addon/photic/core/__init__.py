# SPDX-License-Identifier: GPL-3.0-or-later
"""What needs no Blender: the baker as a process, its JSON, scene files, meshes and the rules by which roles are found."""
