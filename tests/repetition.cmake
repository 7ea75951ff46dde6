# The same deck gives the same bits: run again, with any number of threads of the libraries, on another day.
# cmake -DLIMBER=... -DINPUT=... -DWORK=... -DTHREADS="1 2 8" -P repetition.cmake
cmake_policy(SET CMP0007 NEW)
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

string(REPLACE " " ";" numbers "${THREADS}")

# name|text in the deck|what stands for it|...
set(decks "slider_crank_exact|turns = 2|turns = 0.5" "andrews_squeezer|TOLERANCE=1e-8|TOLERANCE=1e-8"
  "four_bar_chain|END=20, OUTPUTS=1000|END=2, OUTPUTS=100" "chain_flexible|END=1, OUTPUTS=100|END=0.2, OUTPUTS=100"
  "portal_frame|DIVISIONS=12|DIVISIONS=100" "rotating_cantilever|ELEMENTS=64|ELEMENTS=1000"
  "cantilever_statics|OUTPUT|OUTPUT" "free_free_beam|OUTPUT|OUTPUT")

function(limber)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env OMP_NUM_THREADS=${threads} OPENBLAS_NUM_THREADS=${threads} MKL_NUM_THREADS=${threads}
    BLIS_NUM_THREADS=${threads} ${LIMBER} ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "limber ${ARGN}, ${threads} threads: status ${status}\n${text}")
  endif()
endfunction()

foreach(entry ${decks})
  string(REPLACE "|" ";" words "${entry}")
  list(GET words 0 name)
  list(GET words 1 old)
  list(GET words 2 new)
  file(READ ${INPUT}/${name}.inp deck)
  string(FIND "${deck}" "${old}" at)
  if(at LESS 0)
    message(FATAL_ERROR "${name} has no ${old}")
  endif()
  string(REPLACE "${old}" "${new}" deck "${deck}")
  file(WRITE ${WORK}/${name}.inp "${deck}")
  foreach(threads ${numbers})
    limber(run ${name}.inp --quiet -o ${name}.${threads}.h5)
    limber(diff ${name}.${threads}.h5 ${name}.1.h5 --rtol 0 --range 0)
  endforeach()
  set(threads 1)
  limber(run ${name}.inp --quiet -o ${name}.again.h5)
  limber(diff ${name}.again.h5 ${name}.1.h5 --rtol 0 --range 0)
endforeach()
