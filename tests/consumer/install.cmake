# SPDX-License-Identifier: MIT
# cmake -P script: installs BUILD_DIR into PREFIX and checks that the copy stands on its own.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${PREFIX} OUTPUT_QUIET
                        COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE package_files ${PREFIX}/*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "No package file is installed in ${PREFIX}")
endif()
foreach(file IN LISTS package_files)
  file(READ ${file} text)
  foreach(tree ${SOURCE_DIR} ${BUILD_DIR})
    string(FIND "${text}" "${tree}" position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${file} names ${tree}: the installed copy would need it")
    endif()
  endforeach()
endforeach()
