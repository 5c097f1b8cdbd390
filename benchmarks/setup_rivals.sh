#!/usr/bin/env bash
# Make the separate environment of the codes that the benchmark compares with:
#     bash benchmarks/setup_rivals.sh [FOLDER] [PYTHON]
# FOLDER is benchmarks/.rivals by default, which git ignores. Tamaas (AGPL), ContactMechanics, reynoldsflow are wheels,
# ASPHER is compiled. None of them is ever imported by this project.
set -euo pipefail
folder=${1:-"$(cd "$(dirname "$0")" && pwd)/.rivals"}
python=${2:-python3}

missing=()
command -v c++ >/dev/null || missing+=(g++)
command -v cmake >/dev/null || missing+=(cmake)
[ -f /usr/include/eigen3/Eigen/Core ] || [ -n "${Eigen3_DIR:-}" ] || missing+=(libeigen3-dev)
if [ ${#missing[@]} -gt 0 ]; then
    echo "ASPHER is compiled on installation and lacks: ${missing[*]}" >&2
    echo "On Debian or Ubuntu: apt-get install ${missing[*]}" >&2
    echo "Eigen in another place: set Eigen3_DIR to the folder of Eigen3Config.cmake" >&2
    exit 1
fi

"$python" -m venv "$folder"
"$folder/bin/pip" install --quiet --disable-pip-version-check "numpy>=2" scipy \
    ContactMechanics==1.8.3 tamaas==2.9.0 aspher==0.1.3.post1 reynoldsflow==0.1.3
"$folder/bin/python" -c 'import aspher, ContactMechanics, reynoldsflow, tamaas' && echo "ready: $folder/bin/python"
