#!/bin/sh
# Double-click it on macOS or Linux: installs what is missing, and opens the study in the folder `study`.
python3 "$(dirname "$0")/run.py" app "${1:-$(dirname "$0")/study}"
