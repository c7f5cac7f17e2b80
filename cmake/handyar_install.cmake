# What `cmake --install` gives to developers: the core library, its headers, and files by which
# CMake (find_package(handyar), target handyar::core) and pkg-config (handyar) find them.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/handyar)

install(TARGETS handyar_core handyar_static EXPORT handyar_targets)
if(TARGET handyar_shared)
  install(TARGETS handyar_shared EXPORT handyar_targets)
endif()
install(DIRECTORY include/handyar DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES bindings/c/handyar.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT handyar_targets
  NAMESPACE handyar::
  FILE handyarTargets.cmake
  DESTINATION ${package_dir})

configure_package_config_file(cmake/handyarConfig.cmake.in handyarConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(handyarConfigVersion.cmake COMPATIBILITY SameMajorVersion)
file(RELATIVE_PATH pc_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/handyar.pc.in handyar.pc @ONLY)

install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/handyarConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/handyarConfigVersion.cmake
  DESTINATION ${package_dir})
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/handyar.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
