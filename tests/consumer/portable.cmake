# SPDX-License-Identifier: MIT
# cmake -P script: who names no processor gets code for any.
#   SOURCE_DIR, WORK_DIR, GENERATOR   limber, where to configure it, how
function(expect_march expected)
  file(REMOVE_RECURSE ${WORK_DIR})
  execute_process(
    COMMAND
      ${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${WORK_DIR} -G ${GENERATOR} -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
      -DLIMBER_BUILD_DATASETS=OFF -DLIMBER_BUILD_FRONTEND=OFF -DLIMBER_BUILD_TESTS=OFF ${ARGN}
    COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
  file(READ ${WORK_DIR}/compile_commands.json commands)
  string(REGEX MATCHALL "-march=[^ ]*" found "${commands}")
  list(REMOVE_DUPLICATES found)
  if(NOT found STREQUAL expected)
    message(FATAL_ERROR "compiled with '${found}' where '${expected}' was expected (${ARGN})")
  endif()
endfunction()

expect_march("")
expect_march("-march=x86-64-v2" -DLIMBER_ARCH=x86-64-v2)
