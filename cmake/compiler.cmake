# Compiler options of every target, tests included.
#
# Results must be repeatable: no -ffast-math and nothing that it stands for, so that sums keep the order in which they
# are written. -ffp-contract=off also keeps products and sums apart on processors with fused multiply-add, so that
# portable builds agree with each other; LIMBER_NATIVE gives that up for speed.

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release or Debug" FORCE)
endif()

if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
  set(CMAKE_Fortran_FLAGS_RELEASE "-O3")
  set(CMAKE_Fortran_FLAGS_DEBUG "-Og -g")
  # -Wmaybe-uninitialized cries wolf at allocatable temporaries when optimising; the debug build stops at the real thing
  add_compile_options(
    "$<$<COMPILE_LANGUAGE:Fortran>:-std=f2008;-Wall;-Wextra;-Wimplicit-interface;-Wno-maybe-uninitialized>")
  add_compile_options("$<$<AND:$<COMPILE_LANGUAGE:Fortran>,$<CONFIG:Debug>>:-fcheck=all;-fbacktrace>")
  if(LIMBER_NATIVE)
    add_compile_options("$<$<COMPILE_LANGUAGE:Fortran>:-march=native>")
  else()
    add_compile_options("$<$<COMPILE_LANGUAGE:Fortran>:-ffp-contract=off>")
  endif()
  if(LIMBER_WARNINGS_AS_ERRORS)
    add_compile_options("$<$<COMPILE_LANGUAGE:Fortran>:-Werror>")
  endif()
  if(LIMBER_SANITIZE)
    add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
    add_link_options(-fsanitize=address,undefined)
  elseif(LIMBER_COVERAGE)
    add_compile_options(--coverage -O0)
    add_link_options(--coverage)
  else()
    # Signalling NaNs in what was never set, and a stop where the first NaN or infinity is made
    add_compile_options("$<$<AND:$<COMPILE_LANGUAGE:Fortran>,$<CONFIG:Debug>>:-ffpe-trap=invalid,zero,overflow;-finit-real=snan>")
  endif()
endif()
