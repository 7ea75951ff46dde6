#!/usr/bin/env bash
# Links of the documents lead to files and headings that are there; each scene of the gallery is a deck of input/ with a small picture;
# files, procedures and excerpts that doc/developers.md and CONTRIBUTING.md name stand in the tree.
#   documents.sh SOURCE
set -uo pipefail
export LC_ALL=C
cd "$1" || exit 1
failed=0
complain() { printf 'FAILED: %s\n' "$*"; failed=1; }
# Headings of a document as GitHub makes anchors of them, and its links, both outside fenced blocks
anchors() {
  awk '/^```/ { fenced = !fenced } !fenced && sub(/^#+ +/, "") { print tolower($0) }' "$1" | sed 's/[^a-z0-9 _-]//g; s/ /-/g'
}
links() { awk '/^```/ { fenced = !fenced } !fenced' "$1" | grep -o ']([^) ]*)' | sed 's/^](//; s/)$//'; }

while read -r document; do
  folder=$(dirname "$document")
  while read -r link; do
    case $link in http*) continue ;; esac
    path=${link%%#*}
    if [[ -z $path ]]; then file=$document; else file=$folder/$path; fi
    [[ -e $file ]] || { complain "$document: there is no $link"; continue; }
    [[ $link == *'#'* && $file == *.md ]] || continue
    grep -qxF -- "${link#*#}" <(anchors "$file") || complain "$document: $file has no heading for #${link#*#}"
  done < <(links "$document")
done < <(find . -name '*.md' -not -path './build/*' -not -path './.git/*' -not -path './results/*')

while read -r scene; do
  [[ -e input/$scene.inp ]] || complain "doc/gallery.md: there is no input/$scene.inp"
  picture=doc/gallery/$scene.svg
  [[ -e $picture ]] || { complain "there is no $picture"; continue; }
  [[ $(wc -c < "$picture") -le 40000 ]] || complain "$picture is larger than 40 kB"
done < <(sed -n 's/^### //p' doc/gallery.md)
[[ $(grep -c '^### ' doc/gallery.md) -ge 20 ]] || complain 'doc/gallery.md has fewer than 20 scenes'

# Names in backticks: with a folder they are files, with an underscore words of the sources; lines of ```fortran blocks, without the
# blanks before them, are lines of the sources
sources=$(mktemp)
trap 'rm -f "$sources" "$sources.words"' EXIT
find src tests cmake CMakeLists.txt -name '*.f90' -o -name '*.in' -o -name '*.cmake' -o -name '*.sh' -o -name CMakeLists.txt |
  xargs sed 's/^ *//; s/ *$//' > "$sources"
grep -oE '[A-Za-z][A-Za-z0-9_]*' "$sources" | sort -u > "$sources.words"
for document in doc/developers.md CONTRIBUTING.md; do
  names=$(awk '/^ *```/ { fenced = !fenced } !fenced' "$document" | grep -oE '`[^`]+`' | tr -d '`')
  while read -r name; do
    [[ -e $name || $name == *NAME* || $name == *'<'* ]] || complain "$document: there is no $name"
  done < <(grep -E '^(src|tests|doc|input|bench|postproc|cmake|\.ci|\.github)/[^ ]*$' <<< "$names" | sort -u)
  while read -r name; do
    grep -qxF -- "$name" "$sources.words" || complain "$document: the sources have no $name"
  done < <(grep -E '^[a-z][a-z0-9]*(_[a-z0-9]+)+$' <<< "$names" | sort -u)
  while read -r line; do
    [[ -z $line ]] || grep -qxF -- "$line" "$sources" || complain "$document: the sources have no line '$line'"
  done < <(awk '/^ *```/ { fortran = /```fortran/; next } fortran' "$document")
done
[[ $failed -eq 0 ]] && echo 'all links lead somewhere, and what is named is there'
exit $failed
