# The libraries that limber stands on; used by the build and, installed, by find_package(limber).
find_package(LAPACK REQUIRED)
find_package(PkgConfig REQUIRED)
if(NOT TARGET PkgConfig::ARPACK)
  pkg_check_modules(ARPACK REQUIRED QUIET IMPORTED_TARGET arpack)
endif()

if(NOT TARGET limber::klu)
  find_library(LIMBER_KLU_LIBRARY klu REQUIRED)
  add_library(limber::klu INTERFACE IMPORTED)
  target_link_libraries(limber::klu INTERFACE ${LIMBER_KLU_LIBRARY})
endif()

find_package(HDF5 REQUIRED COMPONENTS Fortran Fortran_HL)

if(NOT TARGET limber::hdf5)
  add_library(limber::hdf5 INTERFACE IMPORTED)
  target_include_directories(limber::hdf5 INTERFACE ${HDF5_Fortran_INCLUDE_DIRS})
  target_link_libraries(limber::hdf5 INTERFACE ${HDF5_Fortran_HL_LIBRARIES} ${HDF5_Fortran_LIBRARIES})
endif()
