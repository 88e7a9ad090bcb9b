#!/bin/sh
# Run the tests of parts, bridges, the view and HoloOcean's interface with the lowest version of everything that pyproject.toml asks for.
# usage: lowest.sh FOLDER [PYTEST_ARGUMENT ...]
set -eu
folder=$1
shift
[ -x "$folder/bin/uv" ] || { python3 -m venv --clear "$folder" && "$folder/bin/pip" install --quiet --disable-pip-version-check uv; }
"$folder/bin/uv" pip install --quiet --python "$folder/bin/python" --resolution lowest-direct --only-binary :all: \
    --no-binary pelagos --editable '.[bathymetry,test]'
# Packages of today warn the old ones of what will go. The schema's text is that of the newest pydantic.
exec "$folder/bin/python" -m pytest -n 2 -m "not slow" -p no:cacheprovider -o filterwarnings=ignore::DeprecationWarning \
    --deselect tests/unit/test_cli_commands.py::test_committed_schema_is_that_of_the_program ${@:-tests/unit tests/compat}
