# SPDX-License-Identifier: MIT
# Debian packages by CPack: limber (program), liblimber-dev (headers, libraries), python3-limber. scripts/package.sh makes
# them for any processor of the architecture.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME limber)
set(CPACK_PACKAGE_VENDOR limber)
set(LIMBER_PACKAGER "limber developers <limber@example.org>"
    CACHE STRING "Who makes the Debian packages: name <mail>")
set(CPACK_PACKAGE_CONTACT "${LIMBER_PACKAGER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENTS_ALL program development)
set(limber_long "limber estimates the motion of two cameras whose mutual calibration has
gone wrong, with a linearly constrained extended Kalman filter.")

# limber_package(<component> <package> <section> <summary>)
function(limber_package component package section summary)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${limber_long}" PARENT_SCOPE)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/${package} RENAME copyright COMPONENT ${component})
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  set(log ${PROJECT_BINARY_DIR}/packages/${package}/changelog)
  file(WRITE ${log} "limber (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * See CHANGELOG.md of the sources.\n\n"
                    " -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  execute_process(COMMAND gzip -9nf ${log})
  install(FILES ${log}.gz DESTINATION share/doc/${package} COMPONENT ${component} OPTIONAL)
endfunction()

limber_package(program limber science "Stereo navigation for rigs that bend: program")
limber_package(development liblimber-dev libdevel "Stereo navigation for rigs that bend: C++ library")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS libeigen3-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS
    "libopencv-dev, libpng-dev, libspng-dev, libtiff-dev, libturbojpeg0-dev, libdeflate-dev, libbz2-dev, liblz4-dev, libzstd-dev, zlib1g-dev, libyaml-cpp-dev, libfmt-dev, nlohmann-json3-dev, libsqlitecpp-dev, libtbb-dev, libceres-dev, libcpp-httplib-dev")
if(LIMBER_BUILD_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  limber_package(python python3-limber python "Stereo navigation for rigs that bend: Python module")
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), \
python3 (<< ${Python_VERSION_MAJOR}.${next}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-matplotlib)
endif()
include(CPack)
