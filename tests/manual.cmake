# doc/keywords.md equals `limber help --manual`: cmake -DLIMBER= -DMANUAL= -P manual.cmake
execute_process(COMMAND ${LIMBER} help --manual OUTPUT_VARIABLE printed COMMAND_ERROR_IS_FATAL ANY)
file(READ ${MANUAL} stored)
if(NOT printed STREQUAL stored)
  message(FATAL_ERROR "${MANUAL} is out of date; remake it: limber help --manual >doc/keywords.md")
endif()
