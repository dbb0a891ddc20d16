# SPDX-License-Identifier: MIT
# What makes a clean build short; docs/evidence/build-times.md has the times. Nothing here changes what is built, and
# LIMBER_FAST_COMPILE=OFF (preset dev) shows that each file compiles alone.

# limber_compile_together(<target> <files>): compiles that many sources at a time, whose headers are then read once.
# Names in anonymous namespaces must not clash within a folder. A group must stay below a minute of one core.
function(limber_compile_together target files)
  if(LIMBER_FAST_COMPILE)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${files})
  endif()
endfunction()

# limber_precompile(<target> <headers>...): headers of the system and of other projects, none of include/, so that no change
# of ours compiles them anew and all checkouts share them in a compiler cache.
function(limber_precompile target)
  if(LIMBER_FAST_COMPILE)
    target_precompile_headers(${target} PRIVATE ${ARGN})
    limber_let_cache_precompiled(${target})
  endif()
endfunction()

# limber_share_precompiled(<target> <from>): uses the headers precompiled for another target with the same flags.
function(limber_share_precompiled target from)
  if(LIMBER_FAST_COMPILE)
    target_precompile_headers(${target} REUSE_FROM ${from})
    limber_let_cache_precompiled(${target})
  endif()
endfunction()

# limber_let_cache_precompiled(<target>): what ccache asks for. Without it Clang refuses a header that was precompiled in
# another checkout, since it is of another time.
function(limber_let_cache_precompiled target)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fpch-preprocess)
  elseif(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    target_compile_options(${target} PRIVATE "SHELL:-Xclang -fno-pch-timestamp")
  endif()
endfunction()

set(limber_std_headers <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <optional>
                       <span> <stdexcept> <string> <string_view> <unordered_map> <utility> <variant> <vector>)
set(limber_eigen_expressions ${CMAKE_CURRENT_LIST_DIR}/eigen_expressions.hpp)
set(limber_eigen_headers ${limber_eigen_expressions} <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry>
                         <Eigen/LU> <Eigen/QR> <Eigen/SVD>)

# limber_add_headers(<target> <libraries>...): nothing but a place for precompiled headers that other targets share.
function(limber_add_headers target)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp "")
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp)
  target_link_libraries(${target} PRIVATE ${ARGN})
  limber_set_flags(${target})
endfunction()
