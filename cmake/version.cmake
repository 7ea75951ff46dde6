# Writes the version module at every build; the file changes, and with it what uses it, only if its text does.
#   cmake -DSOURCE= -DTEMPLATE= -DOUTPUT= -DVERSION= -DOPTIONS= -P version.cmake
set(COMMIT unknown)
find_program(GIT git)
if(GIT AND EXISTS "${SOURCE}/.git")
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env GIT_OPTIONAL_LOCKS=0 ${GIT} describe --always --dirty
    WORKING_DIRECTORY "${SOURCE}" OUTPUT_VARIABLE described RESULT_VARIABLE failed
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT failed)
    set(COMMIT "${described}")
  endif()
endif()
# Fortran lines are short
string(REPLACE "'" "''" OPTIONS "${OPTIONS}")
string(REGEX REPLACE "([^ ]+ [^ ]+ )" "\\1'// &\n      & '" OPTIONS "${OPTIONS}")
configure_file("${TEMPLATE}" "${OUTPUT}" @ONLY)
