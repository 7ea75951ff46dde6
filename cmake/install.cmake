# `cmake --install`: program, libraries, header, module files, Python package, CMake package and pkg-config files.
include(CMakePackageConfigHelpers)
set(LIMBER_MODULES ${CMAKE_INSTALL_INCLUDEDIR}/limber)
set(LIMBER_PACKAGE ${CMAKE_INSTALL_LIBDIR}/cmake/limber)

install(TARGETS limber EXPORT limber
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} INCLUDES DESTINATION ${LIMBER_MODULES})
if(TARGET limber_exe)
  install(TARGETS limber_exe RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY ${PROJECT_BINARY_DIR}/src/modules/ DESTINATION ${LIMBER_MODULES} FILES_MATCHING PATTERN "*.mod")
install(TARGETS limber_shared EXPORT limber-c
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES ${PROJECT_SOURCE_DIR}/include/limber.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
# It finds the library above its folder, or where the system looks
install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/limber DESTINATION lib/python3/dist-packages FILES_MATCHING PATTERN "*.py")
install(EXPORT limber-c NAMESPACE limber:: FILE limber-c-targets.cmake DESTINATION ${LIMBER_PACKAGE})
install(EXPORT limber NAMESPACE limber:: FILE limber-targets.cmake DESTINATION ${LIMBER_PACKAGE})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/limber-config.cmake.in
  ${PROJECT_BINARY_DIR}/limber-config.cmake INSTALL_DESTINATION ${LIMBER_PACKAGE})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/limber-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/limber-config.cmake
  ${PROJECT_BINARY_DIR}/limber-config-version.cmake
  ${PROJECT_SOURCE_DIR}/cmake/dependencies.cmake
  DESTINATION ${LIMBER_PACKAGE})

# For pkg-config: the prefix follows from the place of the file, so that the tree can be moved.
file(RELATIVE_PATH LIMBER_PREFIX_FROM_PC
  ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" LIMBER_PREFIX_FROM_PC "${LIMBER_PREFIX_FROM_PC}")
set(LIMBER_PC_LIBRARIES "")
foreach(library IN LISTS HDF5_Fortran_HL_LIBRARIES HDF5_Fortran_LIBRARIES LAPACK_LIBRARIES LIMBER_KLU_LIBRARY)
  string(APPEND LIMBER_PC_LIBRARIES " ${library}")
endforeach()
foreach(name limber limber-fortran)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
