cmake_policy(SET CMP0007 NEW)
# A sweep finishes what can be run and names what cannot; parts of it, gathered, are the whole to the bit; called again it runs
# nothing; killed, it goes on; a row is the run of the deck with its values.
# cmake -DLIMBER= -DDECK=<input/sweep_speed.inp> -DWORK=<folder> -P sweep.cmake
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
file(READ ${DECK} deck)
string(REPLACE "10:105:20" "10:105:3" deck "${deck}")
# One diameter is none, and a deck like that of its row cannot be used
string(REPLACE "8e-3, 10e-3, 12e-3" "8e-3, -1e-3" deck "${deck}")
file(WRITE ${WORK}/deck.inp "${deck}")

function(limber expected)
  execute_process(COMMAND ${LIMBER} ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT status EQUAL expected)
    message(FATAL_ERROR "limber ${ARGN}: status ${status} in place of ${expected}\n${out}${err}")
  endif()
  set(text "${out}${err}" PARENT_SCOPE)
endfunction()
function(expect pattern)
  if(NOT text MATCHES "${pattern}")
    message(FATAL_ERROR "no '${pattern}' in:\n${text}")
  endif()
endfunction()

limber(3 sweep deck.inp --jobs 2 -o whole.h5)
expect("9 rows: 6 ok, 3 refused")
expect("row 3 \\(speed = 10, diameter = -0.001\\) refused: deck.inp:[0-9]+:[0-9]+: error")
file(STRINGS ${WORK}/whole.csv lines)
list(LENGTH lines count)
if(NOT count EQUAL 10)
  message(FATAL_ERROR "the table has ${count} lines")
endif()

# Again: only what has failed
limber(3 sweep deck.inp --jobs 2 -o whole.h5)
expect("6 rows were done already")
# Without the failing rows there is nothing left to do, with more values only those
limber(0 sweep deck.inp --jobs 2 -o whole.h5 --set diameter=6e-3,8e-3)
expect("6 rows were done already")
limber(0 sweep deck.inp --jobs 2 -o whole.h5 --set diameter=6e-3,8e-3,9e-3)
expect("6 rows were done already.*9 rows: 9 ok")

# Rows with the same values are one run, and each has its results
limber(0 sweep deck.inp --jobs 2 -o same.h5 --set speed=57.5,60,57.5 --set diameter=8e-3)
expect("3 rows: 3 ok.*1 of them have the values of an earlier row")
file(STRINGS ${WORK}/same.csv first REGEX "^1,")
file(STRINGS ${WORK}/same.csv third REGEX "^3,")
string(REGEX REPLACE "^1,57.5,0.008,ok,([^,]*),[^,]*,(.*)$" "\\1,\\2" first "${first}")
string(REGEX REPLACE "^3,57.5,0.008,ok,([^,]*),[^,]*,(.*)$" "\\1,\\2" third "${third}")
if(NOT first STREQUAL third OR first MATCHES "^1,")
  message(FATAL_ERROR "rows with the same values differ:\n${first}\n${third}")
endif()
# A value may be an expression of numbers
limber(0 sweep deck.inp --jobs 2 -o terms.h5 --set speed=50+7.5,1e+1 --set diameter=8e-3)
file(STRINGS ${WORK}/terms.csv row REGEX "^1,57.5,0.008,ok,")
if(row STREQUAL "")
  message(FATAL_ERROR "--set speed=50+7.5 is not 57.5")
endif()

# Parts, as tasks of a job array run them
foreach(k 1 2)
  limber(3 sweep deck.inp --part ${k}/2 --jobs 1 -o parts.h5)
endforeach()
if(EXISTS ${WORK}/parts.h5)
  message(FATAL_ERROR "a part has written the summary")
endif()
limber(3 sweep deck.inp --collect -o parts.h5)
limber(3 sweep deck.inp -o whole.h5)
limber(0 diff parts.h5 whole.h5 --rtol 0 --range 0)
# Rows that were not run have no scalars, which no zero stands for
limber(0 export whole.h5)
if(NOT text MATCHES "\n 3[.]0000000000000000E[+]000[^\n]*NaN" OR text MATCHES "\n 1[.]0000000000000000E[+]000[^\n]*NaN")
  message(FATAL_ERROR "scalars of refused rows:\n${text}")
endif()

# A row is a run of the deck with its values
limber(0 run deck.inp --set speed=57.5 --set diameter=8e-3 -o row.h5)
string(REGEX MATCH "largest = ([^\n]*)" found "${text}")
string(SUBSTRING "${CMAKE_MATCH_1}" 0 6 digits)
file(STRINGS ${WORK}/whole.csv row REGEX "^5,57.5,0.008,ok,")
if(digits STREQUAL "" OR NOT row MATCHES ",${digits}")
  message(FATAL_ERROR "largest = ${digits}... is not in the row ${row}")
endif()

