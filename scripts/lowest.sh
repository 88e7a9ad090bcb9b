#!/bin/sh
# Build an environment with the lowest version of everything that pyproject.toml asks for.
# usage: lowest.sh FOLDER
set -eu
folder=$1
[ -x "$folder/bin/uv" ] || { python3 -m venv --clear "$folder" && "$folder/bin/pip" install --quiet --disable-pip-version-check uv; }
"$folder/bin/uv" pip install --quiet --python "$folder/bin/python" --resolution lowest-direct --only-binary :all: \
    --no-binary pelagos --editable '.[bathymetry,test]'
