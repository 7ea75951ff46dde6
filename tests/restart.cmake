# A run that is ended by a signal, or killed, and goes on: cmake -DLIMBER=... -DINPUT=... -DWORK=... -DTURNS=4 -P restart.cmake
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(DECK ${INPUT}/slider_crank_exact.inp)

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
set(later "p=$!; while test ! -e FILE.checkpoint.h5 && kill -0 $p; do sleep 0.01; done; sleep 0.02")
set(run "${LIMBER} run ${DECK} --set turns=${TURNS} --quiet")
expect(0 "" "${run} -o whole.h5")
foreach(signal TERM INT USR1)
  string(REPLACE FILE ${signal} wait "${later}")
  expect(4 "interrupted by SIG${signal}" "${run} -o ${signal}.h5 --checkpoint 0.02 & ${wait}; kill -${signal} $p; wait $p")
  expect(2 "samples of a run that did not finish; give --restart to continue it, --force to overwrite it" "${run} -o ${signal}.h5")
  expect(2 "another deck" "${run} -o ${signal}.h5 --set crank=0.14 --restart")
  expect(0 "continued at t = " "cp ${signal}.checkpoint.h5 kept; ${LIMBER} run ${DECK} --set turns=${TURNS} -o ${signal}.h5 --restart")
  expect(0 "the same" "${LIMBER} diff ${signal}.h5 whole.h5 --rtol 0 --range 0")
  expect(0 "" "test ! -e ${signal}.checkpoint.h5 && test ! -e ${signal}.h5.running")
  # Killed between its end and the removal of its checkpoint
  expect(0 "nothing left to do" "mv kept ${signal}.checkpoint.h5; ${LIMBER} run ${DECK} --set turns=${TURNS} -o ${signal}.h5 --restart")
  expect(0 "" "test ! -e ${signal}.checkpoint.h5")
endforeach()

# Killed at some moments: what was written can be read, and the run goes on from its last checkpoint
string(REPLACE FILE killed wait "${later}")
expect(0 "" "for s in 0 0.05 0.1; do ${run} -o killed.h5 --checkpoint 0.02 --restart & ${wait}; sleep $s; kill -9 $p; wait $p; \
  ${LIMBER} export killed.h5 > /dev/null || exit 1; test -e killed.checkpoint.h5 || exit 2; done")
expect(0 "" "${run} -o killed.h5 --restart")
expect(0 "the same" "${LIMBER} diff killed.h5 whole.h5 --rtol 0 --range 0")

# While a run goes on its results can be read, and no other run takes its place
string(REPLACE FILE on wait "${later}")
expect(2 "the run goes on still: .*on.h5.running: another program has it open" "${run} --set turns=${TURNS}0 -o on.h5 --checkpoint 0.02 & ${wait}; \
  ${LIMBER} export on.h5 > /dev/null || exit 9; ${run} -o on.h5 --restart; s=$?; kill -9 $p; exit $s")
expect(2 "cannot overwrite on.h5.running: another program" "rm on.h5.running; ${run} --set turns=${TURNS}0 -o on.h5 --force & p=$!; \
  while test ! -e on.h5.running; do sleep 0.05; done; sleep 0.1; ${run} -o on.h5 --force; s=$?; kill -9 $p; exit $s")

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
expect(0 "" "cp before odd.h5; truncate -s 5000 odd.h5; cp odd.h5 cut")
expect(2 "odd.h5 cannot be continued; it was left as it is: cannot open odd.h5: truncated file" "${run} -o odd.h5 --restart")
expect(2 "odd.h5 exists; give --force" "${run} -o odd.h5")
expect(0 "" "cmp cut odd.h5; cp good odd.h5; cp good foreign")
expect(2 "odd.h5 is not a results file of limber" "${run} -o odd.h5 --restart")
expect(2 "odd.h5 exists; give --force" "${run} -o odd.h5")
expect(0 "" "cmp foreign odd.h5; cmp good odd.checkpoint.h5; echo text > odd.h5")
expect(2 "odd.h5 is not an HDF5 file" "${run} -o odd.h5 --restart")
expect(2 "odd.h5 exists; give --force" "${run} -o odd.h5")
expect(0 "" "test \"$(cat odd.h5)\" = text; mv away odd.h5; ${run} -o odd.h5 --restart")
expect(0 "the same" "${LIMBER} diff odd.h5 whole.h5 --rtol 0 --range 0")

# Ended while its errors are estimated: the run itself is not done again but for what came behind its last checkpoint
file(READ ${DECK} deck)
string(REPLACE "TOLERANCE=1e-8, OUTPUTS=838" "TOLERANCE=1e-6, OUTPUTS=838\n*ACCURACY, ESTIMATE=YES" deck "${deck}")
file(WRITE ${WORK}/estimate.inp "${deck}")
expect(0 "" "${LIMBER} run estimate.inp --quiet -o whole-estimate.h5")
expect(4 "SIGTERM while the errors of the run were estimated; with --restart" "${LIMBER} run estimate.inp --quiet --checkpoint 0.01 & p=$!; \
  while kill -0 $p; do ${LIMBER} export estimate.h5 2> /dev/null | wc -l | grep -q 840 && break; sleep 0.01; done; kill -TERM $p; wait $p")
expect(0 "continued at t = 0.0[78]" "${LIMBER} run estimate.inp --restart")
expect(0 "the same" "${LIMBER} diff estimate.h5 whole-estimate.h5 --rtol 0 --range 0")
