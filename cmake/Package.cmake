# SPDX-License-Identifier: Apache-2.0
# What is installed, and the Debian package: the program, the demo, man pages, completion for bash, the manual. `make documents`
# makes the man pages and the completion with the program itself.
include(GNUInstallDirs)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # installing asks for the program, not for the tests

install(TARGETS collinea RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(PROGRAMS tools/demo.sh DESTINATION ${CMAKE_INSTALL_BINDIR} RENAME collinea-demo)
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/man DESTINATION ${CMAKE_INSTALL_DATAROOTDIR} OPTIONAL)
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/bash-completion DESTINATION ${CMAKE_INSTALL_DATAROOTDIR} OPTIONAL)
install(FILES README.md CHANGELOG.md LICENSE cmake/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs/manual docs/theory DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN "*.md")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME collinea)
set(CPACK_PACKAGE_CONTACT "collinea developers <collinea@localhost>")
set(CPACK_PACKAGE_VENDOR collinea)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "photographs to maps, with standard deviations")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
    "Photographs (drone, aerial, hand-held) and survey control go in; oriented images, a point cloud, surface and terrain models, an orthophoto and a quality report come out.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS proj-data)
include(CPack)
