#!/bin/sh
# Makes MassSpring.fmu with PythonFMU and ValanisContact.fmu with stickslip in the folder given, with the system beside.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-.}
mkdir -p "$out"
"${PYTHON:-python3}" -m pythonfmu build -f "$here/mass_spring.py" -d "$out" --handle-state --no-external-tool
"${STICKSLIP:-stickslip}" fmu ValanisContact --out "$out"
cp "$here/system.ssd" "$out/system.ssd"
