#!/usr/bin/env bash
# Makes coupled.ssp, an SSP 1.0 archive of Decision and CrowdMechanics for thirty people who leave a room, and runs it.
#
#     examples/coupled.sh [DIRECTORY]      # default: the present one; LEMONS names another command than the built one
set -euo pipefail
if [[ $# -gt 1 || ${1:-} == -* ]]; then
    sed -n '2,/^[^#]/s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    [[ $# -eq 1 && ($1 == -h || $1 == --help) ]] && exit 0
    exit 2
fi
repository=$(realpath "$(dirname "${BASH_SOURCE[0]}")/..")
lemons=$(realpath "${LEMONS:-$repository/target/release/lemons}")
cd "${1:-.}"

"$lemons" decide "$repository/resources/Trial_door" -o decision.fmu
"$lemons" pack "$repository/resources/Trial_door" -o crowd.fmu
"$lemons" connect decision.fmu crowd.fmu -o coupled.ssp
"$lemons" run coupled.ssp --until 10 --algorithm gauss-seidel
