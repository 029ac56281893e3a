# SPDX-License-Identifier: Apache-2.0
# collinea_module(<name> [DEPS <module>...] [LIBS <target>...])
#   One folder = one library = one line of dependencies.
#   *.cc is the library, *_test.cc its tests, main.cc (where there is one) its program.
include(cmake/FastBuild.cmake)

function(collinea_module name)
  cmake_parse_arguments(ARG "" "" "DEPS;LIBS" ${ARGN})
  file(GLOB all CONFIGURE_DEPENDS *.h *.cc internal/*.h internal/*.cc)
  set(tests ${all})
  list(FILTER tests INCLUDE REGEX "_test\\.cc$")
  list(FILTER all EXCLUDE REGEX "(_test|_bench|/main)\\.cc$")
  list(TRANSFORM ARG_DEPS PREPEND collinea::)

  add_library(collinea_${name} STATIC ${all})
  add_library(collinea::${name} ALIAS collinea_${name})
  set_target_properties(collinea_${name} PROPERTIES LINKER_LANGUAGE CXX)
  target_include_directories(collinea_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(collinea_${name} PUBLIC collinea_settings ${ARG_DEPS} ${ARG_LIBS})
  collinea_fast_build(collinea_${name} collinea_precompiled ${all})

  if(COLLINEA_TESTS AND tests)
    add_executable(collinea_${name}_tests ${tests})
    target_link_libraries(collinea_${name}_tests PRIVATE collinea::${name} collinea_source_tree GTest::gtest_main)
    collinea_fast_build(collinea_${name}_tests collinea_precompiled_tests ${tests})
    gtest_discover_tests(collinea_${name}_tests TEST_PREFIX "${name}/" DISCOVERY_TIMEOUT 60)
  endif()
endfunction()
