# SPDX-License-Identifier: MIT
# cmake -P script: makes what live_page_test.mjs runs: two seconds of rendered images.
#   LIMBER, SCENARIOS, OUT   the program, the folder of the shipped scenarios, where to put it all
set(run COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})
file(READ ${SCENARIOS}/drone_none.yaml text)
string(REGEX REPLACE "(^|\n)duration:[^\n]*" "" text "${text}")
file(WRITE ${OUT}/short.yaml "duration: 2\n${text}")
execute_process(COMMAND ${LIMBER} simulate ${OUT}/short.yaml --seed 3 --images --out ${OUT}/images ${run})
