# SPDX-License-Identifier: Apache-2.0
# What makes the whole program cheap to build: foreign headers read once (precompiled), several files compiled as one (unity),
# and a compiler cache that all working copies share. None of it changes a bit of what is computed.

# The cache takes paths below the project as relative, so that another working copy of the same text finds what this one left.
# It asks the compiler what was read (CCACHE_DEPEND) instead of preprocessing every file once more: an empty cache costs nothing.
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}
      CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_NOHASHDIR=1 CCACHE_DEPEND=1 ${CCACHE})
endif()

# A library whose only purpose is the precompiled header that others take over.
function(collinea_precompiled_header target header)
  file(CONFIGURE OUTPUT ${target}.cc CONTENT "// Nothing but the precompiled header.\n")
  add_library(${target} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${target}.cc)
  target_link_libraries(${target} PRIVATE collinea_settings Eigen3::Eigen fmt::fmt Threads::Threads ${ARGN})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_precompile_headers(${target} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/${header})
endfunction()

# Where the sources lie, for tests that read the manual or shared data; one object, so that no test depends on the place.
function(collinea_add_source_tree)
  file(CONFIGURE OUTPUT source_tree.cc CONTENT
       "#include \"collinea/base/source_tree.h\"\nconst char* collinea::source_tree() { return \"${PROJECT_SOURCE_DIR}\"; }\n")
  add_library(collinea_source_tree OBJECT ${CMAKE_CURRENT_BINARY_DIR}/source_tree.cc)
  target_include_directories(collinea_source_tree PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(collinea_source_tree PRIVATE collinea_settings)
endfunction()

# Lets a target take over a precompiled header, and compiles its files in groups where no name of one is a word of another.
# Files compiled once for each processor by Highway read themselves again and again: they stay alone and read their own headers.
function(collinea_fast_build target precompiled)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # looks for free memory of its own only beyond 1 GB: a tenth of its time, for 0.2 GB more
    target_compile_options(${target} PRIVATE "SHELL:--param ggc-min-heapsize=1000000")
  endif()
  if(COLLINEA_PRECOMPILED)
    target_precompile_headers(${target} REUSE_FROM ${precompiled})
    set(kernels ${ARGN})
    list(FILTER kernels INCLUDE REGEX "\\.cc$")
    foreach(file IN LISTS kernels)
      file(STRINGS ${file} again REGEX "hwy/foreach_target\\.h" LIMIT_COUNT 1)
      if(again)
        set_source_files_properties(${file} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
      endif()
    endforeach()
  endif()
  if(COLLINEA_UNITY)
    set(files ${ARGN})
    list(FILTER files INCLUDE REGEX "\\.cc$")
    execute_process(COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/unity_groups.py ${COLLINEA_UNITY_SIZE} ${files}
                    OUTPUT_VARIABLE lines OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    string(REPLACE "\n" ";" lines "${lines}")
    foreach(line IN LISTS lines)
      string(REGEX MATCH "^([^ ]+) (.*)$" parts "${line}")
      set_source_files_properties(${CMAKE_MATCH_2} PROPERTIES UNITY_GROUP ${CMAKE_MATCH_1})
    endforeach()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)  # of types in what is here an included file
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})  # an edit may part a group
  endif()
endfunction()
