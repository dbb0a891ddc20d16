# SPDX-License-Identifier: MIT
# Installs libraries, headers, the program and the package files behind
#   find_package(limber REQUIRED COMPONENTS filter)
# Each library is a component with an export file of its own, so that asking for the filter needs Eigen alone.
include(CMakePackageConfigHelpers)
set(limber_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/limber)
get_property(limber_components GLOBAL PROPERTY LIMBER_COMPONENTS)

# The package that find_dependency() must find for a library that a component links.
function(limber_package_of library out)
  if(library STREQUAL "Eigen3::Eigen")
    set(package Eigen3)
  elseif(library MATCHES "^opencv_")
    set(package OpenCV)
  elseif(library STREQUAL "yaml-cpp")
    set(package yaml-cpp)
  elseif(library MATCHES "^(fmt|spdlog|nlohmann_json|CLI11|TBB|MPI|Threads)::")
    set(package ${CMAKE_MATCH_1})
  elseif(library STREQUAL "${LIMBER_CERES_LIBRARY}")
    set(package "")  # a file, not a package
  elseif(library STREQUAL "SQLiteCpp")
    set(package SQLiteCpp)
  elseif(library MATCHES "^(BZip2|PNG|TIFF|ZLIB)::")
    set(package ${CMAKE_MATCH_1})
  elseif(library MATCHES "^(lz4|zstd|deflate|spng|turbojpeg|cpp-httplib)$")
    set(package "")  # plain libraries
  else()
    message(FATAL_ERROR "Name the package of '${library}' in cmake/LimberInstall.cmake: "
                        "an installed component links it.")
  endif()
  set(${out} ${package} PARENT_SCOPE)
endfunction()

# For each component the components and packages to load before it; src/CMakeLists.txt adds the lower ones first.
set(limber_component_table "")
foreach(component IN LISTS limber_components)
  set(needs_${component} "")
  set(packages_${component} "")
  get_target_property(libraries limber_${component} LINK_LIBRARIES)
  foreach(library IN LISTS libraries)
    if(library MATCHES "^limber(::|_)(.+)$")
      list(APPEND needs_${component} ${needs_${CMAKE_MATCH_2}})
      list(APPEND packages_${component} ${packages_${CMAKE_MATCH_2}})
    elseif(library)
      limber_package_of(${library} package)
      list(APPEND packages_${component} ${package})
    endif()
  endforeach()
  list(APPEND needs_${component} ${component})
  list(REMOVE_DUPLICATES needs_${component})
  list(REMOVE_DUPLICATES packages_${component})
  string(APPEND limber_component_table "set(_limber_${component}_components ${needs_${component}})\n"
         "set(_limber_${component}_packages ${packages_${component}})\n")

  install(TARGETS limber_${component} EXPORT limber_${component} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          COMPONENT development)
  install(
    EXPORT limber_${component}
    FILE limber_${component}.cmake
    NAMESPACE limber::
    DESTINATION ${limber_package_dir}
    COMPONENT development)
  if(NOT component STREQUAL "filter")
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/limber/${component}
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/limber COMPONENT development)
  endif()
endforeach()

# The filter's headers, in the order of the data.
foreach(room core sensors predict measure state landmarks stack update health navigate initialize)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/limber/${room} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/limber
          COMPONENT development)
endforeach()

if(TARGET limber)
  install(TARGETS limber RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  install(FILES ${PROJECT_SOURCE_DIR}/apps/limber.bash DESTINATION share/bash-completion/completions RENAME limber
          COMPONENT program)
  find_program(LIMBER_HELP2MAN help2man)
  mark_as_advanced(LIMBER_HELP2MAN)
  if(LIMBER_HELP2MAN)
    set(pages ${PROJECT_BINARY_DIR}/man)
    add_custom_command(
      OUTPUT ${pages}/limber.1.gz
      COMMAND ${PROJECT_SOURCE_DIR}/cmake/man_pages.sh $<TARGET_FILE:limber> ${PROJECT_VERSION} ${pages}
      DEPENDS limber ${PROJECT_SOURCE_DIR}/cmake/man_pages.sh
      COMMENT "Making manual pages"
      VERBATIM)
    add_custom_target(limber_man_pages ALL DEPENDS ${pages}/limber.1.gz)
    install(DIRECTORY ${pages}/ DESTINATION share/man/man1 COMPONENT program FILES_MATCHING PATTERN *.1.gz)
  endif()
endif()
if(LIMBER_BUILD_PYTHON)
  set(LIMBER_PYTHON_DIR lib/python3/dist-packages CACHE STRING "Where the Python module is installed, below the prefix")
  install(DIRECTORY ${PROJECT_BINARY_DIR}/python/limber DESTINATION ${LIMBER_PYTHON_DIR} COMPONENT python
          PATTERN __pycache__ EXCLUDE PATTERN *.so EXCLUDE)
  install(TARGETS limber_python LIBRARY DESTINATION ${LIMBER_PYTHON_DIR}/limber COMPONENT python)
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/limberConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/limberConfig.cmake INSTALL_DESTINATION ${limber_package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/limberConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/limberConfig.cmake ${PROJECT_BINARY_DIR}/limberConfigVersion.cmake
        DESTINATION ${limber_package_dir} COMPONENT development)
include(LimberPackages)
