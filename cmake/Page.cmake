# SPDX-License-Identifier: Apache-2.0
# The page of `collinea serve`: npm makes web/, and what it becomes is put into a library.
option(COLLINEA_PAGE "Build the page of `collinea serve` (nodejs and npm; npm fetches what web/package-lock.json names)" ON)

# collinea_page(<target>): page_file() of serve/internal/page.h becomes part of the target.
function(collinea_page target)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/page_files.cc)
  set(embed ${PROJECT_SOURCE_DIR}/cmake/page_files.py)
  set(made ${CMAKE_CURRENT_BINARY_DIR}/page)
  if(COLLINEA_PAGE)
    set(web ${PROJECT_SOURCE_DIR}/web)
    find_program(COLLINEA_NPM npm)
    find_program(COLLINEA_NODE node)
    if(NOT COLLINEA_NPM OR NOT COLLINEA_NODE)
      message(FATAL_ERROR "npm or node is missing: tools/setup.sh installs it. Without the page: -DCOLLINEA_PAGE=OFF")
    endif()
    # Installed once for all builds of this working copy, again only when what is asked for changes.
    set(installed ${web}/node_modules/.installed)
    add_custom_command(OUTPUT ${installed} DEPENDS ${web}/package-lock.json WORKING_DIRECTORY ${web}
                       COMMAND ${COLLINEA_NPM} ci --ignore-scripts --no-audit --no-fund --no-update-notifier --loglevel=error
                       COMMAND ${CMAKE_COMMAND} -E touch ${installed}
                       COMMENT "Installing what the page is built with" VERBATIM)
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${web}/src/* ${web}/public/*)
    list(FILTER sources EXCLUDE REGEX "\\.test\\.ts$")
    list(APPEND sources ${web}/index.html ${web}/package.json ${web}/vite.config.ts ${web}/svelte.config.js ${web}/tsconfig.json)
    add_custom_command(OUTPUT ${source} DEPENDS ${sources} ${installed} ${embed} WORKING_DIRECTORY ${web}
                       COMMAND ${COLLINEA_NPM} run --silent build -- --outDir ${made} --emptyOutDir --logLevel warn
                       COMMAND ${Python3_EXECUTABLE} ${embed} ${made} ${source}
                       COMMENT "Building the page" VERBATIM)
  else()
    file(CONFIGURE OUTPUT ${made}/index.html CONTENT
         "<!doctype html><meta charset=\"utf-8\"><title>collinea</title><p>This program was built without its page.\n")
    add_custom_command(OUTPUT ${source} DEPENDS ${embed} COMMAND ${Python3_EXECUTABLE} ${embed} ${made} ${source} VERBATIM)
  endif()
  add_library(collinea_page_files OBJECT ${source})  # of its own: it waits for no other library
  target_include_directories(collinea_page_files PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(collinea_page_files PRIVATE collinea_settings)
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:collinea_page_files>)
endfunction()

# Tests of the page: its types, its pure functions, and the whole in a browser where there is one.
function(collinea_page_tests)
  if(NOT COLLINEA_PAGE)
    return()
  endif()
  set(web ${PROJECT_SOURCE_DIR}/web)
  add_test(NAME web/types COMMAND ${COLLINEA_NPM} run --silent check WORKING_DIRECTORY ${web})
  add_test(NAME web/units COMMAND ${COLLINEA_NPM} run --silent unit WORKING_DIRECTORY ${web})
  add_test(NAME web/page COMMAND ${COLLINEA_NODE} test/page.mjs $<TARGET_FILE:collinea> ${PROJECT_BINARY_DIR}/web-test WORKING_DIRECTORY ${web})
  add_test(NAME web/views COMMAND ${COLLINEA_NODE} test/views.mjs ${PROJECT_BINARY_DIR}/web-views WORKING_DIRECTORY ${web})
  set_tests_properties(web/page web/views PROPERTIES SKIP_RETURN_CODE 77)
endfunction()
