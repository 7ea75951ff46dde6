# What a study finds of a setting is true of a deck with these options: a deck is run, and the study of a deck that differs in
# them is given the result as its reference, so that its one setting must have no error.
# cmake -DLIMBER= -DDECK=<input/slider_crank_exact.inp> -DWORK=<folder> -P study.cmake
file(MAKE_DIRECTORY ${WORK})
file(READ ${DECK} deck)

# The deck with the options of the setting
string(REPLACE "TOLERANCE=1e-8" "TOLERANCE=1e-4, INTEGRATOR=RADAU" same "${deck}")
string(REPLACE "STRAIN FUNCTIONS=3" "STRAIN FUNCTIONS=0" same "${same}")
string(REPLACE "FUNCTIONS=7" "FUNCTIONS=2" same "${same}")
file(WRITE ${WORK}/same.inp "${same}")
execute_process(COMMAND ${LIMBER} run ${WORK}/same.inp -o ${WORK}/same.h5 --force --quiet COMMAND_ERROR_IS_FATAL ANY)

# The deck as it is, with a study of that setting, and of one that fails
set(lists "
 tolerances, 1e-4
 functions, 2
 strain functions, 0
 channels, deflection_over_length, slider_x
")
file(WRITE ${WORK}/study.inp "${deck}\n*STUDY, REPEATS=1, REFERENCE=same.h5\n integrators, RADAU${lists}")
execute_process(COMMAND ${LIMBER} study ${WORK}/study.inp -o ${WORK}/study.h5 --force OUTPUT_VARIABLE report
  COMMAND_ERROR_IS_FATAL ANY)
if(NOT report MATCHES "RADAU at 1e-4 with 2 functions and 0 strain functions: [^\n]* in [^\n]* ms; no run here has one more digit")
  message(FATAL_ERROR "no advice:\n${report}")
endif()
# Columns of numbers of the model have the names of their lists, above the numbers and in the file
if(NOT report MATCHES "\n  integrator +tolerance   functions  strain functions +CPU ms[^\n]*\n[*] RADAU +1e-4 +2 +0 +")
  message(FATAL_ERROR "columns of the table are not named by their lists:\n${report}")
endif()
execute_process(COMMAND ${LIMBER} export ${WORK}/study.h5 functions strain_functions OUTPUT_VARIABLE columns
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${LIMBER} export ${WORK}/study.h5 error OUTPUT_VARIABLE columns COMMAND_ERROR_IS_FATAL ANY)
if(NOT columns MATCHES "0\\.0000000000000000E\\+000\n$")
  message(FATAL_ERROR "the setting in the study and in a deck differ:\n${columns}")
endif()

# Too many functions fail with the reason of the deck; the others go on
string(REPLACE "\n functions, 2" "\n functions, 2, 200" lists "${lists}")
file(WRITE ${WORK}/failing.inp "${deck}\n*STUDY, REPEATS=1, REFERENCE=same.h5\n integrators, RADAU${lists}")
execute_process(COMMAND ${LIMBER} study ${WORK}/failing.inp -o ${WORK}/failing.h5 --force OUTPUT_VARIABLE report
  COMMAND_ERROR_IS_FATAL ANY)
if(NOT report MATCHES "200 +0  failed: beam 'rod': 200 modes on" OR NOT report MATCHES "\n\\* RADAU")
  message(FATAL_ERROR "no failed run, or no other:\n${report}")
endif()

# Where the table comes from: the deck, and the effective deck, which can be run
find_program(DUMP h5dump)
if(DUMP)
  execute_process(COMMAND ${DUMP} -a /run/limber_version -a /run/commit -a /run/compiler -a /run/compiler_options -a /run/heading
    ${WORK}/study.h5 OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  foreach(name deck effective_deck)
    execute_process(COMMAND ${DUMP} -d /run/${name} ${WORK}/study.h5 OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
    if(NOT text MATCHES "\\*STUDY" OR NOT text MATCHES "\\*BEAM")
      message(FATAL_ERROR "no deck in /run/${name}:\n${text}")
    endif()
  endforeach()
endif()

# The finest model of a study is its reference, and no more: what its run warns of is told, of a beam whose 2 functions leave out most
# of the vibrations that a sudden force sets off; of one that follows them nothing is
set(arm "*MATERIAL, NAME=steel, YOUNG=2e11, DENSITY=7850
*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.005
*BEAM, NAME=arm, MATERIAL=steel, SECTION=s, LENGTH=1
 q, 0.25
*JOINT, NAME=w, TYPE=WELD
 arm.start, ground.origin
*FORCE, NAME=f, POINT=arm.end
 0, FORCE
*DYNAMICS, END=0.1, OUTPUTS=20, TOLERANCE=1e-4
*OUTPUT
 y(arm.end), m = bending_moment(arm.q)
*STUDY, REPEATS=1
 integrators, RADAU
 tolerances, 1e-3
")
string(REPLACE "FORCE\n" "2\n" sudden "${arm}")
file(WRITE ${WORK}/few.inp "${sudden} functions, 1, 2\n channels, y_arm_end, m\n")
execute_process(COMMAND ${LIMBER} study ${WORK}/few.inp -o ${WORK}/few.h5 --force OUTPUT_VARIABLE report
  COMMAND_ERROR_IS_FATAL ANY)
if(NOT report MATCHES "no measure of the truth:\n  warning: beam 'arm' has too few functions" OR
    NOT report MATCHES "That run warns of the same as the reference")
  message(FATAL_ERROR "the reference of a study is not told to be wrong:\n${report}")
endif()
string(REPLACE "FORCE\n" "2*smoothstep(t/0.1)\n" slow "${arm}")
string(REPLACE ", m = bending_moment(arm.q)" "" slow "${slow}")
string(REPLACE "tolerances, 1e-3" "tolerances, 1e-5" slow "${slow}")
file(WRITE ${WORK}/slow.inp "${slow} functions, 6, 7\n channels, y_arm_end\n")
execute_process(COMMAND ${LIMBER} study ${WORK}/slow.inp -o ${WORK}/slow.h5 --force OUTPUT_VARIABLE report
  COMMAND_ERROR_IS_FATAL ANY)
# A tolerance is written as a deck would give it: a tenth of 1e-5 is not 1.0000000000000002e-6
if(NOT report MATCHES "Error of the functions, RADAU at 1e-[0-9]+:\n +functions +CPU ms")
  message(FATAL_ERROR "digits of a tolerance:\n${report}")
endif()
if(NOT report MATCHES "its run warns of none" OR report MATCHES "warning:")
  message(FATAL_ERROR "the reference of a study is told to be wrong, though it is right:\n${report}")
endif()
