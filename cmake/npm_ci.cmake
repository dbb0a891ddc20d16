# SPDX-License-Identifier: MIT
# cmake -P script: `npm ci` in the folder npm/ below, with a message that says what to do if it fails.
#   NPM    the program
#   OMIT   a further argument, or nothing
execute_process(
  COMMAND ${NPM} ci ${OMIT} --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error
  WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/npm
  RESULT_VARIABLE result
  OUTPUT_VARIABLE output
  ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${output}\n'npm ci' failed. It fetches Plotly.js for report.html from the npm registry once. "
                      "Without a network, configure with -DLIMBER_WITH_REPORT=OFF: everything else works.")
endif()
