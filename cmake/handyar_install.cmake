# What `cmake --install` gives to developers: libraries and headers, and files by which CMake
# (find_package(handyar COMPONENTS core io calibration world)) and pkg-config find them. A room's own
# CMakeLists.txt says handyar_install_room(); programs and their pages are installed where they are
# made.
#
# Everything belongs to a component, of which cmake/handyar_packages.cmake makes Debian packages:
# `library` is what programs need to run, `development` what is needed to build them, `program` the
# command line, `markers` what it loads to find them.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/handyar)
file(RELATIVE_PATH pc_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})

# handyar_install_component(NAME target...): the targets, which find_package() gives for NAME.
function(handyar_install_component component)
  install(TARGETS ${ARGN} EXPORT handyar_${component}_targets
    LIBRARY COMPONENT library NAMELINK_COMPONENT development
    ARCHIVE COMPONENT development)
  install(EXPORT handyar_${component}_targets
    NAMESPACE handyar::
    FILE handyar-${component}-targets.cmake
    DESTINATION ${package_dir}
    COMPONENT development)
endfunction()

# handyar_install_room(NAME DESCRIPTION text REQUIRES package LIBS flags [ROOMS room...]): the library
# of the room whose CMakeLists.txt says so, with those of the other rooms named, as a component;
# `package` and `flags` are for pkg-config.
function(handyar_install_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "" "DESCRIPTION;REQUIRES;LIBS" "ROOMS")
  set(targets ${room_ROOMS})
  list(TRANSFORM targets PREPEND handyar_)
  handyar_install_component(${name} handyar_${name} ${targets})
  foreach(room ${name} ${room_ROOMS})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${room}/include/
      DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
  endforeach()
  get_target_property(opencv_headers opencv_core INTERFACE_INCLUDE_DIRECTORIES)
  handyar_install_pc(handyar-${name} "${room_DESCRIPTION}" ${room_REQUIRES}
    "-isystem ${opencv_headers}" "${room_LIBS}")  # OpenCV warns of itself in C++20
endfunction()

function(handyar_install_pc name description requires cflags libs)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/handyar.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endfunction()

set(core_targets handyar_core handyar_static)
if(TARGET handyar_shared)
  list(APPEND core_targets handyar_shared)
endif()
handyar_install_component(core ${core_targets})
handyar_install_pc(handyar ${PROJECT_DESCRIPTION} "eigen3 >= 3.4" "" -lhandyar)
install(DIRECTORY include/handyar DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(FILES bindings/c/handyar.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)

configure_package_config_file(cmake/handyarConfig.cmake.in handyarConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(handyarConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/handyarConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/handyarConfigVersion.cmake
  cmake/FindOpenCV.cmake
  DESTINATION ${package_dir} COMPONENT development)
