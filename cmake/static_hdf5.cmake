# HDF5 inside the program. Debian's shared library brings those of curl, TLS, LDAP and Kerberos: half of the time of a short run went
# to load them. Sets LIMBER_STATIC_HDF5_LIBRARIES, empty where there are no archives, or they need more than is here. In
# Release alone: sanitizers tell leaks of HDF5 by its shared library.
set(LIMBER_STATIC_HDF5_LIBRARIES "")
set(archives "")
foreach(library IN LISTS HDF5_Fortran_HL_LIBRARIES HDF5_Fortran_LIBRARIES)
  string(REGEX REPLACE "\\.so$" ".a" archive "${library}")
  if(library MATCHES "/libhdf5[^/]*\\.so$" AND EXISTS "${archive}")
    list(APPEND archives ${archive})
  endif()
endforeach()
list(REMOVE_DUPLICATES archives)
if(archives AND CMAKE_BUILD_TYPE STREQUAL "Release")
  file(WRITE ${PROJECT_BINARY_DIR}/static_hdf5.f90
    "program check\n use hdf5, only: h5open_f\n use h5lt, only: h5ltpath_valid_f\n integer :: status\n logical :: valid\n"
    " call h5open_f(status)\n call h5ltpath_valid_f(0_8, 'a', .false., valid, status)\nend program check\n")
  try_compile(LIMBER_LINKS_STATIC_HDF5 ${PROJECT_BINARY_DIR}/static_hdf5
    SOURCES ${PROJECT_BINARY_DIR}/static_hdf5.f90 ${PROJECT_SOURCE_DIR}/cmake/no_network.c
    CMAKE_FLAGS "-DINCLUDE_DIRECTORIES=${HDF5_Fortran_INCLUDE_DIRS}"
    LINK_OPTIONS LINKER:--as-needed
    LINK_LIBRARIES ${archives} ${HDF5_Fortran_LIBRARIES})
  if(LIMBER_LINKS_STATIC_HDF5)
    set(LIMBER_STATIC_HDF5_LIBRARIES ${archives})
  endif()
endif()
