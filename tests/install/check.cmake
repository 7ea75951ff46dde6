# Installs the build; builds the examples in C and Fortran by find_package and by pkg-config, and runs them with a deck; imports the
# Python package:
#   cmake -DBUILD= -DWORK= -DCOMPILER= -DC_COMPILER= -DCONFIG= -DGENERATOR= -DLIBDIR= -DVERSION= -DPYTHON= -P check.cmake
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(status)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\n${output}")
  endif()
  string(STRIP "${output}" output)
  set(output "${output}" PARENT_SCOPE)
endfunction()

get_filename_component(root "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
set(examples "${root}/examples/library")
set(deck "${root}/input/pendulum.inp")

# The example steps the pendulum to its end and prints x there; tests/library/examples.cmake compares it with the program
function(expect_motion program)
  run(${program} "${deck}")
  if(NOT output MATCHES "t = 10[.0]* s: x[^\n]*= 0?[.]2750[0-9]*( m)?$")
    message(FATAL_ERROR "${program}: '${output}'")
  endif()
endfunction()

set(prefix "${WORK}/prefix with blank")
set(moved "${WORK}/moved")
file(REMOVE_RECURSE "${WORK}")
run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${prefix}" --config ${CONFIG})

# Without optimisation across files, which takes half a minute for each program
set(quick -DCMAKE_EXE_LINKER_FLAGS=-fno-lto)
run(${CMAKE_COMMAND} -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK}/build" -G "${GENERATOR}"
  "-DCMAKE_PREFIX_PATH=${prefix}" "-DEXAMPLES=${examples}"
  -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_Fortran_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=${CONFIG} ${quick})
run(${CMAKE_COMMAND} --build "${WORK}/build")
expect_motion("${WORK}/build/consumer_c")
expect_motion("${WORK}/build/consumer_fortran")

# The tree can be moved
file(RENAME "${prefix}" "${moved}")
set(ENV{PKG_CONFIG_PATH} "${moved}/${LIBDIR}/pkgconfig:$ENV{PKG_CONFIG_PATH}")
run(pkg-config --cflags --libs limber-fortran)
separate_arguments(options UNIX_COMMAND "${output}")
run(${COMPILER} "${examples}/pendulum.f90" -o "${WORK}/by_pkg_config_fortran" -fno-lto ${options})
expect_motion("${WORK}/by_pkg_config_fortran")
run(pkg-config --cflags --libs limber)
separate_arguments(options UNIX_COMMAND "${output}")
run(${C_COMPILER} "${examples}/pendulum.c" -o "${WORK}/by_pkg_config_c" ${options})
set(ENV{LD_LIBRARY_PATH} "${moved}/${LIBDIR}")
expect_motion("${WORK}/by_pkg_config_c")
unset(ENV{LD_LIBRARY_PATH})
run(pkg-config --modversion limber)
if(NOT output STREQUAL VERSION)
  message(FATAL_ERROR "version by pkg-config: '${output}'")
endif()
if(EXISTS "${BUILD}/limber")
  run("${moved}/bin/limber" --version)
endif()
if(PYTHON)
  set(ENV{PYTHONPATH} "${moved}/lib/python3/dist-packages")
  run(${PYTHON} -B -c "print(float(__import__('limber').run('${deck}')['x'][-1]))")
  if(NOT output MATCHES "^0[.]2750[0-9]*$")
    message(FATAL_ERROR "by Python: '${output}'")
  endif()
endif()
message("find_package, pkg-config and Python give the motion of the pendulum")
