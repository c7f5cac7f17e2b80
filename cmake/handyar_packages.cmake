# Debian packages, by `cpack` in a build of the preset `package`: libhandyar1 for programs to run,
# libhandyar-dev to build them, handyar the command line, handyar-markers and python3-handyar where
# they are built.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "the handyar authors")
set(CPACK_PACKAGE_CONTACT "The handyar authors <authors@handyar.invalid>")  # no mail is read
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL library development program)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

# handyar_package(COMPONENT NAME SECTION TEXT): what a component's package is called and says
# of itself; the copyright and the list of changes that every Debian package has go with it.
find_program(GZIP gzip REQUIRED)
set(changes ${PROJECT_BINARY_DIR}/changelog)
configure_file(cmake/debian/changelog.in ${changes} @ONLY)
execute_process(COMMAND ${GZIP} -9nf ${changes} COMMAND_ERROR_IS_FATAL ANY)
macro(handyar_package component name section text)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${what}\n.\n${text}")
  install(FILES ${changes}.gz cmake/debian/copyright
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endmacro()

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "augmented reality on a bare hand")
set(what "handyar finds an open hand in the pictures of one ordinary camera and tells its\nmetric pose, so that a 3-D object can stand on it like on a printed marker.")

handyar_package(library libhandyar1 libs
  "This package has the shared library, for C++ and C.")
# What CPack makes of a shared library calls ldconfig by itself; Debian's packages leave that to a
# trigger.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "libc6 (>= 2.36), libgcc-s1 (>= 3.0), libstdc++6 (>= 12)")
file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
file(WRITE ${PROJECT_BINARY_DIR}/debian/shlibs
  "libhandyar ${PROJECT_VERSION_MAJOR} libhandyar1 (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA
  "${PROJECT_BINARY_DIR}/debian/triggers;${PROJECT_BINARY_DIR}/debian/shlibs")

handyar_package(development libhandyar-dev libdevel
  "This package has what is needed to build programs with it.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libhandyar1 (= ${PROJECT_VERSION}), libeigen3-dev (>= 3.4)")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS  # of the components io, calibration and world
  "libopencv-calib3d-dev, libopencv-video-dev, nlohmann-json3-dev, libavformat-dev, libavcodec-dev, libavutil-dev, libswscale-dev, pkg-config")

handyar_package(program handyar graphics
  "This package has the command line: from a video or a webcam to poses, an\nannotated video or a window.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libegl1, libgl1-mesa-dri")  # libepoxy opens them itself

if(TARGET handyar_markers)
  list(APPEND CPACK_COMPONENTS_ALL markers)
  handyar_package(markers handyar-markers graphics
    "This package lets the command line find printed markers, for its commands inspect\nand evaluate.")
  set(CPACK_DEBIAN_MARKERS_PACKAGE_DEPENDS "handyar (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "handyar-markers, gnuplot-nox")  # a report's figures
endif()

if(TARGET python__core)
  list(APPEND CPACK_COMPONENTS_ALL python)
  handyar_package(python python3-handyar python "This package has the module for Python 3.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "handyar (= ${PROJECT_VERSION}), python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-opencv, python3-matplotlib")  # of its examples
endif()
include(CPack)
