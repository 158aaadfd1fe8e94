#!/usr/bin/env bash
# Builds for another processor with Debian's cross compiler and runs the tests there, emulated by QEMU:
#   tests/package/other_processor.sh ARCHITECTURE FOLDER [options of ctest]
# ARCHITECTURE is Debian's name: arm64. FOLDER, an absolute path outside of the repository, gets a Debian 12
# of that architecture with all libraries, in it a clone of the last commit, and the build; a second run goes on there.
# Needs Debian 12, root, and a kernel with binfmt_misc. Emulation is about ten times slower than the processor here. Example:
#   tests/package/other_processor.sh arm64 /srv/arm64 -j 2 --timeout 6000
set -euo pipefail
source_folder=$(cd "$(dirname "$0")/../.." && pwd)
. "$source_folder/cmake/setup.sh"

[ $# -ge 2 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
architecture=$1 root=$2
shift 2
case $architecture in
  arm64) processor=aarch64 triple=aarch64-linux-gnu ;;
  *) say "other_processor.sh: unknown architecture '$architecture'; known: arm64"; exit 2 ;;
esac
case $root in
  /?*) ;;
  *) say "other_processor.sh: '$root' is no absolute path"; exit 2 ;;
esac
[ "$(id -u)" -eq 0 ] || { say "other_processor.sh: needs root, for chroot"; exit 2; }

install_packages debootstrap qemu-user-static "g++-${triple//_/-}" cmake ninja-build pkg-config git ccache
binfmt=/proc/sys/fs/binfmt_misc
[ -e $binfmt/register ] || mount -t binfmt_misc none $binfmt
[ -e "$binfmt/qemu-$processor" ] || cat "/usr/lib/binfmt.d/qemu-$processor.conf" > $binfmt/register

if [ ! -e "$root/.installed" ]; then
  [ -e "$root/etc/debian_version" ] ||
    debootstrap --arch="$architecture" --variant=minbase --include=ca-certificates,git bookworm "$root" >&2
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  chroot "$root" apt-get update -qq
  chroot "$root" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    $REQUIRED_PACKAGES libboost-dev libgtest-dev binutils python3 python3-jsonschema $ADAPTER_PACKAGES >&2
  # Absolute links lead out of the folder when the compiler here follows them.
  find "$root/usr/lib" "$root/etc/alternatives" -type l -lname '/*' | while read -r link; do
    ln -sfnr "$root$(readlink "$link")" "$link"
  done
  touch "$root/.installed"
fi
for system in proc dev sys; do mountpoint -q "$root/$system" || mount --bind "/$system" "$root/$system"; done
trap 'umount "$root/proc" "$root/dev" "$root/sys"' EXIT
# The build folder has absolute paths: inside, the folder's own path leads to the root.
mkdir -p "$root$(dirname "$root")"
ln -sfn / "$root$root"

cat > "$root/toolchain.cmake" <<EOF
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR $processor)
set(CMAKE_SYSROOT $root)
set(CMAKE_CXX_COMPILER $triple-g++)
set(CMAKE_LIBRARY_ARCHITECTURE $triple)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} $root)
set(ENV{PKG_CONFIG_LIBDIR} $root/usr/lib/$triple/pkgconfig:$root/usr/lib/pkgconfig:$root/usr/share/pkgconfig)
EOF
checkout=$root/root/lcpbench
if [ -d "$checkout" ]; then git -C "$checkout" pull -q; else git clone -q "$source_folder" "$checkout"; fi
cmake -S "$checkout" -B "$checkout/build/release" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_TOOLCHAIN_FILE="$root/toolchain.cmake" -DPython3_EXECUTABLE=/usr/bin/python3 >&2
cmake --build "$checkout/build/release" >&2

# What QEMU 7.2's emulation of processes cannot show, however right the program is:
not_emulated=(
  # prctl(PR_SET_CHILD_SUBREAPER) fails
  WorkerTest.ChildrenOfAWorkerEndWithIt WorkerTest.KillOfTheProgramEndsIdleAndBusyWorkers
  # setrlimit(RLIMIT_AS) limits nothing
  WorkerTest.MemoryIsLimited AdapterFaultsTest.EveryOtherRowIsUntouched
  # posix_spawn of a file that is not there succeeds
  WorkerTest.FailureToStartIsReported RunnerTest.WhatAUserCanMendEndsTheRunAndSaysHowToGoOn
  # against a clock: 113-bit arithmetic; kills at times by which a worker has to be up
  ContactLemkeTest.SolvesLargeIllConditionedProblemsInTime KillTest.KillsLoseNothing
)
say "Left out, since the emulator cannot show them: ${not_emulated[*]}"
GTEST_FILTER="-$(IFS=:; echo "${not_emulated[*]}")" chroot "$root" ctest --test-dir "$checkout/build/release" --output-on-failure "$@"
