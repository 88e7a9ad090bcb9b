#!/bin/sh
# Install through apt what the tests of ROS 2's wire compare with: Fast DDS (a subscriber in C++ is built) and tshark. Those tests are
# skipped without them.
set -eu

lacking=
for name in tshark fastddsgen java g++; do
    command -v "$name" >/dev/null 2>&1 || lacking=1
done
[ -n "$lacking" ] || exit 0
if ! command -v apt-get >/dev/null 2>&1; then
    echo "no apt here: install Fast DDS, fastddsgen, a C++ compiler and tshark by other means, or leave their tests out" >&2
    exit 0
fi
root=
[ "$(id -u)" -eq 0 ] || root=sudo
$root apt-get update -qq
$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    tshark g++ libfastrtps-dev fastddsgen default-jre-headless
