# SPDX-License-Identifier: MIT
# The page of the reports: HTML, style, script and Plotly.js (npm, pinned by package-lock.json) become one C++ source.
# The same for the live view, with three.js.
#
# limber_add_report_page(<target>): adds that source to the target, or, without LIMBER_WITH_REPORT or npm, one that
# says that there is no page. Sets LIMBER_HAS_REPORT_PAGE, and LIMBER_REPORT_NPM to the folder with node_modules, which
# the target limber_npm fills.
function(limber_add_report_page target)
  set(page ${PROJECT_SOURCE_DIR}/src/report/page)
  find_program(LIMBER_NODE NAMES node nodejs)
  find_program(LIMBER_NPM npm)
  mark_as_advanced(LIMBER_NODE LIMBER_NPM)
  set(has_page OFF)
  if(LIMBER_WITH_REPORT AND LIMBER_NODE AND LIMBER_NPM)
    set(has_page ON)
  elseif(LIMBER_WITH_REPORT)
    message(WARNING "npm or node was not found: report.html is left out of this build. Install nodejs and npm "
                    "(scripts/install_dependencies.sh does), or say -DLIMBER_WITH_REPORT=OFF.")
  endif()
  set(LIMBER_HAS_REPORT_PAGE ${has_page} CACHE INTERNAL "Whether reports can be written")
  if(NOT has_page)
    target_sources(${target} PRIVATE no_page_template.cpp)
    return()
  endif()

  # npm works on copies, so that nothing is written beside the sources. --ignore-scripts: nothing of others runs.
  set(npm_dir ${CMAKE_CURRENT_BINARY_DIR}/npm)
  set(LIMBER_REPORT_NPM ${npm_dir} CACHE INTERNAL "Folder with node_modules")
  set(plotly ${npm_dir}/node_modules/plotly.js-gl3d-dist-min/plotly-gl3d.min.js)
  set(fetched ${plotly} ${npm_dir}/node_modules/three/package.json ${npm_dir}/node_modules/esbuild/package.json)
  if(LIMBER_BUILD_TESTS)
    list(APPEND fetched ${npm_dir}/node_modules/playwright-core/package.json)
  else()
    set(omit --omit=dev)
  endif()
  add_custom_command(
    OUTPUT ${fetched}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${npm_dir}
    COMMAND ${CMAKE_COMMAND} -E copy ${page}/package.json ${page}/package-lock.json ${npm_dir}
    COMMAND ${CMAKE_COMMAND} -DNPM=${LIMBER_NPM} -DOMIT=${omit} -P ${PROJECT_SOURCE_DIR}/cmake/npm_ci.cmake
    COMMAND ${CMAKE_COMMAND} -E touch ${fetched}
    WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}
    DEPENDS ${page}/package.json ${page}/package-lock.json ${PROJECT_SOURCE_DIR}/cmake/npm_ci.cmake
    COMMENT "Fetching Plotly.js and three.js (npm ci)"
    VERBATIM)
  add_custom_target(limber_npm DEPENDS ${fetched})

  set(parts page.html page.css style.js plot.js figure.js page.js build_template.mjs cpp_literals.mjs)
  list(TRANSFORM parts PREPEND ${page}/)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/page_template.cpp)
  add_custom_command(
    OUTPUT ${generated}
    COMMAND ${LIMBER_NODE} ${page}/build_template.mjs ${page} ${plotly} ${generated}
    DEPENDS ${plotly} ${parts}
    COMMENT "Putting the report page together"
    VERBATIM)
  limber_long_strings(${generated})
  target_sources(${target} PRIVATE ${generated})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
endfunction()

# limber_long_strings(<source>): one whose literals hold a page.
function(limber_long_strings source)
  set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS -Wno-overlength-strings SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# limber_add_view_page(<target>): adds the live view's page to the target. Needs LIMBER_HAS_REPORT_PAGE.
function(limber_add_view_page target)
  set(report_page ${PROJECT_SOURCE_DIR}/src/report/page)
  set(page ${PROJECT_SOURCE_DIR}/src/view/page)
  file(GLOB parts CONFIGURE_DEPENDS ${page}/*)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/page_template.cpp)
  add_custom_command(
    OUTPUT ${generated}
    COMMAND ${LIMBER_NODE} ${page}/build_template.mjs ${page} ${report_page} ${LIMBER_REPORT_NPM} ${generated}
    DEPENDS limber_npm ${parts} ${report_page}/page.css ${report_page}/cpp_literals.mjs
    COMMENT "Putting the live view's page together"
    VERBATIM)
  limber_long_strings(${generated})
  target_sources(${target} PRIVATE ${generated})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
endfunction()
