# SPDX-License-Identifier: MIT
# Flags that every target of the project shares.

# limber_add_library(<component> <sources>...): the static library limber_<component>, alias limber::<component>.
# It is installed with the headers of include/limber/<component>/; see LimberInstall.cmake.
function(limber_add_library component)
  add_library(limber_${component} STATIC ${ARGN})
  add_library(limber::${component} ALIAS limber_${component})
  set_target_properties(limber_${component} PROPERTIES EXPORT_NAME ${component} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(
    limber_${component} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                               $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(limber_${component} PUBLIC cxx_std_20)
  if(LIMBER_ARCH)
    # Public: library and caller must agree on how Eigen aligns its types, which depends on the processor.
    target_compile_options(limber_${component} PUBLIC -march=${LIMBER_ARCH})
  endif()
  limber_set_flags(limber_${component})
  set_property(GLOBAL APPEND PROPERTY LIMBER_COMPONENTS ${component})
endfunction()

function(limber_set_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 sees ghosts in Eigen and std::string (GCC bugs 105593, 105651); the sanitizers look for real ones.
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -Wno-array-bounds -Wno-restrict)
  endif()
  if(LIMBER_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# Where little is worth optimising: files, words and pages. A quarter to a third of the time to compile.
function(limber_optimize_little target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# Eigen without optimisation is fifty times slower: nobody should get that by saying nothing.
function(limber_default_build_type type)
  get_property(is_multi_config GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
  if(NOT is_multi_config AND NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE ${type} CACHE STRING "Debug, Release or RelWithDebInfo" FORCE)
  endif()
endfunction()

# How compilers are started: by ccache, if there is one, and with large pages of memory for what glibc (2.35 or later)
# gives them, which takes an eighth of Clang's time away.
function(limber_launch_compilers)
  find_program(LIMBER_CCACHE ccache)
  mark_as_advanced(LIMBER_CCACHE)
  if(DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
    return()
  endif()
  set(environment "")
  if(NOT DEFINED ENV{GLIBC_TUNABLES})
    list(APPEND environment GLIBC_TUNABLES=glibc.malloc.hugetlb=1)
  endif()
  if(LIMBER_CCACHE)
    # The sloppiness lets ccache cache what is compiled with precompiled headers.
    list(APPEND environment CCACHE_SLOPPINESS=pch_defines,time_macros ${LIMBER_CCACHE})
  endif()
  if(environment)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env ${environment} CACHE STRING "Compiler launcher")
  endif()
endfunction()

# Clang's linker, where Clang compiles and it is there: a fifth of the time of the other one.
function(limber_use_fast_linker)
  find_program(LIMBER_LLD ld.lld)
  mark_as_advanced(LIMBER_LLD)
  if(LIMBER_LLD AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    add_link_options(-fuse-ld=lld)
  endif()
endfunction()
