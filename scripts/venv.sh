#!/bin/sh
# Build a virtual environment with Pelagos and everything that its tests and examples need.
# usage: venv.sh FOLDER        PYTHON=/path/to/python3 chooses the interpreter
set -eu
folder=$1

suits() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

if [ -n "${PYTHON:-}" ]; then
    suits "$PYTHON" || { echo "PYTHON=$PYTHON is not a Python 3.11 or newer." >&2; exit 1; }
    python=$PYTHON
else
    python=
    for name in python3 python3.14 python3.13 python3.12 python3.11; do
        if suits "$name"; then python=$name; break; fi
    done
fi
if [ -z "$python" ]; then
    echo "Pelagos needs Python 3.11 or newer, and none was found. On Debian or Ubuntu: apt-get install python3 python3-venv" >&2
    exit 1
fi

if ! "$python" -c 'import venv, ensurepip' 2>/dev/null; then
    echo "$python comes without venv. On Debian or Ubuntu: apt-get install python3-venv" >&2
    exit 1
fi

if [ ! -x "$folder/bin/python" ] || ! suits "$folder/bin/python"; then
    echo "building $folder with $("$python" --version)"
    "$python" -m venv --clear "$folder"
fi
echo "installing Pelagos and what it needs into $folder"
"$folder/bin/python" -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