# Killed in the middle, it goes on from there
string(REPLACE "OUTPUTS=400" "OUTPUTS=20000" slow "${deck}")
file(WRITE ${WORK}/slow.inp "${slow}")
execute_process(COMMAND ${LIMBER} sweep slow.inp --jobs 1 --set diameter=6e-3 --set speed=20:100:9 WORKING_DIRECTORY ${WORK}
  TIMEOUT 1 RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
limber(0 sweep slow.inp --jobs 2 --set diameter=6e-3 --set speed=20:100:9)
expect("9 rows: 9 ok")
limber(0 sweep slow.inp --jobs 1 --set diameter=6e-3 --set speed=20:100:9 -o again.h5)
limber(0 diff slow.sweep.h5 again.h5 --rtol 0 --range 0)

# A process that is killed in the middle of a row: the row says so, the others are run, and the next sweep has it right
if(EXISTS /proc/thread-self/children)
  execute_process(COMMAND sh -c "\
    ${LIMBER} sweep slow.inp --jobs 1 --set diameter=6e-3 --set speed=20:100:9 -o crashed.h5 & p=$!; \
    while kill -0 $p 2> /dev/null; do \
      c=$(cat /proc/$p/task/$p/children) && test -n \"$c\" && kill -STOP $c || continue; \
      tail -q -n 1 crashed.rows/* 2> /dev/null | grep -q begun && kill -9 $c && break; \
      kill -CONT $c; \
    done; \
    wait $p" WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 3)
    message(FATAL_ERROR "a sweep of which a process is killed: status ${status}\n${text}")
  endif()
  expect("9 rows: 8 ok, 1 crashed")
  expect("crashed: the process has ended with signal 9")
  limber(0 sweep slow.inp --jobs 2 --set diameter=6e-3 --set speed=20:100:9 -o crashed.h5)
  expect("8 rows were done already")
  limber(0 diff crashed.h5 again.h5 --rtol 0 --range 0)
endif()

# Histories are kept when they are asked for, and are those of single runs
limber(0 sweep deck.inp --set diameter=8e-3 --set speed=57.5 --keep -o kept.h5)
file(GLOB histories ${WORK}/kept.rows/*.h5)
list(LENGTH histories count)
if(NOT count EQUAL 1)
  message(FATAL_ERROR "${count} histories")
endif()
limber(0 diff ${histories} row.h5 --rtol 0 --range 0)

# Samples spread over ranges: one in each of equal parts; the same again with the same seed
string(REGEX REPLACE "\\*SWEEP.*" "*SWEEP, METHOD=LATIN HYPERCUBE, SAMPLES=5\n speed, 10:60\n diameter, 6e-3:11e-3\n" latin "${deck}")
file(WRITE ${WORK}/latin.inp "${latin}")
limber(0 sweep latin.inp --jobs 2)
foreach(column 2 3)
  set(parts)
  file(STRINGS ${WORK}/latin.sweep.csv lines REGEX "^[0-9]")
  foreach(line ${lines})
    string(REPLACE "," ";" fields "${line}")
    math(EXPR place "${column} - 1")
    list(GET fields ${place} value)
    string(REGEX REPLACE "^0\\.0*" "" value "${value}")
    string(SUBSTRING "${value}" 0 1 part)
    if(column EQUAL 3 AND value MATCHES "^1")
      set(part 10)
    endif()
    list(APPEND parts ${part})
  endforeach()
  list(REMOVE_DUPLICATES parts)
  list(LENGTH parts count)
  if(NOT count EQUAL 5)
    message(FATAL_ERROR "column ${column} of the samples is not spread: ${parts}")
  endif()
endforeach()

# A table of values, and what is wrong with it
file(WRITE ${WORK}/cases.csv "speed, diameter\n20, 6e-3\n30, 7e-3\n")
string(REGEX REPLACE "\\*SWEEP.*" "*SWEEP, FILE=\"cases.csv\"\n" table "${deck}")
file(WRITE ${WORK}/table.inp "${table}")
limber(0 sweep table.inp)
expect("2 rows: 2 ok")
file(WRITE ${WORK}/cases.csv "speed, diameter\n20, 6e-3\n30, thick\n")
limber(2 sweep table.inp)
expect("cases.csv:3:5: error: 'thick' is not a number")
limber(2 sweep deck.inp --set sped=1,2)
expect("no parameter 'sped'")
limber(2 run deck.inp --set sped=1)
expect("did you mean 'speed'")
# A file of another kind is not overwritten
file(WRITE ${WORK}/mine.h5 "mine")
limber(2 sweep deck.inp -o mine.h5)
expect("mine.h5 exists")
# Scalars have the units of their channels: a deflection over a length
find_program(DUMP h5dump)
if(DUMP)
  execute_process(COMMAND ${DUMP} -a /channels/largest/units ${WORK}/whole.h5 OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  expect("\\(0\\): \"1\"")
endif()
