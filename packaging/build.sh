#!/usr/bin/env bash
# Builds the libraries, and the command and the extension of the Python package where there are such, of platforms (all without arguments) into dist/PLATFORM/.
# `build.sh linux64 win64` builds these only; the tools that it needs are named in lib.sh.
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

need_time
# Commands hold the page; for a Mac there is none.
programs=$(for platform; do program "$platform"; done)
choose_compiler "${all[@]}" ${programs:+"$page"}
tools
[[ -z $programs ]] || env -u LEMONS_PROFILE lab/build.sh
for platform; do
    packages=(-p crowd-mechanics -p lemons-decision-fmu -p lemons-summary-fmu)
    program=$(program "$platform")
    [[ -z $program ]] || packages+=(-p lemons-cli -p lemons-python --features lemons-cli/parquet,lemons-cli/sqlite)
    read -ra of_platform <<<"$(targets "$platform")"
    for target in "${of_platform[@]}"; do
        note "$platform: $target, with $("$RUSTC" --version)"
        compile "$target" "${packages[@]}"
    done
    rm -rf "${dist:?}/$platform"
    mkdir -p "$dist/$platform"
    for file in $(libraries "$platform") $program $(extension "$platform"); do
        if ((${#of_platform[@]} == 1)); then
            cp "$directory/${of_platform[0]}/dist/$file" "$dist/$platform/$file"
        else
            python3 packaging/fat.py "$dist/$platform/$file" "${of_platform[@]/#/$directory/}" "dist/$file"
        fi
        # The linker leaves symbols of mingw-w64's own objects.
        [[ $platform != win64 ]] || x86_64-w64-mingw32-strip "$dist/$platform/$file"
    done
    [[ -z $(module "$platform") ]] || mv "$dist/$platform/$(extension "$platform")" "$dist/$platform/$(module "$platform")"
    (cd "$dist/$platform" && sha256sum -- *)
done
