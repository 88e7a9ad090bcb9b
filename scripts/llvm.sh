#!/bin/sh
# See to a libLLVM that Dr.Jit can use: install libLLVM 19 through apt when there is none.
set -eu

if why=$(.venv/bin/python -m pelagos.cli.device 2>&1); then
    exit 0
fi
if ! command -v apt-get >/dev/null 2>&1; then
    echo "$why" >&2
    exit 1
fi

root=
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null 2>&1; then
        echo "libLLVM is missing, and there is no sudo to install it with. As root: apt-get install libllvm19" >&2
        exit 1
    fi
    root=sudo
fi
echo "installing libLLVM through apt"
newest=
for attempt in known updated; do
    [ $attempt = known ] || $root apt-get update -qq
    for version in 19 20 18 17 16; do
        if apt-cache show "libllvm$version" >/dev/null 2>&1; then newest=libllvm$version; break 2; fi
    done
done
if [ -z "$newest" ]; then
    echo "apt knows no libllvm of version 16 to 20. Install LLVM 16 or newer by other means, and set DRJIT_LIBLLVM_PATH to its libLLVM." >&2
    exit 1
fi
$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$newest"
.venv/bin/python -m pelagos.cli.device
