#!/bin/sh
# Makes MassSpring.fmu and TwoDirections.fmu with PythonFMU, ValanisContact.fmu and SlipSlapContact.fmu with stickslip in the
# folder given, with the systems beside.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-.}
mkdir -p "$out"
for structure in mass_spring two_directions; do
    "${PYTHON:-python3}" -m pythonfmu build -f "$here/$structure.py" -d "$out" --handle-state --no-external-tool
done
"${STICKSLIP:-stickslip}" fmu ValanisContact SlipSlapContact --out "$out"
cp "$here/system.ssd" "$here/two_directions.ssd" "$out/"
