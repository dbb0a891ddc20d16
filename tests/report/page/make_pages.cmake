# SPDX-License-Identifier: MIT
# cmake -P script: makes what page_test.mjs looks at, as a user would.
#   LIMBER, SCENARIOS, OUT   the program, the folder of the shipped scenarios, where to put it all
set(run COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})
# Four seconds of the paper's cases (ii) and (v), so that a few methods are done in a blink.
foreach(name paper_ii paper_v)
  file(READ ${SCENARIOS}/${name}.yaml text)
  file(WRITE ${OUT}/${name}.yaml "duration: 4\n${text}")
endforeach()
execute_process(COMMAND ${LIMBER} simulate ${OUT}/paper_ii.yaml --seed 3 --out ${OUT}/recording ${run})
execute_process(COMMAND ${LIMBER} run ${OUT}/recording --method lcekf --init groundtruth --out ${OUT}/run ${run})
execute_process(COMMAND ${LIMBER} evaluate ${OUT}/run ${OUT}/recording --out ${OUT}/evaluation.json ${run})
execute_process(COMMAND ${LIMBER} run ${OUT}/recording --methods ekf,lcekf,adaptive --init groundtruth --out ${OUT}/methods ${run})
execute_process(COMMAND ${LIMBER} study ${OUT}/paper_ii.yaml ${OUT}/paper_v.yaml --methods ekf,ekf-full,lcekf,ekf-full:walk=x0.1,ekf-full:walk=x10
                        --runs 2 --init groundtruth
                        --export csv --out ${OUT}/study.sqlite ${run})
