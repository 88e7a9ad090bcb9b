#!/bin/sh
# Install Chromium through apt for the tests of the view, where there is none. Those tests are skipped without it.
set -eu

for name in chromium chromium-browser google-chrome; do
    if command -v "$name" >/dev/null 2>&1; then exit 0; fi
done
if ! command -v apt-get >/dev/null 2>&1; then
    echo "no apt here: install Chromium by other means, or leave the tests of the view out" >&2
    exit 0
fi
root=
[ "$(id -u)" -eq 0 ] || root=sudo
$root apt-get update -qq
$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium
