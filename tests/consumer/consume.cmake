# SPDX-License-Identifier: MIT
# cmake -P script: configures, builds and runs a user's project in WORK_DIR.
#   PROJECT_DIR, WORK_DIR, PREFIX     the project, where to build it, where limber is installed
#   CMAKE_ARGS                        list of further arguments of the configure step
#   PROGRAMS                          what to build and run
set(run COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE output ERROR_VARIABLE output ECHO_ERROR_VARIABLE
        ECHO_OUTPUT_VARIABLE)
file(REMOVE_RECURSE ${WORK_DIR})
execute_process(COMMAND ${CMAKE_COMMAND} -S ${PROJECT_DIR} -B ${WORK_DIR} -DCMAKE_PREFIX_PATH=${PREFIX}
                        ${CMAKE_ARGS} ${run})
execute_process(COMMAND ${CMAKE_COMMAND} --build ${WORK_DIR} --parallel 2 --target ${PROGRAMS} ${run})
foreach(program IN LISTS PROGRAMS)
  execute_process(COMMAND ${WORK_DIR}/${program} WORKING_DIRECTORY ${WORK_DIR} ${run})
endforeach()
