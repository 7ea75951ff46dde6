#!/usr/bin/env bash
# Names and texts are data: paths, units, headings and attributes that a shell, awk or gnuplot would evaluate, if they let it, are
# shown and used as they are, by limber and by the scripts of postproc/ and jobs/.
#   names.sh LIMBER SOURCE WORK     SOURCE: the folder with postproc/ and jobs/; ALL=1 tests/names.sh ...: more names
set -uo pipefail
limber=$1 source=$2 work=$3
rm -rf "$work"; mkdir -p "$work/bin"; cd "$work" || exit 1
ln -s "$limber" bin/limber
export PATH=$work/bin:$PATH
failed=0
complain() { printf 'FAILED: %s\n' "$*"; cat "$work/messages"; failed=1; }
# A command of the name `evil` leaves a trace, wherever it is run from
cat > bin/evil <<TEXT
#!/bin/sh
echo "\$@" >> '$work/evaluated'
TEXT
chmod +x bin/evil
draws=$(command -v gnuplot)
dumps=$(command -v h5dump)

read -r -d '' deck <<'TEXT'
*HEADING
 It's "100 %s" `evil heading` $(evil heading); @NL@# symbol `evil symbol`@NL@# unit `evil unit`@NL@# sample 1, t = `evil t`@NL@system("evil")
*PARAMETER
 speed = 3
*UNITS, LENGTH="`evil length`'$(evil length) %d", TIME="`evil time`"
*RIGID BODY, NAME=rod, MASS=1, INERTIA=0.1, CENTRE X=0.5
 tip, 1, 0
*JOINT, NAME=pin, TYPE=REVOLUTE
 rod.origin, ground.origin
*DRIVER, NAME=motor, TYPE=ANGLE, BODY=rod
 speed*t
*DYNAMICS, END=0.2, OUTPUTS=4
*OUTPUT, MOTION=YES
 x_tip = x(rod.tip)
TEXT
names=('a b' "it's" 'say "so"' '`evil back`' '$(evil dollar)' 'a; evil semicolon' 'a|evil pipe' '100 %d %s' $'two\nlines' 'back\slash\n'
  'a*[b]?{c}' '-o' '~' '#1' '&& evil' '<evil' 'ü' "'.system(\"evil gnuplot\").'")
# All of them in one name, unless more is wanted
[[ -n ${ALL:-} ]] || names=($'all `evil`$(evil)"\'; evil|evil %s\\n *[b]\n<evil #' '-o' 'a b')
for name in "${names[@]}"; do
  mkdir "./$name" && cd "./$name" || exit 1
  printf '%s\n' "$deck" > "./$name.inp"
  if ! limber run "./$name.inp" --quiet > "$work/messages" 2>&1; then complain "run $name"; cd "$work"; continue; fi
  [[ -f ./$name.h5 ]] || complain "no results of '$name'"
  # Texts of variable length have no checksum in HDF5: a foreign file may have lines in them
  LC_ALL=C sed 's/@NL@/\n\n\n\n/g' "./$name.h5" > "./foreign $name.h5"
  limber export "./foreign $name.h5" > "$work/messages" 2>&1 || complain "export $name"
  [[ $(wc -l < "$work/messages") -eq 6 ]] || complain "columns of $name"
  limber export "./foreign $name.h5" --motion --sample 1 > "$work/messages" 2>&1 || complain "export --motion $name"
  [[ $(grep -c '^# symbol' "$work/messages") -eq 1 ]] || complain "the heading is another line"
  if [[ -n $draws ]]; then
    for file in "./$name.h5" "$PWD/foreign $name.h5"; do
      "$source/postproc/draw" "$file" --format svg --sample 1 > "$work/messages" 2>&1 || complain "draw $file"
      picture=${file##*/}
      picture=./${picture%.h5}.svg
      [[ -f $picture ]] || complain "no picture of $file"
      grep -q 'evil length' "$picture" || complain "the unit is not shown"
      grep -q '100 %s' "$picture" || complain "the heading is not shown"
    done
    "$source/postproc/draw" "./$name.h5" -o "./picture $name.png" > "$work/messages" 2>&1 || complain "draw -o $name"
    [[ -f "./picture $name.png" ]] || complain "no picture $name"
  fi
  if [[ -n $draws && -n $dumps ]]; then
    printf '%s\n*STUDY, REPEATS=1\n integrators, RADAU, ADAMS\n tolerances, 1e-3, 1e-4, 1e-6\n' "$deck" > "./study $name.inp"
    limber study "./study $name.inp" -o "./study $name.h5" --quiet > "$work/messages" 2>&1 || complain "study $name"
    "$source/postproc/study" "./study $name.h5" "./figure $name" > "$work/messages" 2>&1 || complain "figure of a study $name"
    grep -q 'Pareto front' "./figure $name.svg" || complain "no figure of a study $name"
    grep -q "stroke='.*0,   0,   0.'" "./figure $name.svg" || complain "no front in the figure of $name"
  fi
  # A sweep with its folder of rows, by the script of a cluster too
  printf '%s\n*SWEEP, KEEP=YES\n speed, 1, 2\n' "$deck" > "./sweep $name.inp"
  limber sweep "./sweep $name.inp" --part 1/2 --quiet > "$work/messages" 2>&1 || complain "sweep $name"
  limber sweep "./sweep $name.inp" > "$work/messages" 2>&1 || complain "sweep $name again"
  grep -q '1 row was done already\|1 rows were done already' "$work/messages" || complain "journals of $name"
  LIMBER=$limber bash "$source/jobs/sweep_collect.sh" "sweep $name.inp" > "$work/messages" 2>&1 || complain "collect $name"
  grep -q '2 rows: 2 ok' "$work/messages" || complain "rows of $name"
  rm -f "./$name.h5"
  LIMBER=$limber LIMBER_OPTIONS='--checkpoint 1' bash "$source/jobs/run_restart.sh" "$name.inp" > "$work/messages" 2>&1 || complain "job $name"
  [[ -f ./$name.h5 ]] || complain "no results of the job '$name'"
  cd "$work" || exit 1
done
# What is not data: names of parameters, bodies and channels are letters and digits, values are numbers
for setting in '`evil`=1' 'speed=`evil`' 'speed=$(evil)' 'sp;eed=1' $'speed\n=x' 'speed=1:2:`evil`'; do
  printf '%s\n' "$deck" > plain.inp
  limber run plain.inp -o x.h5 --force --set "$setting" > messages 2>&1
  [[ $? -eq 2 ]] || complain "--set $setting"
done
for bad in '`evil`' 'a;b' 'a b"' '%s'; do
  printf '%s\n*POINT MASS, NAME=%s, MASS=1\n' "$deck" "$bad" > plain.inp
  limber run plain.inp -o x.h5 --force > messages 2>&1
  [[ $? -eq 2 ]] || complain "a body of the name $bad"
done
limber run 'plain.inp ' > messages 2>&1
[[ $? -eq 2 ]] && grep -q 'ends in a blank' messages || complain 'a blank at the end'
if [[ -e evaluated ]]; then
  echo 'FAILED: these were run:'
  sort evaluated | uniq -c
  failed=1
fi
[[ $failed -eq 0 ]] && echo 'all as it should be'
exit $failed
