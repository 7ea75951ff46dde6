# A run that is ended by a signal, or killed, and goes on: cmake -DLIMBER=... -DDECK=... -DWORK=... -P restart.cmake
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

# Runs a command of the shell in the folder and compares its status
function(expect status text command)
  execute_process(COMMAND sh -c "${command}" WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(NOT result EQUAL ${status})
    message(FATAL_ERROR "${command}: status ${result}, expected ${status}\n${output}")
  endif()
  if(NOT output MATCHES "${text}")
    message(FATAL_ERROR "${command}: '${text}' is not in\n${output}")
  endif()
endfunction()

# Waits for the first checkpoint of a run, if that does not end before
set(later "p=$!; while test ! -e FILE.checkpoint.h5 && kill -0 $p; do sleep 0.02; done; sleep 0.1")
set(run "${LIMBER} run ${DECK} --set turns=4 --quiet")
expect(0 "" "${run} -o whole.h5")
foreach(signal TERM INT USR1)
  string(REPLACE FILE ${signal} wait "${later}")
  expect(4 "interrupted by SIG${signal}" "${run} -o ${signal}.h5 --checkpoint 0.02 & ${wait}; kill -${signal} $p; wait $p")
  expect(2 "give --force" "${run} -o ${signal}.h5")
  expect(2 "another deck" "${run} -o ${signal}.h5 --set crank=0.14 --restart")
  expect(0 "" "${run} -o ${signal}.h5 --restart")
  expect(0 "the same" "${LIMBER} diff ${signal}.h5 whole.h5 --rtol 0 --range 0")
  expect(0 "" "test ! -e ${signal}.checkpoint.h5")
  expect(0 "nothing left to do" "${LIMBER} run ${DECK} --set turns=4 -o ${signal}.h5 --restart")
endforeach()

# Killed at some moments: what was written can be read, and the run goes on from its last checkpoint
string(REPLACE FILE killed wait "${later}")
expect(0 "" "for s in 0 0.1 0.2; do ${run} -o killed.h5 --checkpoint 0.02 --restart & ${wait}; sleep $s; kill -9 $p; wait $p; \
  ${LIMBER} export killed.h5 > /dev/null || exit 1; test -e killed.checkpoint.h5 || exit 2; done")
expect(0 "" "${run} -o killed.h5 --restart")
expect(0 "the same" "${LIMBER} diff killed.h5 whole.h5 --rtol 0 --range 0")

# Things that are not what they should be; nothing is changed
string(REPLACE FILE odd wait "${later}")
expect(137 "" "${run} -o odd.h5 --checkpoint 0.02 & ${wait}; kill -9 $p; wait $p")
expect(0 "" "cp odd.checkpoint.h5 good; head -c 3000 good > odd.checkpoint.h5; cp odd.h5 before")
expect(2 "cannot open odd.checkpoint.h5" "${run} -o odd.h5 --restart")
expect(0 "" "echo something > odd.checkpoint.h5")
expect(2 "not an HDF5 file" "${run} -o odd.h5 --restart")
expect(0 "" "cp whole.h5 odd.checkpoint.h5")
expect(2 "not a checkpoint" "${run} -o odd.h5 --restart")
expect(0 "" "rm odd.checkpoint.h5")
expect(2 "no odd.checkpoint.h5" "${run} -o odd.h5 --restart")
expect(0 "" "cmp before odd.h5; cp good odd.checkpoint.h5; mv odd.h5 away")
expect(2 "is not; without --restart" "${run} -o odd.h5 --restart")
expect(0 "" "mv away odd.h5; ${run} -o odd.h5 --restart")
expect(0 "the same" "${LIMBER} diff odd.h5 whole.h5 --rtol 0 --range 0")
