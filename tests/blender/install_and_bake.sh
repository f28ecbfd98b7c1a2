#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tests/blender/install_and_bake.sh ZIP: installs the add-on with its baker as an artist would, in a home of its own, and
# bakes a pool in another run of Blender: no path to a baker is set, and none is on the search path.
set -euo pipefail
zip=$(realpath "$1")
here=$(dirname -- "$(realpath "${BASH_SOURCE[0]}")")
home=$(mktemp -d)
trap 'rm -rf "$home"' EXIT
export HOME=$home XDG_CONFIG_HOME=$home/.config PHOTIC_TEST_OUT=$home/out
unset PHOTIC_PROGRAM
if command -v photic >/dev/null; then
    echo "install_and_bake: there is a photic on the search path; this is about the one in the zip" >&2
    exit 2
fi
version=$(blender --version | sed -n 's/^Blender \([0-9.]*\).*/\1/p')
if [[ "$(printf '%s\n' 4.2 "$version" | sort -V | head -1)" == 4.2 ]]; then     # extensions came with it
    blender --command extension install-file --repo user_default --enable "$zip"
else
    blender -b --python-exit-code 1 --python-expr "
import bpy
bpy.ops.preferences.addon_install(filepath='$zip')
bpy.ops.preferences.addon_enable(module='photic')
bpy.ops.wm.save_userpref()"
fi
blender -b --python-exit-code 1 -P "$here/bake_by_itself.py"
