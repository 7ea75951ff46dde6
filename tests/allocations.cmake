# No allocation in the time loop: the number of heap allocations of a whole run, counted by valgrind, must not grow with the
# number of steps. A few belong to the text of the closing report, whose numbers have other digits, and to searches for new
# pivots; one in twenty steps would be told. No memory error either. Runs so many turns of the deck with two tolerances:
# cmake -DLIMBER= -DDECK= -DWORK= -DVALGRIND= -DINTEGRATOR= -DTIGHT= -DTURNS= -DLOOKS= -P allocations.cmake
file(READ ${DECK} deck)
get_filename_component(name ${DECK} NAME_WE)
set(run ${WORK}/allocations_${name}_${INTEGRATOR})
string(REGEX REPLACE ", *INTEGRATOR=[A-Z]+" "" deck "${deck}")
set(tolerances 1e-3 ${TIGHT})
foreach(tolerance IN LISTS tolerances)
  string(REGEX REPLACE "TOLERANCE=[^,]*" "TOLERANCE=${tolerance}, INTEGRATOR=${INTEGRATOR}" text "${deck}")
  # Samples are written after some seconds too: on a busy machine more often, and HDF5 allocates
  string(REGEX REPLACE "OUTPUTS=[0-9]*" "OUTPUTS=1" text "${text}")
  file(WRITE ${run}.inp "${text}")
  execute_process(COMMAND ${VALGRIND} ${LIMBER} run ${run}.inp --set turns=${TURNS} -o ${run}.h5 --force
    OUTPUT_VARIABLE report ERROR_VARIABLE counts RESULT_VARIABLE status)
  if(NOT status EQUAL 0 OR NOT counts MATCHES "total heap usage: ([0-9,]+) allocs")
    message(FATAL_ERROR "valgrind or the run failed (${status}): ${counts}")
  endif()
  set(allocations_${tolerance} ${CMAKE_MATCH_1})
  if(NOT report MATCHES "in ([0-9]+) steps")
    message(FATAL_ERROR "no number of steps in: ${report}")
  endif()
  set(steps_${tolerance} ${CMAKE_MATCH_1})
  message("TOLERANCE=${tolerance}: ${steps_${tolerance}} steps, ${allocations_${tolerance}} allocations")
  if(NOT counts MATCHES "ERROR SUMMARY: 0 errors")
    message(FATAL_ERROR "memory errors: ${counts}")
  endif()
endforeach()
string(REPLACE "," "" few "${allocations_1e-3}")
string(REPLACE "," "" many "${allocations_${TIGHT}}")
math(EXPR steps "${steps_${TIGHT}} - ${steps_1e-3}")
math(EXPR allocations "${many} - ${few}")
# ADAMS looks at the linearised system every 2000 steps: some 300 allocations
# The watch of an exact beam makes some 18 when it looks, at one step in thirty or fewer
math(EXPR allowed "${steps} / 20 + ${LOOKS} * ${steps} / 30 + 400 * (1 + ${steps} / 2000)")
if(steps LESS 2000)
  message(FATAL_ERROR "the two runs differ by ${steps} steps only: the comparison says nothing")
endif()
if(allocations GREATER allowed)
  message(FATAL_ERROR "${steps} more steps make ${allocations} more allocations")
endif()
