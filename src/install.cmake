# What `cmake --install` puts where, and how outside projects find it: by CMake's find_package(fathom) and by
# pkg-config. The installation may be moved as a whole.
include(CMakePackageConfigHelpers)

install(TARGETS fathom EXPORT fathom LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/fathom DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
if(TARGET fathom_cli)
  install(TARGETS fathom_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(DIRECTORY report DESTINATION ${CMAKE_INSTALL_DATADIR}/fathom FILES_MATCHING PATTERN "*.py" PATTERN "*.css")
endif()
install(FILES ${PROJECT_SOURCE_DIR}/scenes/fathom.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/fathom)

set(fathom_package ${CMAKE_INSTALL_LIBDIR}/cmake/fathom)
install(EXPORT fathom NAMESPACE fathom:: FILE fathomConfig.cmake DESTINATION ${fathom_package})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${CMAKE_BINARY_DIR}/fathomConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/fathomConfigVersion.cmake DESTINATION ${fathom_package})

file(RELATIVE_PATH fathom_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(fathom.pc.in ${CMAKE_BINARY_DIR}/fathom.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/fathom.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
