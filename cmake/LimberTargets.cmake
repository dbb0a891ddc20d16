# SPDX-License-Identifier: MIT
# Flags that every target of the project shares.

# limber_add_library(<room> <sources>...): the static library limber_<room>, alias limber::<room>.
function(limber_add_library room)
  add_library(limber_${room} STATIC ${ARGN})
  add_library(limber::${room} ALIAS limber_${room})
  set_target_properties(limber_${room} PROPERTIES EXPORT_NAME ${room} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(
    limber_${room} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                          $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(limber_${room} PUBLIC cxx_std_20)
  # A library built with AVX and a caller built without must agree on how Eigen aligns its types.
  target_compile_definitions(limber_${room} PUBLIC EIGEN_MAX_ALIGN_BYTES=32)
  limber_set_flags(limber_${room})
endfunction()

function(limber_set_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow)
  if(LIMBER_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(LIMBER_NATIVE)
    target_compile_options(${target} PRIVATE -march=native)
  endif()
endfunction()
