"""A copy of an FMU of FMI 2.0 with a million more variables: python million_variables.py FMU COPY"""

import sys
import zipfile

END = b"</ModelVariables>"
ROW = (
    '<ScalarVariable name="further.variable[{0}]" valueReference="{1}" causality="local" variability="continuous" '
    'description="one of a million"><Real unit="N"/></ScalarVariable>\n'
)

rows = "".join(ROW.format(number, 100_000 + number) for number in range(1_000_000)).encode()
with zipfile.ZipFile(sys.argv[1]) as fmu, zipfile.ZipFile(sys.argv[2], "w", zipfile.ZIP_DEFLATED) as copy:
    for entry in fmu.infolist():
        content = fmu.read(entry)
        if entry.filename == "modelDescription.xml":
            content = content.replace(END, rows + END)
        copy.writestr(entry, content)
