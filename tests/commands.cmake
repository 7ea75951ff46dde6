# Each command with what it is given rightly and wrongly: status, and what it says.
# cmake -DLIMBER= -DWORK=<folder> -P commands.cmake
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(pendulum "*PARAMETER
 length = 1
*RIGID BODY, NAME=rod, MASS=1, INERTIA=0.1, CENTRE X=length/2
 tip, length, 0
*JOINT, NAME=pin, TYPE=REVOLUTE
 rod.origin, ground.origin
*GRAVITY
")
file(WRITE ${WORK}/pendulum.inp "${pendulum}*DYNAMICS, END=0.2, OUTPUTS=4\n*OUTPUT, MOTION=YES\n angle(rod), x(rod.tip)\n")
file(WRITE ${WORK}/still.inp "${pendulum}")
file(WRITE ${WORK}/warned.inp "*RIGID BODY, NAME=b, MASS=1, INERTIA=1, ANGLE=90\n*DYNAMICS, END=1\n*OUTPUT\n angle(b)\n")
file(WRITE ${WORK}/wrong.inp "*RIGID BODY, MASS=1\n")
file(WRITE ${WORK}/other.inp "${pendulum}*DYNAMICS, END=0.2, OUTPUTS=4\n*OUTPUT\n speed = spin(rod)\n")
file(WRITE ${WORK}/text.h5 "no HDF5")

# expect(<status> <what it says, a regular expression> <argument>...)
function(expect status says)
  execute_process(COMMAND ${LIMBER} ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE said
    ERROR_VARIABLE complained)
  if(NOT result EQUAL status)
    message(SEND_ERROR "limber ${ARGN}: status ${result} in place of ${status}\n${said}${complained}")
  elseif(NOT "${said}${complained}" MATCHES "${says}")
    message(SEND_ERROR "limber ${ARGN}: does not say '${says}'\n${said}${complained}")
  endif()
endfunction()

expect(0 "limber run DECK")
expect(0 "Status: 0 done" --help)
expect(0 "^limber [0-9.]+ \\(" --version)
expect(2 "there is no command 'rnu'" rnu)
expect(2 "there is no command 'sweeep'; did you mean 'sweep'" sweeep)
expect(2 "limber run: a file is missing" run)
expect(2 "'b.inp' is one file too many" run a.inp b.inp)
expect(2 "there is no option '--forse'; did you mean '--force'" run pendulum.inp --forse)
expect(2 "a value is missing behind -o" run pendulum.inp -o)
string(REPEAT x 5000 long)
expect(2 "an argument is longer" run ${long})

# Help
expect(0 "\\*BEAM" help)
expect(0 "A flexible beam" help beam)
expect(0 "limber help BEAM EXACT" help beam)
expect(0 "STRAIN FUNCTIONS   " help beam exact)
expect(0 "AXIAL BASIS   " help beam modes)
expect(0 "MASS" help *rigid body)
expect(0 "momentum_x" help output)
expect(0 "AXIAL BASIS is an option; see\n   limber help BEAM" help axial basis)
expect(2 "there is no keyword \\*BAEM; did you mean \\*BEAM" help baem)
expect(2 "there is no keyword \\*QQQQQQQQQQ" help qqqqqqqqqq)

# Runs
expect(2 "cannot|no such|not" run nothing.inp)
expect(2 "wrong.inp:1:1: error" check wrong.inp)
expect(2 "wrong.inp:1:1: error" run wrong.inp)
expect(2 "nothing to run" run still.inp)
expect(0 "1 joint, 0 drivers, 0 loads; 0 channels" check still.inp)
expect(0 "1 degree of freedom" check still.inp)
expect(0 "nothing vibrates: not stiff|5 samples in pendulum.h5" run pendulum.inp)
expect(2 "pendulum.h5 is there already|exists" run pendulum.inp)
expect(0 "^$" run pendulum.inp --force --quiet)
expect(0 "^warned.inp:1:[0-9]+: warning: .*\\^.*[^\n]\n$" run warned.inp --quiet)
expect(0 "samples in long.h5" run pendulum.inp --set length=2 -o long.h5)
expect(2 "the deck has no parameter 'lenght'" run pendulum.inp --set lenght=2 -o x.h5)
expect(2 "--set 'length' is not name=value" run pendulum.inp --set length)
expect(2 "--set 'length=1,2' is not name=value" run pendulum.inp --set length=1,2)
expect(0 "samples in turned.h5" run pendulum.inp --set length=pi/2 -o turned.h5)
expect(2 "--set .length=no. is not name=value" run pendulum.inp --set length=no)
expect(2 "nowhere" run pendulum.inp -o nowhere/x.h5)
expect(0 "samples in other.h5" run other.inp)

# All that acts on a beam has its responses beside the modes: couples one that bends, forces one that stretches besides
expect(0 "bar: mass [^\n]* 7 bending and 4 axial coordinates" check ${CMAKE_CURRENT_LIST_DIR}/decks/acting.inp)

# Nothing can move: no modes, said so, and the analysis behind them runs
foreach(held "*JOINT, NAME=wall, TYPE=WELD\n rod.origin, ground.origin\n" "*MOTION, NAME=wall, BODY=rod\n 0, 0, 0\n"
    "*ASSEMBLY, ELIMINATION=NO\n*MOTION, NAME=wall, BODY=rod\n 0, 0, 0\n")
  foreach(before "*MODES, NAME=free" "*MODES, NAME=free, DAMPED=YES" "*STATICS\n*MODES, NAME=free"
      "*STATICS, ROTATION=1\n*MODES, NAME=free")
    file(WRITE ${WORK}/held.inp "*RIGID BODY, NAME=rod, MASS=1, INERTIA=0.1\n tip, 1, 0\n${held}*GRAVITY\n*DYNAMICS, END=0.2,
  OUTPUTS=2\n${before}\n*DYNAMICS, END=2, OUTPUTS=2\n*OUTPUT\n x(rod.tip)\n")
    expect(0 "nothing can vibrate in .MODES 'free'.*DYNAMICS[^\n]*: t = [0-9.]+ to 2 s, 3 samples" run held.inp -o held.h5 --force)
  endforeach()
endforeach()

# A large scene with one free motion: 171 bars welded in a row on a hinge with a spring, sqrt(k/(171*0.1 + sum i^2))
file(WRITE ${WORK}/row.inp "*RIGID BODY, NAME=a0, MASS=1, INERTIA=0.1\n p, 1, 0
*JOINT, NAME=h, TYPE=REVOLUTE\n a0.origin, ground.origin
*SPRING, NAME=s, TYPE=ROTATIONAL, STIFFNESS=10\n a0.origin, ground.origin
*REPEAT, COUNT=170, INDEX=i\n*RIGID BODY, NAME=a<i>, MASS=1, INERTIA=0.1, X=i\n p, 1, 0
*JOINT, NAME=w<i>, TYPE=WELD\n a<i>.origin, a<i - 1>.p\n*END REPEAT\n*MODES, NUMBER=3\n*OUTPUT\n x(a1.p)\n")
expect(0 "         1    2\\.46021[89][0-9]E-03" run row.inp)

# Differences
expect(0 "." diff pendulum.h5 pendulum.h5)
expect(1 "angle" diff pendulum.h5 long.h5)
expect(0 "." diff pendulum.h5 long.h5 --rtol 10 --range 10 --atol 10)
expect(1 "." diff pendulum.h5 other.h5)
expect(2 "'much' is not a number" diff pendulum.h5 long.h5 --rtol much)
expect(2 "text.h5" diff pendulum.h5 text.h5)
expect(2 "nothing.h5" diff nothing.h5 pendulum.h5)
expect(2 "limber diff: a file is missing" diff pendulum.h5)

# Columns
expect(0 "# time \\[s\\].*angle" export pendulum.h5)
expect(0 "x_rod_tip" export pendulum.h5 x_rod_tip)
expect(2 "nothing" export pendulum.h5 nothing)
expect(2 "text.h5" export text.h5)
expect(2 "nothing.h5" export nothing.h5)

# Drawings
expect(0 "." export pendulum.h5 --motion)
expect(0 "." export pendulum.h5 --motion --sample 2)
expect(0 "." export pendulum.h5 --motion --time 0.1 --deflection 10)
expect(0 "." export pendulum.h5 --motion --samples 3 --path rod.tip)
expect(2 "." export pendulum.h5 --motion --path rod.nothing)
expect(2 "." export pendulum.h5 --motion --sample 99)
expect(2 "'-1' is not a whole number" export pendulum.h5 --motion --sample -1)
expect(2 "MOTION" export other.h5 --motion)
expect(2 "'angle' is one file too many" export pendulum.h5 --motion angle)

# Sweeps
expect(2 "nothing is swept" sweep pendulum.inp)
expect(2 "--set 'length' is not name=value,value" sweep pendulum.inp --set length)
expect(2 "--part '3/2' is not K/N" sweep pendulum.inp --set length=1:2:3 --part 3/2)
expect(2 "--part 'x' is not K/N" sweep pendulum.inp --set length=1:2:3 --part x)
expect(2 "the deck has no parameter 'width'" sweep pendulum.inp --set width=1:2:3)
expect(2 "is not a whole number" sweep pendulum.inp --set length=1:2:3 --jobs many)
expect(2 "nothing.inp" sweep nothing.inp --set length=1,2)
expect(0 "." sweep pendulum.inp --set length=1:2:3 --jobs 2 --keep)
expect(0 "." sweep pendulum.inp --set length=1:2:3)
expect(0 "^$" sweep pendulum.inp --set length=1,2 -o two.h5 --quiet)
expect(0 "." sweep pendulum.inp --set length=1:2:3 -o parts.h5 --part 1/2)
expect(0 "." sweep pendulum.inp --set length=1:2:3 -o parts.h5 --part 2/2)
expect(0 "." sweep pendulum.inp --set length=1:2:3 -o parts.h5 --collect)

# Parts as schedulers tell them: two of three rows, then the third
function(expect_parts name)
  foreach(part 0 1)
    foreach(setting IN LISTS ARGN)
      string(REPLACE "<part>" ${part} setting "${setting}")
      string(REPLACE "=" ";" setting "${setting}")
      list(GET setting 0 variable)
      list(GET setting 1 value)
      set(ENV{${variable}} ${value})
    endforeach()
    expect(0 "." sweep pendulum.inp --set length=1:2:3 -o ${name}.h5 --part auto)
    if(part EQUAL 0)
      expect(3 "3 rows: 2 ok, 1 missing" sweep pendulum.inp --set length=1:2:3 -o ${name}.h5 --collect)
    endif()
  endforeach()
  expect(0 "3 rows: 3 ok" sweep pendulum.inp --set length=1:2:3 -o ${name}.h5 --collect)
  foreach(setting IN LISTS ARGN)
    string(REGEX REPLACE "=.*" "" variable "${setting}")
    unset(ENV{${variable}})
  endforeach()
endfunction()
foreach(variable SLURM_ARRAY_TASK_COUNT OMPI_COMM_WORLD_SIZE PMI_SIZE SLURM_NTASKS)
  unset(ENV{${variable}})
endforeach()
expect_parts(array SLURM_ARRAY_TASK_COUNT=2 SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_STEP=1 SLURM_ARRAY_TASK_ID=<part>)
expect_parts(ranks OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=<part>)
expect_parts(pmi PMI_SIZE=2 PMI_RANK=<part>)
expect_parts(tasks SLURM_NTASKS=2 SLURM_PROCID=<part>)
expect(0 "3 rows: 3 ok" sweep pendulum.inp --set length=1:2:3 -o alone.h5 --part auto)

# Advice and studies
expect(0 "." advise pendulum.inp)
expect(0 "." advise pendulum.inp --all --target 1e-2 --write advised.inp)
expect(2 "advised.inp" advise pendulum.inp --write advised.inp)
expect(0 "." advise pendulum.inp --write advised.inp --force)
expect(2 "nothing.inp" advise nothing.inp)
expect(2 "wrong.inp:1:1" advise wrong.inp)
expect(2 "'little' is not a number" advise pendulum.inp --target little)
expect(2 "nothing.inp" study nothing.inp)
expect(2 "." study still.inp)

# A study without a reference, with columns of another program, and with what is none
string(REPLACE "*OUTPUT" "*OUTPUT\n x(rod.tip)\n*OUTPUT" with_tip "${pendulum}*DYNAMICS, END=0.2, OUTPUTS=4\n*OUTPUT\n angle(rod)\n")
set(lists " integrators, RADAU, ALPHA\n tolerances, 1e-3, 1e-4\n")
file(WRITE ${WORK}/study.inp "${with_tip}*STUDY, REPEATS=1\n${lists}")
expect(0 "agrees to.*ALPHA +1e-4.*The table of the runs is in study.h5" study study.inp)
expect(2 "study.h5" study study.inp)
expect(0 "^$" study study.inp --force --quiet)
file(WRITE ${WORK}/steps.inp "${with_tip}*STUDY, REPEATS=1\n integrators, CONSERVING\n steps, 0.02, 0.01\n")
expect(0 "CONSERVING +0.01" study steps.inp -o steps.h5)
function(expect_reference status says columns)
  file(WRITE ${WORK}/reference.csv "${columns}")
  file(WRITE ${WORK}/given.inp "${with_tip}*STUDY, REPEATS=1, REFERENCE=reference.csv\n${lists} channels, angle_rod\n")
  expect(${status} "${says}" study given.inp -o given.h5 --force)
endfunction()
expect_reference(0 "Reference: .*reference.csv\nErrors are" "# made by hand\ntime, other, angle_rod\n0, 1, 0\n0.05, 1, -0.017518\n0.1, 1, -0.07006\n0.15, 1, -0.15753\n0.2, 1, -0.27955\n")
expect_reference(2 "2 samples are too few" "t, angle_rod\n0, 0\n0.2, -0.27955\n")
expect_reference(2 "there is no column 'angle_rod'; name the channels" "time, other\n0, 1\n")
expect_reference(2 "there is no column 'time'" "angle_rod\n0\n")
expect_reference(2 "row 2 has no 2 numbers" "t, angle_rod\n0, 0\n0.1, much\n")
expect_reference(2 "." "t, angle_rod\n")
file(REMOVE ${WORK}/reference.csv)
expect(2 "reference.csv" study given.inp -o given.h5 --force)
# Lists that no study can be made of
function(expect_study says lists)
  file(WRITE ${WORK}/lists.inp "${with_tip}*STUDY, REPEATS=1\n${lists}")
  expect(2 "lists.inp:[0-9]+:[0-9]+: error: [^\n]*${says}" study lists.inp -o lists.h5)
endfunction()
expect_study("has no list 'integraters'" " integraters, RADAU\n")
expect_study("." " integrators, RUDAU\n")
expect_study("." " tolerances, 0\n")
expect_study("." " modes, 2\n")
expect_study("." " channels, nothing\n")
file(WRITE ${WORK}/hurried.inp "${with_tip}*STUDY, REPEATS=1, LIMIT=1e-9\n${lists}")
expect(3 "no reference: it takes two integrators that finish.*RADAU: given up after" study hurried.inp -o hurried.h5)
