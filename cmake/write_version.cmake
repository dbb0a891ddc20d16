# SPDX-License-Identifier: MIT
# cmake -P script: writes the commit of SOURCE_DIR to the header OUT, if it is another than before.
cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty=+ --abbrev=10 --exclude=* OUTPUT_VARIABLE commit
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT "#define LIMBER_COMMIT \"@commit@\"\n" @ONLY)
