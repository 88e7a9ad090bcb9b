#!/bin/sh
# Install packages through apt where one of some commands is lacking; for what tests compare with, and are skipped without.
# apt.sh PURPOSE COMMANDS PACKAGES: "tests of the view" "chromium|chromium-browser java" "chromium"; a|b is either.
set -eu

lacking=
for names in $2; do
    found=
    for name in $(echo "$names" | tr '|' ' '); do
        command -v "$name" >/dev/null 2>&1 && found=1
    done
    [ -n "$found" ] || lacking=1
done
[ -n "$lacking" ] || exit 0
if ! command -v apt-get >/dev/null 2>&1; then
    echo "no apt here: install $3 by other means, or leave the $1 out" >&2
    exit 0
fi
root=
[ "$(id -u)" -eq 0 ] || root=sudo
$root apt-get update -qq
# shellcheck disable=SC2086
$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $3
