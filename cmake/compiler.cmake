# Compiler options of every target, tests included.
#
# Results must be repeatable: no -ffast-math and nothing that it stands for, so that sums keep the order in which they
# are written. -ffp-contract=off also keeps products and sums apart on processors with fused multiply-add, so that
# portable builds agree with each other; LIMBER_NATIVE gives that up for speed.

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release or Debug" FORCE)
endif()

set(LIMBER_FORTRAN_WARNINGS "") # what the compiler says
set(LIMBER_FORTRAN_CODE "")     # what it makes
if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
  set(CMAKE_Fortran_FLAGS_RELEASE "-O3")
  set(CMAKE_Fortran_FLAGS_DEBUG "-Og -g")

  list(APPEND LIMBER_FORTRAN_WARNINGS -std=f2008 -Wall -Wextra -Wimplicit-interface)
  if(LIMBER_WARNINGS_AS_ERRORS)
    list(APPEND LIMBER_FORTRAN_WARNINGS -Werror)
  endif()

  if(LIMBER_NATIVE)
    list(APPEND LIMBER_FORTRAN_CODE -march=native)
  else()
    list(APPEND LIMBER_FORTRAN_CODE -ffp-contract=off)
  endif()
  # The small kernels of src/multibody are inlined across files; the library keeps ordinary code too, for those without -flto
  if(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT LIMBER_SANITIZE AND NOT LIMBER_COVERAGE)
    list(APPEND LIMBER_FORTRAN_CODE -flto=auto -ffat-lto-objects)
  endif()
  if(CMAKE_BUILD_TYPE STREQUAL "Debug")
    # All but the notes that a temporary copy is made: thousands a second, and no error
    list(APPEND LIMBER_FORTRAN_CODE -fcheck=all,no-array-temps -fbacktrace)
  else()
    # Without it gfortran goes on where there was no memory for a local array or what is assigned, and crashes: `allocate` alone asks
    list(APPEND LIMBER_FORTRAN_CODE -fcheck=mem)
  endif()
  if(LIMBER_SANITIZE)
    # Undefined behaviour traps, and the trace says where: half the time to compile, a quarter of the code. Places of variables,
    # for a debugger, take as long again
    # No traps of integer overflows: gfortran 12 multiplies the bounds of arrays that are not allocated, whatever they are, before it
    # looks whether they are. No traps of pointers and sizes of objects before each access: the address sanitizer and -fcheck find the
    # same, and these took half the time to compile
    list(APPEND LIMBER_FORTRAN_CODE -fsanitize=address,undefined -fno-sanitize=signed-integer-overflow
      -fno-sanitize=null,alignment,object-size,pointer-overflow -fno-sanitize-recover=all -fsanitize-undefined-trap-on-error
      -fno-omit-frame-pointer -fno-var-tracking)
    add_link_options(-fsanitize=address,undefined)
  elseif(LIMBER_COVERAGE)
    # With the optimisation of the preset one line in twenty is merged with another; without it the tests take three times as long
    list(APPEND LIMBER_FORTRAN_CODE --coverage)
    add_link_options(--coverage)
  endif()
  if(CMAKE_BUILD_TYPE STREQUAL "Debug" AND NOT LIMBER_COVERAGE)
    # Signalling NaNs in what was never set, and a stop where the first NaN or infinity is made
    list(APPEND LIMBER_FORTRAN_CODE -ffpe-trap=invalid,zero,overflow -finit-real=snan)
  endif()
endif()
add_compile_options("$<$<COMPILE_LANGUAGE:Fortran>:${LIMBER_FORTRAN_WARNINGS};${LIMBER_FORTRAN_CODE}>")

# For the version module: the options that may change results, without the folders of the build
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
list(JOIN LIMBER_FORTRAN_CODE " " LIMBER_COMPILER_OPTIONS)
string(STRIP "${CMAKE_Fortran_FLAGS} ${CMAKE_Fortran_FLAGS_${build_type}} ${LIMBER_COMPILER_OPTIONS}" LIMBER_COMPILER_OPTIONS)
