#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tests/packages/install_and_remove.sh FOLDER: in a root in which nothing was ever installed, as `scripts/test_on SUITE
# packages` makes one: runs the tarball of FOLDER where it is unpacked, installs its .deb files by apt, one after the
# other, uses each, removes them, and fails when anything of theirs stays.
set -euo pipefail
made=$(realpath "$1")
here=$(dirname -- "$(realpath "${BASH_SOURCE[0]}")")
export DEBIAN_FRONTEND=noninteractive DEBCONF_NOWARNINGS=yes LC_ALL=C.UTF-8
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

say() { printf '== %s\n' "$1"; }
fail() { echo "install_and_remove: $*" >&2; exit 1; }
get() { apt-get install -qq -y --no-install-recommends "$@" >/dev/null; }
# All that is in this root but what programs keep of their own runs.
everything() {
    find / -xdev \( -path /proc -o -path /dev -o -path /sys -o -path /tmp -o -path /photic -o -path /made -o -path /root \
        -o -path /var/cache -o -path /var/log -o -path /var/lib/apt -o -path /var/lib/dpkg \) -prune -o -print | sort
}
bake_and_inspect() {   # PROGRAM SCENE
    "$1" bake "$2" -o "$work/pool.vdb" --voxel-size 0.0625 -q
    "$1" inspect "$work/pool.vdb" --strict | head -3
    "$1" export "$work/pool.vdb" --scene "$2" --web "$work/page" -q
    test -s "$work/page/index.html"
}

command -v photic >/dev/null && fail "photic is here already; this is about a fresh root"

say "the tarball, with nothing installed"
mkdir "$work/anywhere"
tar -xzf "$made"/photic-*.tar.gz -C "$work/anywhere"
unpacked=$(echo "$work"/anywhere/*)
"$unpacked/bin/photic" --version
bake_and_inspect "$unpacked/bin/photic" "$unpacked/share/doc/photic/examples/pool/pool.toml"
du -sm "$unpacked" | awk '{ print $1 " MB unpacked" }'

apt-get update -qq
# What the checks need is there before what is checked, so that it does not count as left behind.
get man-db bash-completion python3 cmake ninja-build g++ libglfw3-dev libepoxy-dev
everything >"$work/before"
dpkg-query -W -f '${Package}\n' | sort >"$work/packages_before"

say "photic"
get "$made"/photic_*.deb
photic --version
cp -r "$unpacked/share/doc/photic/examples/pool" "$work/pool"
bake_and_inspect photic "$work/pool/pool.toml"
man photic | cat | sed -n 1,4p
bash -c '. /usr/share/bash-completion/bash_completion; . /usr/share/bash-completion/completions/photic
    COMP_WORDS=(photic ba) COMP_CWORD=1; _photic; echo "photic ba<TAB>: ${COMPREPLY[*]}"; [[ "${COMPREPLY[*]}" == bake* ]]'
test -s /usr/share/zsh/site-functions/_photic -a -s /usr/share/fish/vendor_completions.d/photic.fish
test -s /usr/share/doc/photic/copyright

say "photic-doc"
get "$made"/photic-doc_*.deb
python3 "$here/../consume/check_links.py" /usr/share/doc/photic

say "libphotic-runtime-dev: a game, without OpenVDB's headers"
get "$made"/libphotic-runtime-dev_*.deb
[[ ! -e /usr/include/openvdb ]] || fail "the run-time library brought OpenVDB's headers"
cmake -S /usr/share/doc/photic/examples/game -B "$work/game" -G Ninja -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$work/game" >/dev/null
test -x "$work/game/game"

say "libphotic-dev: a program that bakes"
get "$made"/libphotic-dev_*.deb
cmake -S /usr/share/doc/photic/tests/consume/stranger -B "$work/stranger" -G Ninja -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$work/stranger" >/dev/null
(cd "$work" && stranger/stranger)

say "all of it removed"
mapfile -t own < <(dpkg-query -W -f '${Package}\n' | grep photic)
dpkg -L "${own[@]}" | sort -u >"$work/own_files"
apt-get purge -qq -y "${own[@]}" >/dev/null
dpkg-query -W -f '${Package}\n' | grep photic && fail "these stay"
apt-get purge -qq -y --autoremove >/dev/null
dpkg-query -W -f '${Package}\n' | sort | diff "$work/packages_before" - || fail "packages stay that came along"
everything | comm -13 "$work/before" - >"$work/left"
# Nothing of Photic's stays; what its dependencies leave behind is shown, and is theirs.
grep -Fxf "$work/own_files" "$work/left" && fail "these files stay"
grep -i photic "$work/left" && fail "these files stay"
cat "$work/left"
say "the packages install, work and are gone again"
