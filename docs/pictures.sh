#!/usr/bin/env bash
# Makes pictures of README.md and docs/ again: docs/pictures.sh [DIRECTORY [NAME...]]
# The directory is docs/ if none is given. The names are push balance crowd people_kinds scenes trains room guide physics measured flow turnstile barrier lab;
# all if none is given. Needs cargo build --release -p crowd-mechanics -p lemons-decision-fmu -p lemons-cli; physics needs
# cargo, too.
# scene_*.png need Python (PYTHON, else .venv, else python3); trains one with pandas.
# measured.png needs the measured push (../shared/data/push_wed), flow.png a Python with FMPy and Matplotlib (PYTHON, else
# .venv), turnstile.png and barrier.png one with Matplotlib and a C compiler, lab_*.png also Playwright there, Chromium, and the lab in the
# command (lab/build.sh). Each stays as it is without.
# All other pictures are made by a script in examples/: docs/development.md, "Pictures".
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
to=${1:-docs}
names=" ${*:2} "
lemons=${LEMONS:-$PWD/target/release/lemons}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

wanted() {
    [[ $names == "  " || $names == *" $1 "* ]]
}

if wanted push; then
    "$lemons" plot resources/Trial_push --step 0.001 --at 0.15,0.38,0.54,0.73 --columns 2 --fill squeeze -o "$to/push.png" --force
fi

if wanted balance; then
    cp -r resources/Trial_push "$scratch/legs"
    echo 'balance = "pendulum"' >"$scratch/legs/decision.toml"
    "$lemons" plot "$scratch/legs" --step 0.01 --at 0.2,0.6,1,2 --columns 2 --fill lean -o "$to/balance.png" --force
fi

if wanted crowd; then
    "$lemons" crowd --number 150 --box 4.56x4.56 --speed 0.5 -o "$scratch/Trial_box" >/dev/null
    "$lemons" plot "$scratch/Trial_box" --at 2 --fill squeeze --forces --width 600 -o "$to/crowd.png" --force
fi

if wanted people_kinds; then
    "$lemons" crowd --number 60 --box 10x8 --door 10,4,1.5 --seed 7 --png "$to/people_kinds.png" --force \
        --mix adult=40,child=15,elderly=10,with-child=8,stroller=5,wheelchair=5,walker=5,suitcase=6,backpack=6 >/dev/null
fi

python=${PYTHON:-$PWD/.venv/bin/python}
if wanted scenes; then
    # "$to/scene_concert.png" "$to/scene_platform.png" "$to/scene_stadium.png"
    LEMONS=$lemons "$(command -v "$python" || echo python3)" examples/scenes/scenes.py all "$scratch/scenes" --pictures "$to"
fi

if wanted trains; then
    LEMONS=$lemons "$(command -v "$python" || echo python3)" examples/trains.py "$scratch/trains" --seeds 1 --until 170 --picture "$to/scene_trains.png" >/dev/null
fi

if wanted room; then
    "$lemons" crowd --number 80 --box 8x6 --door 8,3,1 --leave -o "$scratch/room" >/dev/null
    "$lemons" measure "$scratch/room" --until left --line door=8,2.5,8,3.5 --window 5 --above 1000 --plot "$to/room.png" --force >/dev/null
fi

if wanted guide; then
    mkdir -p "$to/guide"
    "$lemons" plot resources/Trial_push --at 0.15,0.4,0.55,0.75 --columns 2 --fill squeeze -o "$to/guide/push.png" --force
    "$lemons" crowd --geometry examples/hall.xml --door 10,1.5,1.2 --number 60 --leave -o "$scratch/hall" >/dev/null
    "$lemons" plot "$scratch/hall" --at 0,5,10,20 --columns 2 --fill speed -o "$to/guide/hall.png" --force
    "$lemons" measure "$scratch/hall" --until left --line door=10,0.9,10,2.1 --window 2 --above 200 --over 1 --plot "$to/guide/flow.png" --force >/dev/null
fi

# guide/physics_collision.svg and _speed; the other drawings of that page are edited by hand.
if wanted physics; then
    mkdir -p "$to/guide"
    PICTURES=$(realpath "$to/guide") cargo test --quiet -p lemons-people --test physics charts >/dev/null
fi

push=../shared/data/push_wed
if wanted measured && [[ -d $push ]]; then
    # The recorded push is a force per unit of mass, on agent 0.
    mass=$(sed -n 's/.*<Agent [^>]*Id="0"[^>]*Mass="\([0-9.]*\)".*/\1/p' "$push/Trial/static/Agents.xml")
    awk -v mass="$mass" 'BEGIN { print "t,agent,Fp.x,Fp.y,Mp" } NR > 1 { printf "%s,0,%.9g,0,0\n", $1, mass * $2 }' \
        "$push/external_force_per_mass.txt" >"$scratch/push.csv"
    "$lemons" plot "$push/Trial" --drive "$scratch/push.csv" --step 0.01 --at 2.5,2.7,2.9,3.3 --columns 2 --fill '#8cb4de' \
        --measured "$push/measured_head_trajectories.csv" --measured-from start -o "$to/measured.png" --force
fi

if wanted flow && "$python" -c 'import fmpy, matplotlib' 2>/dev/null; then
    "$lemons" decide resources/Trial_door -o "$scratch/decision.fmu" >/dev/null
    "$lemons" pack resources/Trial_door -o "$scratch/crowd.fmu" >/dev/null
    "$python" examples/coupled_fmpy.py "$scratch/decision.fmu" "$scratch/crowd.fmu" "$to/flow.png" >/dev/null
fi

if wanted turnstile && "$python" -c 'import matplotlib' 2>/dev/null; then
    LEMONS=$lemons "$python" examples/turnstile.py "$scratch/turnstile" --seeds 1 --plot "$to/turnstile.png" >/dev/null
fi

if wanted barrier && "$python" -c 'import matplotlib' 2>/dev/null; then
    LEMONS=$lemons "$python" examples/barrier_gives_way.py "$scratch/barrier" --plot "$to/barrier.png" >/dev/null
fi

if wanted lab && "$python" -c 'import matplotlib, playwright' 2>/dev/null && command -v chromium >/dev/null; then
    LEMONS=$lemons "$python" docs/lab_pictures.py "$to"
fi
