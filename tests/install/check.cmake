# Installs the build, then builds and runs a consumer by find_package and another by pkg-config:
#   cmake -DBUILD= -DWORK= -DCOMPILER= -DCONFIG= -DGENERATOR= -DLIBDIR= -DVERSION= -P check.cmake
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(status)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\n${output}")
  endif()
  string(STRIP "${output}" output)
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(prefix "${WORK}/prefix with blank")
set(moved "${WORK}/moved")
file(REMOVE_RECURSE "${WORK}")
run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${prefix}" --config ${CONFIG})

run(${CMAKE_COMMAND} -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK}/build" -G "${GENERATOR}"
  "-DCMAKE_PREFIX_PATH=${prefix}"
  -DCMAKE_Fortran_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=${CONFIG})
run(${CMAKE_COMMAND} --build "${WORK}/build")
run("${WORK}/build/consumer")
if(NOT output STREQUAL "limber ${VERSION}")
  message(FATAL_ERROR "by find_package: '${output}'")
endif()

# The tree can be moved
file(RENAME "${prefix}" "${moved}")
set(ENV{PKG_CONFIG_PATH} "${moved}/${LIBDIR}/pkgconfig:$ENV{PKG_CONFIG_PATH}")
run(pkg-config --cflags --libs limber)
separate_arguments(options UNIX_COMMAND "${output}")
run(${COMPILER} "${CMAKE_CURRENT_LIST_DIR}/consumer.f90" -o "${WORK}/consumer" ${options})
run("${WORK}/consumer")
if(NOT output STREQUAL "limber ${VERSION}")
  message(FATAL_ERROR "by pkg-config: '${output}'")
endif()
if(EXISTS "${BUILD}/limber")
  run("${moved}/bin/limber" --version)
endif()
message("find_package and pkg-config both give limber ${VERSION}")
