#!/usr/bin/env bash
# Counts the instructions of a person and mechanical step with valgrind's callgrind, and compares them with
# benches/instructions.csv: a row that needs 3 % more is an error, and so is one of 10 % fewer, whose table is old.
# `benches/instructions.sh write` writes the table; `benches/instructions.sh ROW...` counts only these.
#
# A count depends on compiler and processor (libc chooses its functions by it), not on load. Where the compiler is not that
# of the table, the rows are printed and compared with 10 %.
set -euo pipefail
# Numbers with a decimal point.
export LC_ALL=C
cd "$(dirname "${BASH_SOURCE[0]}")/.."
table=benches/instructions.csv
target=${CARGO_TARGET_DIR:-target}

command -v valgrind >/dev/null || {
    printf 'benches/instructions.sh: valgrind is missing (Debian: apt-get install valgrind)\n' >&2
    exit 1
}
cargo build --quiet --locked --release -p lemons-verify --features bench --example instructions
program=$target/release/examples/instructions

directory=$(mktemp -d)
trap 'rm -rf "$directory"' EXIT

# Prints the row with its instructions per person and step.
count() {
    local name=$1 people=$2 steps=$3 log=$directory/$1
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect='*counted_calls*' \
        "$program" "$name" >"$log" 2>&1 || {
        cat "$log" >&2
        return 1
    }
    awk -v name="$name" -v all=$((people * steps)) \
        '/Collected/ && $NF > 0 { printf "%s,%.1f\n", name, $NF / all; found = 1 } END { exit !found }' "$log" || {
        printf 'benches/instructions.sh: %s: nothing was counted\n' "$name" >&2
        return 1
    }
}
export -f count
export directory program

names=$("$program" | cut -d ' ' -f 1)
for name; do
    [[ $name == write ]] || grep -qx -- "$name" <<<"$names" || {
        printf 'benches/instructions.sh: no row %s; there are %s\n' "$name" "${names//$'\n'/ }" >&2
        exit 1
    }
done
wanted=" $* "
"$program" | while read -r name people steps; do
    if [[ $# == 0 || $1 == write || $wanted == *" $name "* ]]; then
        printf '%s %s %s\n' "$name" "$people" "$steps"
    fi
done | xargs -P "$(nproc)" -L 1 bash -c 'count "$@"' count >"$directory/counts"

compiler=$(rustc --version | cut -d ' ' -f 1-2)
if [[ ${1:-} == write ]]; then
    {
        printf 'row,instructions per person and mechanical step (%s)\n' "$compiler"
        "$program" | while read -r name _; do grep "^$name," "$directory/counts"; done
    } >"$directory/table"
    mv "$directory/table" "$table"
    cat "$table"
    exit
fi

most=3
grep -q "($compiler)" "$table" || {
    most=10
    printf 'Another compiler than that of %s (%s): at most %d %% more.\n' "$table" "$compiler" "$most"
}
awk -F , -v most="$most" -v all=$((!$#)) '
    NR == FNR { if (FNR > 1) before[$1] = $2; next }
    {
        seen[$1] = 1
        if (!($1 in before)) { printf "%-18s %8.1f  not in the table\n", $1, $2; failed = 1; next }
        change = 100 * ($2 / before[$1] - 1)
        said = change > most ? "  TOO MANY" : change < -10 ? "  FEWER: make the table again" : ""
        printf "%-18s %8.1f  %8.1f in the table  %+5.1f %%%s\n", $1, $2, before[$1], change, said
        if (said) failed = 1
    }
    END {
        if (all) for (row in before) if (!(row in seen)) { printf "%-18s is in the table and was not counted\n", row; failed = 1 }
        exit failed || NR == FNR
    }' "$table" <(sort "$directory/counts")
