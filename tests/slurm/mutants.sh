#!/usr/bin/env bash
# Tests of the test: acceptance.sh must fail with each of these programs and scripts. Some minutes each; not for every CI run.
#
#   mutants.sh RAYREEL [NAME...]      all, or those of these names
#
# Mutants of the scripts stand in for sbatch: they change the script or the line, and submit it. Mutants of the program are patched into
# a copy of the repository and built there.
set -uo pipefail

rayreel=$(realpath "${1:?mutants.sh RAYREEL [NAME...]}")
shift
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
caught=0 missed=0
chosen=("$@")

wanted() { [ ${#chosen[@]} = 0 ] || [[ " ${chosen[*]} " == *" $1 "* ]]; }

judge() { # NAME RAYREEL PATH
    if PATH=$3 "$here/acceptance.sh" --required "$2" > "$work/log" 2>&1; then
        echo "MISSED: $1"
        missed=$((missed + 1))
    else
        echo "caught: $1 <- $(grep -m 1 -E '^FAILED' "$work/log" | cut -c 1-150)"
        caught=$((caught + 1))
    fi
}

script() { # NAME SED-EXPRESSION: over the scripts
    wanted "$1" || return 0
    mkdir -p "$work/bin"
    cat > "$work/bin/sbatch" << SHIM
#!/usr/bin/env bash
for word; do
    case \$word in */shard.sh | */merge.sh) sed -i -E '$2' "\$word" ;; esac
done
exec $(command -v sbatch) "\$@"
SHIM
    chmod +x "$work/bin/sbatch"
    judge "$1" "$rayreel" "$work/bin:$PATH"
}

words() { # NAME PATTERN REPLACEMENT: over the words of the sbatch line; words that become empty are left out
    wanted "$1" || return 0
    mkdir -p "$work/bin"
    cat > "$work/bin/sbatch" << SHIM
#!/usr/bin/env bash
line=()
for word; do
    word=\${word/#$2/$3}
    [ -z "\$word" ] || line+=("\$word")
done
exec $(command -v sbatch) "\${line[@]}"
SHIM
    chmod +x "$work/bin/sbatch"
    judge "$1" "$rayreel" "$work/bin:$PATH"
}

program() { # NAME FILE SED-EXPRESSION: over the source
    wanted "$1" || return 0
    mkdir -p "$work/source"
    (cd "$here/../.." && git ls-files -z | xargs -0 cp --parents -t "$work/source")
    cp -p "$work/source/$2" "$work/before"
    sed -i -E "$3" "$work/source/$2"
    if cmp -s "$work/before" "$work/source/$2"; then
        echo "MISSED: $1 changed nothing"
        missed=$((missed + 1))
        return 0
    fi
    if ! (cd "$work/source" && cargo build --release --locked --target-dir "${MUTANT_TARGET:-$work/target}" > "$work/log" 2>&1); then
        echo "MISSED: $1 does not build: $(tail -n 3 "$work/log")"
        missed=$((missed + 1))
        return 0
    fi
    judge "$1" "${MUTANT_TARGET:-$work/target}/release/rayreel" "$PATH"
}

script term-revives 's/stop no/stop yes/'
script term-kills 's/kill -TERM/kill -KILL/'
script limit-forgotten 's/if scontrol requeue .*; then/if true; then/'
script code-lost 's/^exit "\$code"/exit 0/'
script merge-ignored 's/^exec .* sweep merge .*/exit 0/'
words not-requeued --requeue --no-requeue
words afterok --dependency=afterany --dependency=afterok
words truncated --open-mode=append --open-mode=truncate
words offset-forgotten 6 0
program resume-forgets replay/src/sweep/run.rs 's/if held\.rows\.contains_key\(key\)/if false \&\& held.rows.contains_key(key)/'
program term-unheard src/progress.rs 's/STOP\.load\(Ordering::Relaxed\)/false/'
program shared-names src/sweep/run.rs 's/blake3::hash\(text\.as_bytes\(\)\)/blake3::hash(b"")/'
program missing-unseen replay/src/sweep/shard.rs 's/\(0\.\.count\)\.filter\(has\)\.collect\(\)/(0..count).filter(|i| *i == 0 || has(i)).collect()/'
echo "$caught caught, $missed missed"
[ $missed = 0 ]
