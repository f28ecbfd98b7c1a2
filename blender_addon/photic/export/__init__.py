# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a Blender scene, and writes what the baker reads; what cannot be written is said."""
